"""A shadow controller: torques of both, their residual, and the pointing error, with the hand-over marked."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexbench import histories
from flexbench.shadow.study import Study
from flexsat.parameters import ARCSECOND
from lockstep import Signals
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW

from .drawing import STYLE, WIDTH, draw_line, draw_noisy, make_logarithmic, span_runs

# Okabe and Ito (2008): blue, vermillion, bluish green, black
LINES = {"original": "#0072B2", "shadow": "#D55E00", "acting": "#000000", "residual": "#009E73"}


def shadow_figure(signals: Signals, found: Study) -> Figure:
    """Draw the output that differs most, the residuals' size over all, and the pointing error."""
    ride = found.ride
    worst = max(found.residuals, key=lambda residual: residual.rms).output
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 6.4), layout="constrained")
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        for kind, prefix, width in (("original", ORIGINAL, 0.9), ("shadow", SHADOW, 0.7), ("acting", "", 0.5)):
            draw_line(top, signals.time, signals[ride.name(prefix, worst)], kind,
                      {"color": LINES[kind], "linewidth": width})  # fmt: skip
        unit = found.residuals[0].unit
        top.set(title=f"{worst}, which differs most", ylabel=f"[{unit}]")
        size = np.linalg.norm(ride.matrix(signals, RESIDUAL), axis=1) / np.sqrt(len(ride.outputs))
        draw_noisy(middle, signals.time, size, "residual", {"color": LINES["residual"], "linewidth": 1.2})
        middle.set(title="Residual: shadow less original, RMS over the outputs", ylabel=f"[{unit}]")
        error = histories.pointing_error(signals) / ARCSECOND
        draw_noisy(bottom, signals.time, error, "pointing error", {"color": LINES["acting"], "linewidth": 1.2})
        make_logarithmic(bottom)
        bottom.set(title="Pointing error", ylabel="[arcsec]", xlabel="time [s]")
        for axes in (top, middle, bottom):
            _mark(axes, found)
        top.legend(loc="upper right", ncols=4)
        span_runs(bottom, [signals])
    return figure


def _mark(axes: Axes, found: Study) -> None:
    ride = found.ride
    if ride.hand_over is not None:
        axes.axvspan(
            ride.hand_over, min(ride.hand_over + ride.blend, ride.end), color="0.85", linewidth=0.0, zorder=0.5
        )
        axes.axvline(ride.hand_over, color="0.3", linewidth=0.9, linestyle="--", label="hand-over")
