"""Draw the structure with its wheels and sensors: model.png and the icon of an FMU. Design time; matplotlib."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from ...arrays import Array
from ...parameters import Aperture
from ...spacecraft.assembly import Points, Spacecraft
from ...structure.mesh import tile_centres, tile_vertices
from ...structure.structure import Structure

SIZE, ICON_SIZE = 480, 128  # pixels
LETTERS = 11.5  # points: 8 pixels high where a tool shows the picture 200 pixels wide
RESOLUTION = 120  # pixels an inch
ARROW = 1.9  # m, of a wheel's axis
PAPER = 15.588457268119894  # m: largest coordinate of the paper's aperture
SMALLEST = 0.1  # m
TRACKER = (0.85, 1.0)  # m; it sits on the bus, drawn next to the gyros there

# Okabe and Ito (2008), colours for the colour-blind; shapes differ too
WHEEL, GYRO, ACCELEROMETER = "#D55E00", "#0072B2", "#F0E442"
FAINT = "0.72"
_STYLE: dict[Any, Any] = {  # any: the type of a key is the list of all of them
    "font.size": LETTERS,
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """What is flexible of a spacecraft, as it is drawn."""

    structure: Structure
    aperture: Aperture | None

    @property
    def scale(self) -> float:
        """Size over that of the paper's aperture."""
        places = np.abs(self.structure.position[:, :2])
        return float(f"{max(float(places.max(initial=0.0)), SMALLEST) / PAPER:.3g}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Emphasis:
    """The parts that a component's drawing shows in colour; all other devices are grey."""

    structure: bool
    wheels: bool
    sensors: bool


EMPHASIS = {
    "plant": Emphasis(structure=True, wheels=True, sensors=False),
    "sensors": Emphasis(structure=False, wheels=False, sensors=True),
    "controller": Emphasis(structure=False, wheels=True, sensors=True),
    "environment": Emphasis(structure=True, wheels=False, sensors=False),
    "thrusters": Emphasis(structure=True, wheels=False, sensors=False),
    "mission": Emphasis(structure=False, wheels=True, sensors=False),
}


def model_picture(spacecraft: Spacecraft, component: str, shown: Shown, modes: int | None) -> bytes:
    """Return model.png: the structure seen along z, devices with a legend, a scale in metres.

    `modes` is how many the component has; None for one without.
    """
    emphasis = EMPHASIS[component]
    with matplotlib.rc_context(_STYLE):
        figure, axes = _canvas(SIZE, shown.scale, legend=True)
        _draw_structure(axes, shown, emphasis)
        _draw_devices(axes, spacecraft, emphasis, shown.scale, scale=1.0)
        _draw_frame(axes, shown.scale)
        if emphasis.wheels:
            _number_wheels(axes, spacecraft, shown.scale)
        carried = "" if modes is None else f", {modes} modes"
        axes.set_title(f"{component}: {spacecraft.wheel_count} wheels{carried}", fontsize=13.0)
        figure.legend(loc="lower center", ncols=2, frameon=False, handletextpad=0.3, columnspacing=1.5,
                      labelspacing=0.25, borderpad=0.0)  # fmt: skip
        return _png(figure)


def icon(spacecraft: Spacecraft, component: str, shown: Shown) -> bytes:
    """Return the icon: the same without words."""
    emphasis = EMPHASIS[component]
    figure, axes = _canvas(ICON_SIZE, shown.scale, legend=False)
    _draw_structure(axes, shown, emphasis)
    _draw_devices(axes, spacecraft, emphasis, shown.scale, scale=0.55)
    return _png(figure)


def _canvas(pixels: int, size: float, *, legend: bool) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(pixels / RESOLUTION, pixels / RESOLUTION), dpi=RESOLUTION)
    axes = figure.add_axes((0.02, 0.13, 0.96, 0.79) if legend else (0.0, 0.0, 1.0, 1.0))
    reach = size * (16.8 if legend else 16.0)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    return figure, axes


def _draw_structure(axes: Axes, shown: Shown, emphasis: Emphasis) -> None:
    aperture, structure = shown.aperture, shown.structure
    if aperture is not None:
        tiles = [tile_vertices(centre, aperture.tile_side) for centre in tile_centres(aperture)]
        face = "#DCE9F2" if emphasis.structure else "0.95"
        axes.add_collection(PolyCollection(tiles, facecolors=face, edgecolors="0.55", linewidths=0.7))
    if emphasis.structure or aperture is None:
        lines = [structure.position[edge, :2] for edge in structure.edges]
        axes.add_collection(LineCollection(lines, colors="#0072B2", linewidths=0.3, alpha=0.45))
    if aperture is None:
        axes.plot(*structure.position[:, :2].T, linestyle="none", marker=".", markersize=2.0, color="0.45", zorder=2)
        return
    hole = tile_vertices(np.zeros(2), aperture.tile_side)
    axes.add_collection(PolyCollection([hole], facecolors="white", edgecolors="0.2", linewidths=1.0))


def _draw_devices(axes: Axes, spacecraft: Spacecraft, emphasis: Emphasis, size: float, scale: float) -> None:
    centre = spacecraft.centre[:2]  # devices are placed from it, and the structure from the origin
    gyros, accelerometers = (_places(points) + centre for points in (spacecraft.gyros, spacecraft.accelerometers))
    mounts = spacecraft.mounts.position[:, :2] + centre
    wheel = WHEEL if emphasis.wheels else FAINT
    gyro, accelerometer, tracker = (GYRO, ACCELEROMETER, "black") if emphasis.sensors else (FAINT, FAINT, FAINT)
    position, axis = spacecraft.wheels.position[:, :2] + centre, spacecraft.wheels.axis[:, :2]
    flat = np.linalg.norm(axis, axis=1) > 0.5  # those that spin about z would be points
    arrows = size * ARROW * axis[flat]
    axes.quiver(*position[flat].T, *arrows.T, angles="xy", scale_units="xy", scale=1.0, color=wheel, width=0.006,
                zorder=3)  # fmt: skip
    for places, area, marker, colour, name, order in (
        (mounts, 150.0, "o", wheel, "wheels", 4),
        (gyros, 46.0, "s", gyro, "gyros", 5),
        (accelerometers, 18.0, "^", accelerometer, "accelerometers", 6),
        (size * np.array([TRACKER]), 90.0, "*", tracker, "star tracker", 7),
    ):
        face, edge, line = colour, "0.25" if marker == "^" else "white", 0.4
        if marker == "o":
            face, edge, line = "none", colour, 1.6 * scale
        axes.scatter(places[:, 0], places[:, 1], s=area * scale**2, marker=marker, facecolor=face, edgecolor=edge,
                     linewidth=line, label=name, zorder=order)  # fmt: skip


def _number_wheels(axes: Axes, spacecraft: Spacecraft, size: float) -> None:
    """Write the wheels' numbers, elements of the arrays, diagonally beside each mount: arrows go along the axes."""
    centre = spacecraft.centre[:2]
    for mount, place in enumerate(spacecraft.mounts.position[:, :2] + centre):
        # neighbours along x do not touch, and the lowest stay clear of axes and scale
        right, up = place[0] > size, place[1] < -size
        text = axes.annotate(number_ranges(np.flatnonzero(spacecraft.mount_of_wheel == mount) + 1),
                             place + 0.75 * size * np.where([right, up], 1.0, -1.0), ha="left" if right else "right",
                             va="bottom" if up else "top", zorder=8, fontweight="bold")  # fmt: skip
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def number_ranges(numbers: Iterable[int]) -> str:
    """Return ascending numbers as text, 1-3, 7 for example."""
    ranges: list[list[int]] = []
    for number in map(int, numbers):
        if ranges and number == ranges[-1][-1] + 1:
            ranges[-1][1:] = [number]
        else:
            ranges.append([number])
    return ", ".join("-".join(map(str, ends)) for ends in ranges)


def _places(points: Points) -> Array:
    """Return where devices are, seen along z, each place once, (k, 2) [m]."""
    return np.array(list(dict.fromkeys((x, y) for x, y, _ in points.position.tolist())))


def _draw_frame(axes: Axes, size: float) -> None:
    """Draw the body axes and a scale, outside the structure."""
    x, y, long, beyond = (size * value for value in (-16.0, -15.6, 2.6, 3.1))
    for along, name in (((1.0, 0.0), "x"), ((0.0, 1.0), "y")):
        tip = (x + long * along[0], y + long * along[1])
        axes.annotate("", tip, (x, y), arrowprops={"arrowstyle": "-|>", "color": "0.2", "linewidth": 0.9})
        axes.annotate(name, (x + beyond * along[0], y + beyond * along[1]), ha="center", va="center", color="0.2")
    axes.plot([size * 10.5, size * 15.5], [y, y], color="0.2", linewidth=1.2)
    axes.annotate(f"{5.0 * size:g} m", (size * 13.0, size * -15.3), ha="center", va="bottom", color="0.2")


def _png(figure: Figure) -> bytes:
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=RESOLUTION, metadata={"Software": None})  # no version: the same bytes
    return memory.getvalue()
