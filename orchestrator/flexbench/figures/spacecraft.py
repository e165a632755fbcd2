"""One spacecraft before it is built: its wheels from two sides, what they give, its modes, and who reaches them."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexsat.arrays import Array
from flexsat.spacecraft.flexible import structure_of
from flexsat.spacecraft.properties import extent

from ..loop.properties import Properties
from .drawing import STYLE, WIDTH
from .palette import BLUE, GREEN, VERMILLION

AXES_COLOURS = (VERMILLION, GREEN, BLUE)  # of x, y, z
WIDTHS = (3.6, 2.2, 1.0)  # of the same, in points: lines that cover each other are seen
PLANES = ((0, 1), (1, 2), (2, 0))  # in which envelopes are cut
VIEWS = ((0, 1), (0, 2))  # of the geometry: along z, and along y
ARROW = 0.16  # of the width of a view: a wheel's axis, seen from the side
NOTHING = 1e-9  # share below which a bar is not drawn
NODE: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 2.5, "color": "0.75"}
SENSOR: dict[str, Any] = {"linestyle": "none", "marker": "s", "markersize": 4.0, "color": "0.25"}


def spacecraft_figure(found: Properties) -> Figure:
    """Draw geometry with wheels, envelopes of torque and momentum, effective masses, and the reach of wheels and gyros.

    The numbers of the wheels are those of the ports of the FMUs; an arrow shows the sense of positive speed.
    """
    wheels, axis = found.craft.wheel_set, found.craft.wheels.axis
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 8.4), layout="constrained")
        panels = figure.subplots(3, 2)
        for axes, view in zip(panels[0], VIEWS, strict=True):
            _draw_geometry(axes, found, view)
        given = (("torque", "N·m", wheels.torque_limit), ("momentum", "N·m·s", wheels.inertia * wheels.speed_band))
        for axes, (what, unit, each) in zip(panels[1], given, strict=True):
            _draw_envelope(axes, axis * each[:, np.newaxis], f"{what} of all wheels [{unit}]")
        _draw_modes(panels[2, 0], found)
        _draw_reach(panels[2, 1], found)
        kinds = wheels.kinds.replace("kg.m2", "kg·m²").replace("N.m", "N·m")
        figure.suptitle(f"{found.config.name}: {found.craft.mass:.5g} kg; wheels: {kinds}", fontsize=10.0)
    return figure


def _draw_geometry(axes: Axes, found: Properties, view: tuple[int, int]) -> None:
    across, up = view
    craft = found.craft
    nodes = structure_of(found.config).position - craft.centre
    points = np.vstack([nodes, craft.wheels.position, craft.gyros.position])
    width = max(float(np.ptp(points[:, :2], axis=0).max()), 1.0)
    axes.plot(nodes[:, across], nodes[:, up], label="node of the structure", zorder=1.0, **NODE)
    axes.plot(craft.gyros.position[:, across], craft.gyros.position[:, up], label="gyro", zorder=2.0, **SENSOR)
    place, arrow = craft.wheels.position, ARROW * width * craft.wheels.axis
    axes.quiver(
        place[:, across], place[:, up], arrow[:, across], arrow[:, up], angles="xy", scale_units="xy", scale=1.0,
        color=[AXES_COLOURS[int(np.argmax(np.abs(one)))] for one in craft.wheels.axis], width=0.006, zorder=3.0,
    )  # fmt: skip
    axes.plot(*(place + arrow)[:, view].T, linestyle="none")  # arrows do not count for the limits
    ends: dict[tuple[float, ...], list[int]] = {}
    for k, end in enumerate((place + 1.15 * arrow)[:, view].round(6).tolist()):
        ends.setdefault(tuple(end), []).append(k + 1)
    if len(ends) <= 12:  # more than that would hide each other
        for end, numbers in ends.items():
            axes.text(end[0], end[1], ", ".join(map(str, numbers)), ha="center", va="center", fontsize=7.5, zorder=4.0)
    axes.set(aspect="equal", xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]")
    axes.set_title(f"wheels, gyros and nodes, seen along {'xyz'[3 - across - up]}; from the centre of mass")
    axes.margins(0.12)
    axes.set_adjustable("datalim")


def _draw_envelope(axes: Axes, limits: Array, title: str) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    for first, second in PLANES:
        directions = np.zeros((len(turn), 3))
        directions[:, first], directions[:, second] = np.cos(turn), np.sin(turn)
        reach = extent(limits, directions)
        axes.plot(
            reach * directions[:, first], reach * directions[:, second], color=AXES_COLOURS[3 - first - second],
            linewidth=WIDTHS[3 - first - second], zorder=2.0 + 0.1 * (3 - first - second),
            label=f"{'xyz'[first]} across, {'xyz'[second]} up",
        )  # fmt: skip
    axes.set(aspect="equal", title=title)
    axes.set_adjustable("datalim")
    axes.legend(loc="upper right", fontsize=7.0)


def _draw_modes(axes: Axes, found: Properties) -> None:
    modes = found.modes
    hertz = modes.clamped / (2.0 * np.pi)
    shares = ((modes.effective_mass, "mass along", "-"), (modes.effective_inertia, "inertia about", ":"))
    for part, name, style in shares:
        for k in range(3):
            drawn = part[k] > NOTHING
            axes.vlines(
                hertz[drawn], NOTHING, part[k][drawn], color=AXES_COLOURS[k], linestyle=style, linewidth=WIDTHS[k],
                label=f"{name} {'xyz'[k]}" if drawn.any() else "_none",
            )  # fmt: skip
    axes.set(xscale="log", yscale="log", ylim=(1e-5, 1.5), xlabel="frequency of the clamped structure [Hz]",
             title="effective mass and inertia, over those of the spacecraft")  # fmt: skip
    axes.legend(fontsize=7.0, ncols=2)


def _draw_reach(axes: Axes, found: Properties) -> None:
    modes = found.modes
    hertz = modes.free / (2.0 * np.pi)
    for values, name, colour, marker in (
        (modes.controllability, "wheels reach it", VERMILLION, "o"),
        (modes.observability, "gyros see it", BLUE, "x"),
    ):
        drawn = values > NOTHING
        axes.plot(
            hertz[drawn], values[drawn], linestyle="none", marker=marker, markersize=4.0, color=colour, label=name
        )
    axes.set(xscale="log", yscale="log", ylim=(1e-5, 2.0), xlabel="frequency of the free spacecraft [Hz]",
             title="coupling of wheels and gyros to each mode, over the largest")  # fmt: skip
    axes.legend(fontsize=7.0, loc="lower left")
