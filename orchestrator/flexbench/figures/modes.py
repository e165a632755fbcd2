"""Mode shapes of the supported structure."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.tri import Triangulation

from flexbench.studies.paper.published import MODE_FREQUENCIES
from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.spacecraft.flexible import structure_of
from flexsat.structure.mesh import Mesh
from flexsat.structure.structure import Structure
from lockstep.errors import InputError

from .drawing import STYLE, WIDTH

COLOURS = "RdBu_r"
LEVELS = 24  # colour bands; zero lies between two
COLUMNS = 3
HEIGHT = 2.5  # inch a row
TICKS = (-10.0, 0.0, 10.0)  # m
BUS: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "0.15", "hatch": "//////", "linewidth": 0.9}
CLAMPED: dict[str, Any] = {"linestyle": "none", "marker": "s", "markersize": 2.5, "color": "black"}


def mode_shapes(structure: Structure | Design, count: int = 6) -> Figure:
    """Draw the deflection of the lowest modes over the aperture, each with its frequency and that of the authors.

    Parameters
    ----------
    structure : mass-normalised modes; of a design, those of its structure
    count : how many

    Raises
    ------
    InputError
        If the structure has fewer modes, none is asked for, or it has no aperture.
    """
    if isinstance(structure, Design):
        structure = structure_of(structure.config)
    available = len(structure.frequency)
    if not 1 <= count <= available:
        raise InputError(f"mode_shapes: count must be from 1 to {available}, got {count}")
    if structure.mesh is None:
        raise InputError("mode_shapes: drawn over an aperture, and the structure has none")
    deflection = structure.deflection[: len(structure.mesh.nodes), 2, :count]
    limit = float(np.max(np.abs(deflection)))
    levels = np.linspace(-limit, limit, LEVELS + 1)
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    with matplotlib.rc_context(STYLE | {"axes.grid": False, "axes.titlelocation": "center"}):
        figure = Figure(figsize=(WIDTH, 0.8 + rows * HEIGHT), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for mode, axes in enumerate(grid[:count]):
            _draw_shape(axes, structure.mesh, structure.deflection, deflection[:, mode], levels)
            axes.set_title(_title(structure, mode))
        for axes in grid[count:]:
            axes.set_visible(False)
        for position, axes in enumerate(grid[:count]):
            axes.set(aspect="equal", xticks=TICKS, yticks=TICKS)
            axes.spines[:].set_visible(False)
            axes.use_sticky_edges = False
            axes.margins(0.03)
            if position % columns == 0:
                axes.set_ylabel("y [m]")
            if position + columns >= count:  # nothing below
                axes.set_xlabel("x [m]")
                axes.tick_params(labelbottom=True)
        colours = ScalarMappable(BoundaryNorm(levels.tolist(), 256), COLOURS)
        ticks = levels[:: LEVELS // 4].tolist()
        bar = figure.colorbar(colours, ax=grid.tolist(), shrink=0.8, aspect=32, ticks=ticks, format="{x:.3f}")
        bar.set_label(r"deflection per unit modal displacement [$\mathrm{kg}^{-1/2}$]")
        bar.ax.minorticks_off()
        figure.legend(handles=_legend(), loc="outside lower center", ncols=3, handlelength=1.6)
    return figure


def _draw_shape(axes: Axes, mesh: Mesh, moved: Array, deflection: Array, levels: Array) -> None:
    x, y = mesh.nodes.T
    plate = Triangulation(x, y, mesh.triangles)
    axes.tricontourf(plate, deflection, levels=levels, cmap=COLOURS)
    axes.triplot(plate, color="0.35", linewidth=0.25, alpha=0.6)
    axes.add_collection(LineCollection(_outline(plate), colors="0.15", linewidths=0.9))
    rim = mesh.nodes[mesh.hole]
    rim = rim[np.argsort(np.arctan2(rim[:, 1], rim[:, 0]))]
    axes.add_patch(Polygon(rim.tolist(), **BUS))
    clamped = np.flatnonzero(~moved[: len(x)].any(axis=(1, 2)))
    axes.plot(x[clamped], y[clamped], label="clamped", **CLAMPED)


def _title(structure: Structure, mode: int) -> str:
    title = f"mode {mode + 1}:  {structure.frequency[mode] / (2.0 * np.pi):.3f} Hz"
    if mode < len(MODE_FREQUENCIES):
        title += f"  ({MODE_FREQUENCIES[mode]:.4g})"
    return title


def _legend() -> list[Line2D | Patch]:
    return [
        Line2D([], [], label="clamped to the bus", **CLAMPED),
        Patch(label="bus", **BUS),
        Line2D([], [], linestyle="none", label="in brackets: the authors' finite elements [Hz]"),
    ]


def _outline(plate: Triangulation) -> list[Array]:
    """Return the edges that belong to one triangle only, each (2, 2)."""
    triangle, edge = np.nonzero(plate.neighbors < 0)
    ends = np.stack([plate.triangles[triangle, edge], plate.triangles[triangle, (edge + 1) % 3]], axis=1)
    return list(np.stack([plate.x[ends], plate.y[ends]], axis=2))
