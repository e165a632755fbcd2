"""A shadow controller: torques of both, their residual, and the pointing error, with the switchover marked."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexbench.runs import histories
from flexbench.studies.shadow.study import Study
from flexsat.parameters import ARCSECOND
from lockstep import Signals
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW

from .drawing import STYLE, WIDTH, draw_line, draw_noisy, span_runs
from .palette import BLUE, GREEN, VERMILLION

CLOSE = 0.5  # s either side of the switchover
# Okabe and Ito (2008): blue, vermillion, bluish green, black
LINES = {"original": BLUE, "shadow": VERMILLION, "acting": "#000000", "residual": GREEN}


def shadow_figure(signals: Signals, found: Study) -> Figure:
    """Draw the output that differs most, also close to the switchover, the size of the residual, the pointing error."""
    recorded = found.recorded
    worst = max(found.residuals, key=lambda residual: residual.rms).output
    unit = found.residuals[0].unit
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 6.8), layout="constrained")
        panels = figure.subplot_mosaic([["torque", "close"], ["residual", "residual"], ["error", "error"]])
        for name in ("torque", "close"):
            _draw_torque(panels[name], signals, found, worst, _close_to_it(found) if name == "close" else None)
            panels[name].set(ylabel=f"[{unit}]")
        panels["torque"].set(title=f"{worst}, which differs most")
        panels["close"].set(
            title="Before and after the switchover" if recorded.switchover is not None else "The last second"
        )
        size = np.linalg.norm(recorded.matrix(signals, RESIDUAL), axis=1) / np.sqrt(len(recorded.outputs))
        draw_noisy(panels["residual"], signals.time, size, "residual", {"color": LINES["residual"], "linewidth": 1.2})
        panels["residual"].set(title="Residual: shadow less original, RMS over the outputs", ylabel=f"[{unit}]")
        error = histories.pointing_error(signals) / ARCSECOND
        draw_noisy(panels["error"], signals.time, error, "pointing error", {"color": LINES["acting"], "linewidth": 1.2})
        panels["error"].set(title="Pointing error", ylabel="[arcsec]", xlabel="time [s]")
        for name, axes in panels.items():
            _mark(axes, found)
            if name != "close":
                span_runs(axes, [signals])
        figure.legend(*panels["close"].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def _close_to_it(found: Study) -> tuple[float, float]:
    """Return the time to look at closely [s]: a little before the switchover until the difference has half passed."""
    recorded = found.recorded
    if recorded.switchover is None:
        return max(0.0, recorded.end - 1.0), recorded.end
    return max(0.0, recorded.switchover - CLOSE), min(
        recorded.end, recorded.switchover + max(CLOSE, min(0.6 * recorded.blend, 2.0))
    )


def _draw_torque(axes: Axes, signals: Signals, found: Study, output: str, span: tuple[float, float] | None) -> None:
    rows = slice(None) if span is None else slice(*np.searchsorted(signals.time, span))
    for kind, prefix, width in (("original", ORIGINAL, 0.9), ("shadow", SHADOW, 0.7), ("acting", "", 0.5)):
        values = signals[found.recorded.name(prefix, output)][rows]
        draw_line(axes, signals.time[rows], values, kind, {"color": LINES[kind], "linewidth": width})
    if span is not None:
        axes.set_xlim(*span)


def _mark(axes: Axes, found: Study) -> None:
    recorded = found.recorded
    if recorded.switchover is not None:
        end = min(recorded.switchover + recorded.blend, recorded.end)
        axes.axvspan(recorded.switchover, end, color="0.85", linewidth=0.0, zorder=0.5)
        axes.axvline(recorded.switchover, color="0.3", linewidth=0.9, linestyle="--", label="switchover")
