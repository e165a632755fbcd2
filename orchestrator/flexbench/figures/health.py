"""Draw the health of the estimator: NIS and NEES with their bounds, NEES over time, whiteness of the innovations."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..studies.health.analysis import Health
from ..studies.health.statistics import Average
from .drawing import STYLE, WIDTH, envelope
from .palette import BLUE, VERMILLION

LEAST = 1e-3  # of the logarithmic axis: what lies below is drawn at its edge, with its value next to it
GREY = "0.55"


def estimator_health(health: Health) -> Figure:
    """Draw four panels: NIS by sensor, NEES by state, NEES over time, autocorrelation of the innovations."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 6.4), layout="constrained")
        panels = figure.subplots(2, 2)
        seeds = f"{len(health.seeds)} seed{'s' if len(health.seeds) > 1 else ''}"
        _averages(panels[0, 0], health.innovation, "normalised innovation squared (NIS)")
        _averages(panels[0, 1], health.error, f"normalised estimation error squared (NEES), {seeds}")
        _history(panels[1, 0], health)
        _whiteness(panels[1, 1], health)
        which = (
            f"seed {health.seeds[0]}" if len(health.seeds) == 1 else f"seeds {health.seeds[0]} to {health.seeds[-1]}"
        )
        figure.suptitle(f"{health.configuration}, {which}", fontsize=10)
    return figure


def _averages(panel: Axes, averages: Mapping[str, Average], title: str) -> None:
    """Draw a mark for each average, over a bar for the 95 % interval of a consistent filter."""
    for row, average in enumerate(averages.values()):
        panel.plot([average.low, average.high], [row, row], color=GREY, linewidth=6, solid_capstyle="butt", alpha=0.6)
        inside = average.low <= average.value <= average.high
        panel.plot(max(average.value, LEAST), row, "o" if inside else "D", color=BLUE if inside else VERMILLION)
        panel.annotate(f"{average.value:.2g}", (max(average.value, LEAST), row), (0, 6), textcoords="offset points",
                       ha="center", fontsize=7.5)  # fmt: skip
    panel.set_xscale("log")
    panel.set_xlim(0.7 * LEAST, 10.0)
    panel.axvline(1.0, color="black", linewidth=0.8)
    panel.set_yticks(range(len(averages)), list(averages))
    panel.set_ylim(len(averages) - 0.4, -0.8)
    panel.set_xlabel("average per degree of freedom [1]; bar: 95 % if consistent")
    panel.set_title(title)


def _history(panel: Axes, health: Health) -> None:
    time, values = envelope(health.history[:, 0], health.history[:, 1])
    panel.plot(time, values, color=BLUE, linewidth=0.8, label="mean over the seeds")
    bound = health.error["all"]
    panel.axhspan(bound.low, bound.high, color=GREY, alpha=0.35, label="95 % if consistent")
    panel.set_yscale("log")
    panel.set_xlabel("time [s]")
    panel.set_ylabel("NEES / states [1]")
    panel.set_title(f"NEES of all {bound.freedom} states")
    panel.legend(loc="lower right")


def _whiteness(panel: Axes, health: Health) -> None:
    white = health.whiteness
    lags = np.arange(1, len(white.correlation) + 1)
    panel.fill_between(
        lags, white.correlation.min(axis=1), white.correlation.max(axis=1), color=BLUE, alpha=0.25, linewidth=0,
        label=f"all {white.correlation.shape[1]} channels",
    )  # fmt: skip
    panel.plot(lags, np.median(white.correlation, axis=1), color=BLUE, linewidth=1.0, label="median")
    for sign in (-1.0, 1.0):
        label = "95 % if white" if sign > 0 else None
        panel.axhline(sign * white.bound, color=VERMILLION, linestyle="--", linewidth=0.9, label=label)
    panel.set_xlabel("lag [controller steps]")
    panel.set_ylabel("autocorrelation [1]")
    panel.set_title(f"innovations: {100 * white.outside:.0f} % of the lags beyond the bound")
    panel.legend(loc="upper right")
