"""Modes and response of the free spacecraft over wheel speed: the Campbell diagram."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from flexbench.studies.waterfall.campbell import (
    Campbell,
    campbell,
    harmonic_deformation,
)
from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.parameters import HERTZ, RPM, ConfigurationName
from flexsat.spacecraft.assembly import Spacecraft
from flexsat.spacecraft.campbell_crossings import modal_frequencies
from lockstep.errors import InputError

from .drawing import AXES, MICROMETRE, STYLE, WIDTH, axis_name
from .palette import PURPLE

FASTEST = 1000.0 * RPM  # rad/s: beyond every chosen speed
MAP_SPEEDS = FASTEST * np.linspace(0.1, 1.0, 24) ** 2
HARMONIC_SPEEDS = np.arange(5.0, 1001.0) * RPM  # a resonance at half a percent of damping is 5 rpm wide
EVEN, NEAR = 400, np.array([-0.012, -0.005, -0.002, 0.0, 0.002, 0.005, 0.012])  # of the map's frequencies
COLOURS = "cividis"  # for the colour-blind; lightness grows with the value
DECADES = 5.0  # of the colours
LEAST = 3e-4  # µm, at the first harmonic
SAME = 0.002  # of a decade: wheels whose responses differ by less are drawn once
FIRST: dict[str, Any] = {"color": PURPLE, "linewidth": 1.8}
MODE: dict[str, Any] = {"color": "white", "linewidth": 0.45, "alpha": 0.7}
SIZES = {"x": 8.5, "y": 6.5, "z": 5.5}  # points: wheels about different axes have chosen the same speed
MARK: dict[str, Any] = {"linestyle": "none", "markeredgecolor": "white", "markeredgewidth": 0.6}
GAP: dict[str, Any] = {"linestyle": "none", "marker": "|", "markersize": 11.0, "markeredgewidth": 1.4, "zorder": 3.8}
NOT_SEARCHED: dict[str, Any] = {"facecolor": "none", "edgecolor": "0.75", "hatch": "////", "linewidth": 0.0}


def campbell_diagram(designs: Mapping[ConfigurationName, Design]) -> Figure:
    """Draw modes, response and first harmonic over wheel speed, and the response along the harmonic.

    Above, colour is the deformation that the imbalance of one wheel would make if its force and torque at that speed
    acted at that frequency, for the wheel where it is largest; the first harmonic acts on its line, on which the
    wheels' chosen speeds and allowed bands stand, and the crossings either side of bands that avoid them. Below, what
    it makes there, wheel by wheel. All wheels turn at the same speed, for the gyroscopic terms.

    Parameters
    ----------
    designs : by configuration

    Raises
    ------
    InputError
        If there are no designs.
    """
    if not designs:
        raise InputError("campbell_diagram: designs must hold one configuration at least, got none")
    maps = {
        name: campbell(design.structure, MAP_SPEEDS, _frequencies(design.structure)) for name, design in designs.items()
    }
    largest = max(float(result.response.max()) for result in maps.values()) / MICROMETRE
    colours = LogNorm(largest * 10.0**-DECADES, largest)
    with matplotlib.rc_context(STYLE | {"hatch.linewidth": 0.5}):
        figure = Figure(figsize=(WIDTH if len(designs) > 1 else 0.6 * WIDTH, 7.0), layout="constrained")
        grid = figure.subplots(
            2, len(designs), squeeze=False, sharex=True, sharey="row", gridspec_kw={"height_ratios": (1.6, 1.0)}
        )
        for (upper, lower), (name, design) in zip(grid.T, designs.items(), strict=True):
            _draw_map(upper, maps[name], colours)
            _draw_first_harmonic(lower, design)
            _draw_chosen(upper, lower, design)
            upper.set_title(name)
            lower.set_xlabel("wheel speed [rpm]")
        grid[0, 0].set_ylabel("frequency [Hz]")
        grid[1, 0].set_ylabel("at the first harmonic, one wheel:\nRMS deformation [µm]")
        grid[1, 0].set_ylim(LEAST, 1.5 * max(axes.dataLim.y1 for axes in grid[1]))
        bar = figure.colorbar(ScalarMappable(colours, COLOURS), ax=grid[0].tolist(), pad=0.01, aspect=30, extend="min")
        bar.set_label("RMS deformation, worst wheel [µm]")
        figure.legend(
            handles=_legend(next(iter(designs.values()))), loc="outside upper center", ncols=min(3, 1 + len(designs))
        )
    return figure


def _frequencies(spacecraft: Spacecraft) -> Array:
    """Return where to compute the map, (f,) [rad/s]: evenly, and close by the modes."""
    modes = modal_frequencies(spacecraft, MAP_SPEEDS[:1], FASTEST)[:, 0]
    close = (modes[:, None] * (1.0 + NEAR)).ravel()
    return np.unique(np.concatenate([np.linspace(0.05 * HERTZ, FASTEST, EVEN), close]))


def _draw_map(axes: Axes, result: Campbell, colours: LogNorm) -> None:
    speed, frequency = result.speed / RPM, result.frequency / HERTZ
    axes.pcolormesh(
        speed, frequency, result.response / MICROMETRE, norm=colours, cmap=COLOURS, shading="gouraud", rasterized=True
    )
    for number, mode in enumerate(result.modes / HERTZ):
        axes.plot(speed, mode, label=f"mode {number + 1}", **MODE)
    ends = np.array([0.0, FASTEST / RPM])
    axes.plot(ends, ends / 60.0, label="first harmonic", **FIRST)
    axes.set(xlim=(0.0, FASTEST / RPM), ylim=(0.0, FASTEST / HERTZ), facecolor=matplotlib.colormaps[COLOURS](0.0))
    axes.grid(visible=False)
    axes.xaxis.set_major_locator(MultipleLocator(200.0))


def _draw_first_harmonic(axes: Axes, design: Design) -> None:
    response = harmonic_deformation(design.structure, HARMONIC_SPEEDS) / MICROMETRE
    drawn: list[Array] = []
    for wheel, values in enumerate(response):
        decades = np.log10(values)
        if any(np.max(np.abs(decades - other)) < SAME for other in drawn):  # equal by symmetry
            continue
        drawn.append(decades)
        look = AXES[axis_name(design.spacecraft.wheels.axis[wheel])]
        axes.plot(HARMONIC_SPEEDS / RPM, values, color=look.colour, linewidth=0.7, label=f"wheel {wheel + 1}")
    axes.axvspan(0.0, design.config.speeds.lowest * 60.0, **NOT_SEARCHED)
    axes.set_yscale("log")


def _draw_chosen(upper: Axes, lower: Axes, design: Design) -> None:
    """Mark chosen speeds: on the harmonic with their bands, and below with the deformation of that wheel."""
    axis, nominal = design.spacecraft.wheels.axis, design.response.nominal
    bands = design.config.wheel_set.speed_band / RPM
    deformation = np.diagonal(harmonic_deformation(design.structure, nominal)) / MICROMETRE
    for name, look in AXES.items():
        wheels = np.flatnonzero([axis_name(one) == name for one in axis])
        speed, band = nominal[wheels] / RPM, bands[wheels]
        style = MARK | {"color": look.colour, "marker": look.marker, "markersize": SIZES[name], "zorder": 4.0}
        style["label"] = f"chosen, about {name}"
        upper.hlines(speed / 60.0, speed - band, speed + band, color=look.colour, linewidth=2.2, zorder=3.5)
        upper.plot(speed, speed / 60.0, **style)
        if design.response.gap is not None:
            ends = design.response.gap[wheels].ravel() / RPM
            upper.plot(ends, ends / 60.0, label=f"gap, about {name}", **(GAP | {"color": look.colour}))
        lower.plot(speed, deformation[wheels], **style)
        for value, width in sorted(set(zip(speed.tolist(), band.tolist(), strict=True))):
            lower.axvspan(value - width, value + width, color=look.colour, alpha=0.12, linewidth=0.0)


def _legend(design: Design) -> list[Line2D | Patch]:
    band, lowest = design.config.wheel_set.speed_band / RPM, design.config.speeds.lowest * 60.0
    chosen_band = f", ±{band[0]:.0f} rpm" if np.ptp(band) == 0.0 else " with their bands"
    line = MARK | {"linestyle": "-", "linewidth": 2.2, "markersize": 6.5}
    chosen = {name: line | {"color": look.colour, "marker": look.marker} for name, look in AXES.items()}
    return [
        *(Line2D([], [], label=f"wheels about {name}: chosen{chosen_band}", **look) for name, look in chosen.items()),
        Line2D([], [], label="first harmonic: Hz = rpm/60", **FIRST),
        Patch(label=f"below {lowest:.0f} rpm: not searched", **NOT_SEARCHED),
        Line2D([], [], label="mode of the free spacecraft", **(MODE | {"color": "0.6", "linewidth": 1.0})),
    ]
