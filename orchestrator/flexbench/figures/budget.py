"""The pointing budget: the error over time with its windows, and the indices side by side."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexbench.studies.budget.evaluate import INDICES, Budget, ErrorHistory
from flexbench.studies.budget.indices import window_means
from flexsat.parameters import ARCSECOND

from .drawing import AXES, STYLE, WIDTH, draw_line

TOTAL = "0.25"  # of the line of sight
WIDE = 0.2  # of a bar


def budget_figure(history: ErrorHistory, budget: Budget) -> Figure:
    """Draw the error about each axis with the mean of each window, and RMS and levels of every index."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
        _draw_error(left, history, budget)
        _draw_indices(right, budget)
    return figure


def _draw_error(axes: Axes, history: ErrorHistory, budget: Budget) -> None:
    time = np.asarray(history.start + history.interval * np.arange(len(history.error)), dtype=float)
    samples = history.samples(budget.windows.window, "window")
    means = window_means(history.error, samples) / ARCSECOND
    edges = history.start + budget.windows.window * np.arange(len(means) + 1)
    for k, (name, look) in enumerate(AXES.items()):
        draw_line(axes, time, history.error[:, k] / ARCSECOND, name, {"color": look.colour, "linewidth": 0.5})
        axes.stairs(means[:, k], edges, color=look.colour, linewidth=1.8, baseline=None)
    axes.set(title=f"Pointing error, and its mean over {budget.windows.window:g} s", xlabel="time [s]",
             ylabel="rotation from reference [arcsec]")  # fmt: skip
    axes.legend(ncols=3)


def _draw_indices(axes: Axes, budget: Budget) -> None:
    names = [index for index in INDICES if budget.entry(index, "x") is not None]
    bars = [("x", AXES["x"].colour), ("y", AXES["y"].colour), ("z", AXES["z"].colour), ("line_of_sight", TOTAL)]
    level = max(budget.levels)
    for k, (axis, colour) in enumerate(bars):
        entries = [entry for entry in budget.entries if entry.axis == axis]
        place = np.arange(len(entries)) + (k - 1.5) * WIDE
        label = axis.replace("_", " ")
        axes.bar(place, [e.rms / ARCSECOND for e in entries], 0.9 * WIDE, color=colour, label=f"{label}: RMS")
        axes.plot(place, [e.levels[level] / ARCSECOND for e in entries], linestyle="none", marker="_", color=colour,
                  markersize=9.0, markeredgewidth=1.6)  # fmt: skip
    axes.plot([], [], linestyle="none", marker="_", color="0.4", label=f"{100.0 * level:g} %")
    axes.set_xticks(np.arange(len(names)), names)
    axes.set(title="Indices", ylabel="size [arcsec]")
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower right", ncols=5, fontsize=7.5)
