"""The structure with its wheels and sensors, viewed along z, a panel a configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.parameters import ConfigurationName
from flexsat.spacecraft.assembly import Points, Spacecraft
from flexsat.spacecraft.flexible import structure_of
from flexsat.structure.mesh import tile_centres, tile_vertices
from lockstep.errors import InputError

from .drawing import AXES, STYLE, WIDTH, axis_name

REACH = 17.6  # m, of the panels
ARROW = 2.3  # m
CORNER = np.array([1.05, 1.05])  # m from its site: the symbol of a wheel about z, between the arrows
SENSORS_BELOW, SPACING = 1.15, 1.05  # m: the row of sensors, opposite to the arrows
BUS_SENSORS_BELOW = 3.1  # m
TEXT_BEYOND = 1.1  # m from the row of sensors to the words
TICKS = (-15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0)  # m
TILE, EDGE, BUS = "0.965", "0.82", "0.88"
SITE: dict[str, Any] = {"marker": ".", "markersize": 5.0, "color": "black", "linestyle": "none"}
GYRO, ACCELEROMETER, STAR_TRACKER = "s", "D", "*"
SIZES = {GYRO: 4.6, ACCELEROMETER: 4.4, STAR_TRACKER: 8.5}  # points


def structure_layout(designs: Mapping[ConfigurationName, Design]) -> Figure:
    """Draw tiles, bus, wheel axes and sensors, a panel a configuration.

    The arrow of a wheel shows the sense of positive speed; along z it is a circle with a dot, towards the reader, or
    with a cross. The numbers of the wheels are those of the ports of the FMUs.

    Parameters
    ----------
    designs : by configuration

    Raises
    ------
    InputError
        If there are no designs.
    """
    if not designs:
        raise InputError("structure_layout: designs must hold one configuration at least, got none")
    with matplotlib.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(WIDTH, 5.9 if len(designs) > 1 else 5.0), layout="constrained")
        panels = figure.subplots(1, len(designs), squeeze=False, sharey=True)[0]
        for axes, (name, design) in zip(panels, designs.items(), strict=True):
            _draw_tiles(axes, design)
            _draw_wheels(axes, design.spacecraft)
            _draw_sensors(axes, design.spacecraft)
            kinds = design.config.wheel_set.kinds.replace(" of ", " wheels of ", 1).replace(" and ", ", ")
            axes.set_title(f"{name}: {kinds.replace('kg.m2', 'kg·m²').replace('N.m', 'N·m')}")
            axes.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal", xticks=TICKS, yticks=TICKS)
            axes.set_xlabel("x [m]")
        panels[0].set_ylabel("y [m]")
        handles, labels = _legend(next(iter(designs.values())).spacecraft)
        position: dict[str, Any] = {"loc": "outside lower center", "ncols": 3}
        if len(designs) == 1:
            position = {"loc": "outside right center"}
        figure.legend(handles, labels, handler_map={tuple: HandlerTuple(ndivide=1)}, **position)
    return figure


def _draw_tiles(axes: Axes, design: Design) -> None:
    aperture = design.config.aperture
    if aperture is None:
        places = structure_of(design.config).position[:, :2]
        axes.plot(*places.T, linestyle="none", marker=".", markersize=2.0, color=EDGE, zorder=1.0)
        return
    tiles = [tile_vertices(centre, aperture.tile_side) for centre in tile_centres(aperture)]
    axes.add_collection(PolyCollection(tiles, facecolors=TILE, edgecolors=EDGE, linewidths=0.6))
    bus = tile_vertices(np.zeros(2), aperture.tile_side)
    axes.add_patch(Polygon(bus.tolist(), facecolor=BUS, edgecolor="0.35", linewidth=1.0))


def _draw_wheels(axes: Axes, spacecraft: Spacecraft) -> None:
    position, axis = spacecraft.wheels.position[:, :2], spacecraft.wheels.axis
    names = np.array([axis_name(one) for one in axis])
    for name in "xy":
        (x, y), (u, v) = position[names == name].T, ARROW * axis[names == name, :2].T
        axes.quiver(
            x, y, u, v, angles="xy", scale_units="xy", scale=1.0, color=AXES[name].colour,
            width=0.0062, headwidth=3.6, headlength=4.2, headaxislength=3.8, zorder=3.0, label=f"about {name}",
        )  # fmt: skip
    for sign, marker in ((1.0, "."), (-1.0, "x")):
        chosen = (names == "z") & (sign * axis[:, 2] > 0.0)
        _draw_turning(axes, position[chosen] + sign * CORNER, marker, f"about {'+' if sign > 0.0 else '-'}z")


def _draw_turning(axes: Axes, sites: Array, marker: str, label: str) -> None:
    colour = AXES["z"].colour
    ring: dict[str, Any] = {"linestyle": "none", "color": colour, "markeredgewidth": 1.1, "zorder": 3.0}
    axes.plot(*sites.T, marker="o", markersize=8.5, markerfacecolor="white", label=label, **ring)
    axes.plot(*sites.T, marker=marker, markersize=4.2, label="_inside", **ring)


def _draw_sensors(axes: Axes, spacecraft: Spacecraft) -> None:
    sites = _unique_sites(spacecraft.accelerometers)
    axes.plot(*sites.T, zorder=4.0, label="site", **SITE)
    rows: dict[str, list[tuple[float, float]]] = {GYRO: [], ACCELEROMETER: [], STAR_TRACKER: []}
    for site in sites:
        wheels = np.flatnonzero(np.all(spacecraft.wheels.position[:, :2] == site, axis=1))
        on_bus = not site.any()
        up = -1.0 if on_bus or not len(wheels) else -float(np.sign(spacecraft.wheels.axis[wheels].sum()))
        x, y = site[0], site[1] + up * (BUS_SENSORS_BELOW if on_bus else SENSORS_BELOW)
        kinds = [GYRO, ACCELEROMETER, *([STAR_TRACKER] if on_bus else [])]
        for k, kind in enumerate(kinds):
            rows[kind].append((x + (k - 0.5 * (len(kinds) - 1)) * SPACING, y))
        if len(wheels):
            text = f"wheels {wheels[0] + 1}-{wheels[-1] + 1}"
            axes.text(x, y + up * TEXT_BEYOND, text, ha="center", va="center", fontsize=7.5)
    for kind, label in ((GYRO, "gyros"), (ACCELEROMETER, "accelerometers"), (STAR_TRACKER, "star tracker")):
        axes.plot(*np.array(rows[kind]).T, label=label, zorder=3.0, **_sensor(kind))


def _sensor(marker: str) -> dict[str, Any]:
    face = "0.25" if marker == GYRO else "white"
    return {"marker": marker, "markersize": SIZES[marker], "markerfacecolor": face, "color": "0.1", "linestyle": "none"}


def _unique_sites(points: Points) -> Array:
    """Return the different positions of points, (k, 2) [m], in the order in which each comes first."""
    _, first = np.unique(points.position[:, :2], axis=0, return_index=True)
    return np.asarray(points.position[np.sort(first), :2])


def _kinds(points: Points) -> str:
    """Describe the number of devices, and their axes on the bus and at the sites."""
    bus = ~points.position.any(axis=1)
    inner, outer = ("".join(sorted({axis_name(axis) for axis in points.axis[part]})) for part in (bus, ~bus))
    return f"{len(points.axis)}: {', '.join(inner)} on the bus; {', '.join(outer)} at each site"


def _legend(spacecraft: Spacecraft) -> tuple[list[Any], list[str]]:
    def ring(inside: str) -> tuple[Line2D, Line2D]:
        line: dict[str, Any] = {"linestyle": "none", "color": AXES["z"].colour, "markeredgewidth": 1.1}
        return (
            Line2D([], [], marker="o", markersize=8.5, markerfacecolor="white", **line),
            Line2D([], [], marker=inside, markersize=4.2, **line),
        )

    def arrow(name: str, marker: str) -> Line2D:
        return Line2D([], [], color=AXES[name].colour, linewidth=2.0, marker=marker, markersize=5.0)

    entries: list[tuple[Any, str]] = [
        (arrow("x", ">"), "wheel about x; all have encoders"),
        (arrow("y", "^"), "wheel about y"),
        (ring("."), "wheel about +z"),
        (ring("x"), "wheel about -z"),
        (Line2D([], [], **_sensor(GYRO)), f"gyros, {_kinds(spacecraft.gyros)}"),
        (Line2D([], [], **_sensor(ACCELEROMETER)), f"accelerometers, {_kinds(spacecraft.accelerometers)}"),
        (Line2D([], [], **_sensor(STAR_TRACKER)), "star tracker or fine guidance sensor"),
        (Line2D([], [], **SITE), "site; its devices are drawn next to it"),
        (Patch(facecolor=TILE, edgecolor=EDGE), "tile"),
        (Patch(facecolor=BUS, edgecolor="0.35"), "bus"),
    ]
    return [handle for handle, _ in entries], [label for _, label in entries]
