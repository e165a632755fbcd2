"""The folders of the software and the way from parameters to a report."""

from __future__ import annotations

from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from .drawing import STYLE, WIDTH
from .palette import BLUE, GREEN, VERMILLION

Position = tuple[float, float]  # inch, of a box's middle
BOX, HEIGHT = 1.02, 0.36  # inch
COLUMN, ROW, LEFT = 1.29, 0.62, 1.62  # inch
BAND_LEFT, BETWEEN = 0.08, 0.3  # inch
ARROW: dict[str, Any] = {"arrowstyle": "-|>,head_length=5,head_width=2.2", "mutation_scale": 1.0, "shrinkA": 0.0,
                         "shrinkB": 0.0, "linewidth": 1.1, "color": "0.35"}  # fmt: skip
PACKAGES = {
    "flexsat": (BLUE, "spacecraft: physics,\ncontrol design, FMUs"),
    "lockstep": (GREEN, "co-simulation of\nany FMUs"),
    "flexbench": (VERMILLION, "studies of runs"),
}
# folder: column and row; the rows of a package are neighbours
BOXES: dict[str, Position] = {
    "flexsat/parameters": (0.0, 0.0),
    "flexsat/structure": (1.0, 0.0),
    "flexsat/spacecraft": (2.0, 0.0),
    "flexsat/design": (3.0, 0.0),
    "flexsat/runtime": (3.0, 1.0),
    "flexsat/ports": (4.0, 1.0),
    "flexsat/fmu": (5.0, 1.0),
    "lockstep/ssp": (0.0, 2.0),
    "lockstep/system": (1.0, 2.0),
    "lockstep/plan": (2.0, 2.0),
    "lockstep/run": (3.0, 2.0),
    "lockstep/results": (5.0, 2.0),
    "lockstep/fmi": (3.0, 3.0),
    "lockstep/processes": (4.0, 3.0),
    "flexbench/loop": (1.0, 4.0),
    "flexbench/runs": (2.0, 4.0),
    "flexbench/studies": (3.0, 4.0),
    "flexbench/figures": (4.0, 4.0),
    "flexbench/report": (5.0, 4.0),
}
ROWS = 5
# from, to: data and files, in the order of a run
ARROWS: tuple[tuple[str, str], ...] = (
    ("flexsat/parameters", "flexsat/structure"),
    ("flexsat/structure", "flexsat/spacecraft"),
    ("flexsat/spacecraft", "flexsat/design"),
    ("flexsat/design", "flexsat/runtime"),
    ("flexsat/runtime", "flexsat/ports"),
    ("flexsat/ports", "flexsat/fmu"),
    ("lockstep/ssp", "lockstep/system"),
    ("lockstep/system", "lockstep/plan"),
    ("lockstep/plan", "lockstep/run"),
    ("lockstep/run", "lockstep/results"),
    ("lockstep/fmi", "lockstep/run"),
    ("lockstep/processes", "lockstep/fmi"),
    ("flexbench/loop", "flexbench/runs"),
    ("flexbench/runs", "flexbench/studies"),
    ("flexbench/studies", "flexbench/figures"),
    ("flexbench/figures", "flexbench/report"),
)
# between a package and the next one
BORDERS = (
    ("flexsat/fmu", "lockstep/results", "only FMUs, system files and design files cross this line"),
    ("lockstep/fmi", "flexbench/runs", "results folders"),
)


def software_diagram() -> Figure:
    """Draw the folders of the three packages as boxes, and the data between them as arrows."""
    height = ROWS * ROW + 2.0 * BETWEEN - 0.06
    with matplotlib.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(0.0, WIDTH), ylim=(height, 0.0))  # downwards
        axes.set_axis_off()
        for package in PACKAGES:
            _draw_package(axes, package)
        for start, end in ARROWS:
            _draw_arrow(axes, _middle(start), _middle(end))
        for folder in BOXES:
            _draw_box(axes, folder)
        for above, below, text in BORDERS:
            y = 0.5 * (_middle(above)[1] + _middle(below)[1])
            axes.text(WIDTH / 2.0, y, text, ha="center", va="center", fontsize=8.0, style="italic")
    return figure


def _middle(folder: str) -> Position:
    column, row = BOXES[folder]
    package = list(PACKAGES).index(folder.partition("/")[0])
    return LEFT + BOX / 2.0 + COLUMN * column, 0.1 + HEIGHT / 2.0 + ROW * row + BETWEEN * package


def _draw_package(axes: Axes, package: str) -> None:
    colour, subject = PACKAGES[package]
    rows = [_middle(folder)[1] for folder in BOXES if folder.startswith(f"{package}/")]
    top, bottom = min(rows) - HEIGHT / 2.0 - 0.06, max(rows) + HEIGHT / 2.0 + 0.06
    band = FancyBboxPatch(
        (BAND_LEFT, top), WIDTH - 2.0 * BAND_LEFT, bottom - top, boxstyle="round,pad=0,rounding_size=0.06",
        facecolor=colour, alpha=0.08, linewidth=0.0, label=package,
    )  # fmt: skip
    axes.add_patch(band)
    middle = 0.5 * (top + bottom)
    axes.text(BAND_LEFT + 0.12, middle - 0.1, package, fontsize=10.0, fontweight="bold", color=colour, va="center")
    axes.text(BAND_LEFT + 0.12, middle + 0.05, subject, fontsize=7.5, va="top")


def _draw_box(axes: Axes, folder: str) -> None:
    package, _, name = folder.partition("/")
    x, y = _middle(folder)
    axes.add_patch(
        FancyBboxPatch((x - BOX / 2.0, y - HEIGHT / 2.0), BOX, HEIGHT, boxstyle="round,pad=0,rounding_size=0.05",
                       facecolor="white", edgecolor=PACKAGES[package][0], linewidth=1.3, label=folder)
    )  # fmt: skip
    axes.text(x, y, name, ha="center", va="center", fontsize=8.5)


def _draw_arrow(axes: Axes, start: Position, end: Position) -> None:
    """Draw an arrow between the edges of two boxes in one row, or in one column."""
    across, down = end[0] - start[0], end[1] - start[1]
    if abs(down) < 1e-9:
        shift = (BOX / 2.0 if across > 0.0 else -BOX / 2.0, 0.0)
    else:
        shift = (0.0, HEIGHT / 2.0 if down > 0.0 else -HEIGHT / 2.0)
    axes.annotate(
        "", (end[0] - shift[0], end[1] - shift[1]), (start[0] + shift[0], start[1] + shift[1]), arrowprops=ARROW
    )
