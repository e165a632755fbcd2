"""The response of the modes to each wheel's imbalance, the speed and band chosen from it, and the controller's loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from flexsat.arrays import Array, Complex
from flexsat.design.chain import Design
from flexsat.parameters import RPM

from .drawing import AXES, STYLE, WIDTH, axis_name

COLUMNS = 5
SAME = 1e-6  # relative: wheels whose responses differ by less, and whose speeds are equal, share a panel
TICKS = (200.0, 500.0, 1000.0, 5000.0)  # rpm
SQUARE_HERTZ = (2.0 * np.pi) ** 2  # the response is for a speed in Hz times coefficients in (rad/s)^-2
RESPONSE: dict[str, Any] = {"color": "0.45", "linewidth": 0.8}
WORST: dict[str, Any] = {"linewidth": 1.6}
BAND: dict[str, Any] = {"alpha": 0.18, "linewidth": 0.0}
CHOSEN: dict[str, Any] = {"linewidth": 1.0, "linestyle": (0.0, (4.0, 1.3))}

LOOP_SHOWN = (1e-3, 10.0)  # of the loops' gains
LOWEST = 0.05  # Hz, shown
Loops = Mapping[str, tuple[Array, Complex]]  # by axis: frequency [Hz] and response of its open loop


def wheel_responses(design: Design) -> Figure:
    """Draw each wheel's response over wheel speed with its moving maximum, chosen speed and allowed band.

    Wheels with the same response, by symmetry, share a panel.

    Parameters
    ----------
    design : of one configuration
    """
    groups = equal_wheels(design)
    columns = min(COLUMNS, len(groups))
    rows = -(-len(groups) // columns)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.9 + 2.1 * max(rows, 1.4)), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        for position, axes in enumerate(grid.ravel()):
            if position < len(groups):
                _draw_group(axes, design, groups[position])
            else:
                axes.set_visible(False)
            if position + columns >= len(groups):  # nothing below
                axes.tick_params(labelbottom=True)
        grid[0, 0].set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
        for axis in (grid[0, 0].xaxis, grid[0, 0].yaxis):  # shared; minor ticks would take half the drawing time
            axis.set_minor_locator(NullLocator())
        figure.supxlabel("wheel speed [rpm]", fontsize=STYLE["axes.labelsize"])
        figure.supylabel(
            r"peak modal velocity at the first harmonic [m·kg$^{1/2}$/s]", fontsize=STYLE["axes.labelsize"]
        )
        figure.legend(handles=_legend(design), loc="outside upper center", ncols=4)
    return figure


def responses_over_loop(design: Design, flown: Loops, published: Loops, bandwidth: float | None) -> Figure:
    """Draw the wheels' responses and chosen speeds over frequency, and below them the gain of each body axis' loop.

    Parameters
    ----------
    design : of one configuration
    flown : open loops of its controller
    published : those of the published design on the modes that it knows; may be empty
    bandwidth : highest frequency at which the gain of a flown loop is 1 [Hz]; None if it is nowhere
    """
    result = design.response
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 5.6), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True)
        hertz = result.speed / (2.0 * np.pi)
        for first, *_ in equal_wheels(design):
            colour = AXES[axis_name(design.spacecraft.wheels.axis[first])].colour
            top.loglog(hertz, result.response[first] * SQUARE_HERTZ, color=colour, linewidth=0.7, alpha=0.6)
            top.axvline(result.nominal[first] / (2.0 * np.pi), color=colour, **CHOSEN)
        top.set(title="Response to the imbalance of each wheel; dashed: chosen speeds",
                ylabel=r"peak modal velocity [m·kg$^{1/2}$/s]")  # fmt: skip
        for axis, (frequency, values) in published.items():
            label = "as published, on the modes that it knows" if axis == "x" else None
            bottom.loglog(frequency, np.abs(values), color="0.7", linewidth=0.8, label=label)
        for axis, (frequency, values) in flown.items():
            bottom.loglog(frequency, np.abs(values), color=AXES[axis].colour, linewidth=1.2, label=f"flown, {axis}")
        bottom.axhline(1.0, color="black", linewidth=0.8)
        bottom.set(title="Gain of the open loop of each body axis", xlabel="frequency (wheels: turns per second) [Hz]",
                   ylabel="gain [1]", ylim=LOOP_SHOWN, xlim=(LOWEST, hertz[-1]))  # fmt: skip
        for axes in (top, bottom):
            if bandwidth is not None:
                axes.axvspan(LOWEST, bandwidth, color="0.3", alpha=0.1, linewidth=0.0)
            axes.xaxis.set_major_formatter("{x:g}")
        handles, labels = bottom.get_legend_handles_labels()
        if bandwidth is not None:
            handles.append(Patch(color="0.3", alpha=0.1))
            labels.append(f"up to where a gain is last 1: {bandwidth:.3g} Hz")
        figure.legend(handles, labels, loc="outside upper center", ncols=5)
    return figure


def equal_wheels(design: Design) -> list[list[int]]:
    """Group the wheels whose response and chosen speed are the same, each group in ascending order."""
    response, nominal, band = design.response.response, design.response.nominal, design.config.wheel_set.speed_band
    groups: list[list[int]] = []
    for wheel in range(len(nominal)):
        for group in groups:
            first = group[0]
            alike = nominal[first] == nominal[wheel] and band[first] == band[wheel]
            if alike and np.allclose(response[first], response[wheel], rtol=SAME, atol=0.0):
                group.append(wheel)
                break
        else:
            groups.append([wheel])
    return groups


def _draw_group(axes: Axes, design: Design, group: list[int]) -> None:
    result, first = design.response, group[0]
    speed, nominal = result.speed / RPM, result.nominal[first] / RPM
    band = design.config.wheel_set.speed_band[first] / RPM
    colour = AXES[axis_name(design.spacecraft.wheels.axis[first])].colour
    axes.axvspan(nominal - band, nominal + band, color=colour, **BAND)
    axes.axvline(nominal, color=colour, **CHOSEN)
    axes.plot(speed, result.response[first] * SQUARE_HERTZ, label="response", **RESPONSE)
    axes.plot(speed, result.worst[first] * SQUARE_HERTZ, label="worst", color=colour, **WORST)
    axes.set(xscale="log", yscale="log", xlim=(speed[0], speed[-1]))
    axes.set_title(f"{_where(design, group)}: {nominal:.0f} rpm\n{_numbers(group)}", fontsize=7.5)


def _where(design: Design, group: list[int]) -> str:
    wheels = design.spacecraft.wheels
    names = sorted({axis_name(wheels.axis[wheel]) for wheel in group})
    radii = sorted({round(float(np.linalg.norm(wheels.position[wheel])), 2) for wheel in group})
    where = " and ".join("on the bus" if radius == 0.0 else f"at {radius:.2f} m" for radius in radii)
    return f"about {', '.join(names)} {where}"


def _numbers(group: list[int]) -> str:
    return f"wheel{'s' if len(group) > 1 else ''} {', '.join(str(wheel + 1) for wheel in group)}"


def _legend(design: Design) -> list[Line2D | Patch]:
    window, band = design.config.speeds.window * 60.0, design.config.wheel_set.speed_band / RPM
    allowed = f"allowed: ±{band[0]:.0f} rpm" if np.ptp(band) == 0.0 else "allowed"
    return [
        Line2D([], [], label="response to its imbalance", **RESPONSE),
        Line2D([], [], label=f"its maximum over {window:.0f} rpm", color="black", **WORST),
        Line2D([], [], label="chosen speed: minimum of that maximum", color="black", **CHOSEN),
        Patch(label=allowed, color="0.3", **BAND),
    ]
