"""Deformation over wheel speed, measured in a sweep of co-simulations, over the linear Campbell diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from flexbench.studies.waterfall.crossings import Crossing
from flexbench.studies.waterfall.sweep import Waterfall, predict
from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.parameters import RPM
from flexsat.spacecraft.campbell_crossings import modal_frequencies

from .drawing import LOOKS, STYLE, WIDTH
from .palette import PURPLE, SKY_BLUE, VERMILLION

COLOURS = "cividis"
DECADES = 6.0  # of the density's root, below its peak: 3 decades
HARMONIC, FLAGGED, BAND = PURPLE, VERMILLION, SKY_BLUE
FINE = 600  # speeds of the linear prediction
ABOVE = 1.15  # of the highest harmonic: the frequencies shown


def waterfall_figure(result: Waterfall, design: Design) -> Figure:
    """Draw density over speed and frequency with modes, harmonic, allowed bands and crossings; below, the RMS.

    Crossings in an allowed band are filled and named, the others are rings.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 7.2), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (2.0, 1.0)})
        _draw_density(figure, upper, result)
        _draw_modes(upper, result, design)
        _draw_crossings(upper, result.crossings)
        _draw_rms(lower, result, design)
        for low, high in allowed_bands(design):
            lower.axvspan(low / RPM, high / RPM, color=BAND, alpha=0.25, linewidth=0.0)
        figure.suptitle(
            f"{result.configuration}, seed {result.seed}: runs of {result.stop:g} s, all at one speed, loop open",
            fontsize=9.0,
        )
    return figure


def allowed_bands(design: Design) -> list[tuple[float, float]]:
    """Return the union of the wheels' allowed bands [rad/s], lowest first."""
    nominal, band = design.response.nominal, design.config.wheel_set.speed_band
    joined: list[tuple[float, float]] = []
    for low, high in sorted(zip((nominal - band).tolist(), (nominal + band).tolist(), strict=True)):
        if joined and low <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def _draw_density(figure: Figure, axes: Axes, result: Waterfall) -> None:
    shown = result.frequency <= ABOVE * result.speed[-1] / (2.0 * np.pi)
    root = 1e6 * np.sqrt(result.density[shown])
    largest = float(root.max())
    if not largest > 0.0:
        largest = 1.0
    mesh = axes.pcolormesh(
        result.speed / RPM, result.frequency[shown], np.maximum(root, 1e-30),
        norm=LogNorm(largest * 10.0 ** (-0.5 * DECADES), largest), cmap=COLOURS, shading="nearest", rasterized=True,
    )  # fmt: skip
    bar = figure.colorbar(mesh, ax=axes, pad=0.01, extend="min")
    bar.set_label("root of the deformation's density [µm/√Hz]")
    axes.set(ylabel="frequency [Hz]", ylim=(0.0, float(result.frequency[shown][-1])),
             xlim=(result.speed[0] / RPM, result.speed[-1] / RPM))  # fmt: skip
    axes.grid(visible=False)


def _draw_modes(axes: Axes, result: Waterfall, design: Design) -> None:
    speed = np.linspace(result.speed[0], result.speed[-1], 40)
    highest = 2.0 * np.pi * float(result.frequency[-1])
    for number, mode in enumerate(modal_frequencies(design.structure, speed, highest) / (2.0 * np.pi)):
        label = "mode of the free spacecraft" if number == 0 else None
        axes.plot(speed / RPM, mode, color="white", linewidth=0.5, alpha=0.75, label=label)
    axes.plot(speed / RPM, speed / (2.0 * np.pi), color=HARMONIC, linewidth=1.2, linestyle=(0.0, (4.0, 1.3)),
              label="first harmonic")  # fmt: skip
    for k, (low, high) in enumerate(allowed_bands(design)):
        edge = np.array([low, high])
        axes.plot(edge / RPM, edge / (2.0 * np.pi), color=BAND, linewidth=4.0, alpha=0.8, solid_capstyle="butt",
                  label="allowed band" if k == 0 else None)  # fmt: skip


def _draw_crossings(axes: Axes, crossings: Sequence[Crossing]) -> None:
    marks: tuple[tuple[bool, dict[str, Any]], ...] = (
        (False, {"markerfacecolor": "none", "markeredgecolor": "white", "markersize": 5.0, "marker": "o"}),
        (True, {"markerfacecolor": FLAGGED, "markeredgecolor": "white", "markersize": 8.0, "marker": "X"}),
    )
    for flagged, style in marks:
        speeds = np.array([crossing.speed for crossing in crossings if crossing.flagged == flagged])
        label = "crossing inside an allowed band" if flagged else "crossing outside"
        axes.plot(speeds / RPM, speeds / (2.0 * np.pi), linestyle="none", label=label, **style)
    legend = axes.legend(loc="upper left", facecolor="0.2", frameon=True, framealpha=0.6, fontsize=7.5)
    for text in legend.get_texts():
        text.set_color("white")


def _draw_rms(axes: Axes, result: Waterfall, design: Design) -> None:
    fine = np.linspace(result.speed[0], result.speed[-1], FINE)
    predicted: Array = predict(design, fine)
    look = LOOKS["centralised"]
    axes.plot(fine / RPM, 1e6 * predicted, color="0.5", linewidth=0.8, label="linear, steady, first harmonic")
    axes.plot(result.speed / RPM, 1e6 * result.rms, color=look.colour, marker="o", markersize=3.5, linewidth=0.8,
              label="co-simulation, second half of each run")  # fmt: skip
    axes.set(yscale="log", xlabel="wheel speed [rpm]", ylabel="RMS deformation [µm]")
    axes.legend(loc="lower right", fontsize=7.5)
