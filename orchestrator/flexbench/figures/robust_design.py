"""Figures of the robust design: what its weights trade, and its loop shapes beside those of the published one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from flexsat.design.chain import build_designs
from flexsat.parameters import ALL_MODES, ARCSECOND, ConfigurationName

from ..studies.spillover.corners import DEFORMATION, DELAY, POINTING, TORQUE
from ..studies.spillover.loop_shapes import LoopShape, loop_shape
from ..studies.spillover.trade_off import CANCELLATION, FEEDBACK, Point
from .drawing import AXES, STYLE, WIDTH
from .figure_lists import Drawn
from .palette import BLUE, VERMILLION

CURVE: dict[str, Any] = {"marker": "o", "markersize": 3.5, "linewidth": 1.2}
CHOSEN: dict[str, Any] = {
    "marker": "*", "markersize": 13.0, "linestyle": "none", "color": "black", "zorder": 4.0, "label": "chosen",
}  # fmt: skip
WANTED: dict[str, Any] = {"color": "0.5", "linestyle": (0.0, (4.0, 1.3)), "linewidth": 0.9}
SHOWN = (1e-4, 1e3)  # of the loops' gains


def robust_design_figures(curves: Mapping[ConfigurationName, Sequence[Point]]) -> Drawn:
    """Return both figures of the configurations whose trade-off is given, each drawn when called."""

    def shapes() -> Figure:
        designs = {name: (build_designs(name).corrected, build_designs(name).published) for name in curves}
        known = {name: float(both[0].spacecraft.frequency.max() / (2.0 * np.pi)) for name, both in designs.items()}
        return loop_shape_figure(
            {name: (loop_shape(robust, ALL_MODES), loop_shape(published, ALL_MODES))
             for name, (robust, published) in designs.items()}, known
        )  # fmt: skip

    return {"robust-trade-off": lambda: trade_off_figure(curves), "robust-loop-shapes": shapes}


def trade_off_figure(curves: Mapping[ConfigurationName, Sequence[Point]]) -> Figure:
    """Draw pointing over the delay that is tolerated, and deformation over torque, with what is wanted of each.

    Parameters
    ----------
    curves : points of `trade_off`, by configuration
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.6 + 2.7 * len(curves)), layout="constrained")
        grid = figure.subplots(len(curves), 2, squeeze=False)
        for (left, right), (name, points) in zip(grid, curves.items(), strict=True):
            _draw_feedback(left, name, [point for point in points if point.curve == FEEDBACK])
            _draw_cancellation(right, name, [point for point in points if point.curve == CANCELLATION])
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def loop_shape_figure(
    shapes: Mapping[ConfigurationName, tuple[LoopShape, LoopShape]], known: Mapping[ConfigurationName, float]
) -> Figure:
    """Draw the gain of each body axis' loop over frequency, and its Nyquist diagram near -1.

    Parameters
    ----------
    shapes : of the robust and of the published design, by configuration
    known : frequency of the highest mode that the controller is designed with [Hz]
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.6 + 2.9 * len(shapes)), layout="constrained")
        grid = figure.subplots(len(shapes), 2, squeeze=False, gridspec_kw={"width_ratios": (2.0, 1.0)})
        for (left, right), (name, (robust, published)) in zip(grid, shapes.items(), strict=True):
            left.loglog(published.frequency, np.abs(published.axes[:, 0]), color="0.7", linewidth=0.7,
                        label="published design, x")  # fmt: skip
            for k, (axis, look) in enumerate(AXES.items()):
                style = {"color": look.colour, "linewidth": 1.0, "label": f"robust design, {axis}"}
                left.loglog(robust.frequency, np.abs(robust.axes[:, k]), **style)
                right.plot(robust.axes[:, k].real, robust.axes[:, k].imag, **style)
            left.axhline(1.0, color="black", linewidth=0.8)
            left.axvspan(known[name], left.dataLim.x1, color="0.5", alpha=0.12, linewidth=0.0,
                         label="modes that the controller does not know")  # fmt: skip
            left.set(title=f"{name}: gain of the open loop", xlabel="frequency [Hz]", ylabel="gain [1]", ylim=SHOWN)
            left.margins(x=0.0)
            right.plot(-1.0, 0.0, "P", color="black", markersize=7.0, label="critical point")
            right.set(title="Nyquist diagram near -1", xlabel="real part [1]", ylabel="imaginary part [1]",
                      xlim=(-3.0, 2.0), ylim=(-2.5, 2.5))  # fmt: skip
            right.set_aspect("equal")
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _draw_feedback(axes: Axes, name: ConfigurationName, points: Sequence[Point]) -> None:
    kept = [(1e3 * point.delay, point.settled.pointing / ARCSECOND, point) for point in points if point.settled]
    axes.plot([x for x, _, _ in kept], [y for _, y, _ in kept], color=BLUE, **CURVE, label="varied weight, its factor")
    for x, y, point in kept:
        _mark(axes, x, y, point)
    axes.axvline(1e3 * DELAY[name], **WANTED, label="wanted")
    axes.axhline(POINTING[name] / ARCSECOND, **WANTED)
    axes.set(title=f"{name}: feedback", xlabel="unknown delay that is tolerated [ms]", ylabel="pointing [arcsec]")
    axes.set_xlim(0.0, 1.1 * axes.dataLim.x1)
    axes.set_ylim(0.0, 1.15 * axes.dataLim.y1)


def _draw_cancellation(axes: Axes, name: ConfigurationName, points: Sequence[Point]) -> None:
    kept = [(p.settled.torque, 1e6 * p.settled.deformation, p) for p in points if p.settled]
    axes.semilogx([x for x, _, _ in kept], [y for _, y, _ in kept], color=VERMILLION, **CURVE)
    for x, y, point in kept:
        _mark(axes, x, y, point)
    axes.axvline(TORQUE[name], **WANTED)
    axes.axhline(1e6 * DEFORMATION[name], **WANTED)
    axes.set(title=f"{name}: cancellation of harmonic jitter", xlabel="torque, sum over the wheels [N.m]",
             ylabel="deformation [µm]")  # fmt: skip
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(0.0, 1.15 * axes.dataLim.y1)


def _mark(axes: Axes, x: float, y: float, point: Point) -> None:
    if point.factor == 1.0:
        axes.plot(x, y, **CHOSEN)
    axes.annotate(f"{point.factor:g}", (x, y), xytext=(0.0, 8.0), textcoords="offset points", fontsize=7.5, ha="center")
