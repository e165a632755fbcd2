"""The figure of mode shapes against the modes of the structure."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

from flexbench.figures.figure_lists import design_figures
from flexbench.figures.modes import mode_shapes
from flexsat.parameters import Aperture, Plate
from flexsat.structure.mesh import record_mesh
from flexsat.structure.modes import Structure, build_structure

UNIT = re.compile(r"\[.+\]$")
# PHYSICS section 1, the authors' finite elements
PUBLISHED = (0.3441, 0.3441, 0.4117, 0.5285, 0.5285, 1.026, 1.245)


@pytest.fixture(scope="module")
def structure() -> Structure:
    return build_structure(record_mesh(Aperture()), Plate())


@pytest.fixture(scope="module")
def shapes(structure: Structure) -> Figure:
    return mode_shapes(structure, 7)


def test_mode_shapes_draw_each_mode_with_its_frequency_on_one_symmetric_scale(structure: Structure, shapes: Figure):
    figure = shapes
    panels = [axes for axes in figure.axes if axes.get_title().startswith("mode")]
    titles = [axes.get_title() for axes in panels]
    hertz = structure.frequency[:7] / (2.0 * np.pi)
    assert titles == [
        f"mode {k}:  {value:.3f} Hz  ({published})"
        for k, (value, published) in enumerate(zip(hertz, PUBLISHED, strict=True), start=1)
    ]
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["clamped to the bus", "bus", "in brackets: the authors' finite elements [Hz]"]
    largest = np.abs(structure.deflection[:, 2, :7]).max()
    for axes in panels:
        filled = axes.collections[0]
        assert_allclose(filled.get_clim(), (-filled.get_clim()[1], filled.get_clim()[1]), rtol=1e-12)
        assert_allclose((filled.levels[0], filled.levels[-1]), (-largest, largest), rtol=1e-12)
        assert axes.get_aspect() == 1.0
    (bar,) = [axes for axes in figure.axes if axes.get_ylabel().startswith("deflection")]
    assert UNIT.search(bar.get_ylabel())


def test_mode_shapes_mark_the_six_clamped_vertices(shapes: Figure, lines: Any):
    (clamped,) = lines(shapes.axes[0], "clamped")
    x, y = (np.asarray(data) for data in (clamped.get_xdata(), clamped.get_ydata()))
    assert_allclose(np.hypot(x, y), np.full(6, 2.0), rtol=1e-9)


def test_mode_shapes_outline_is_the_edge_of_aperture_and_hole(shapes: Figure):
    outline = shapes.axes[0].collections[-1].get_segments()
    # 54 outer vertices and 6 of the hole, and as many edges; one of an edge of 2 m each
    assert len(outline) == 60
    assert_allclose([np.linalg.norm(end - start) for start, end in outline], np.full(60, 2.0), rtol=1e-9)


@pytest.mark.parametrize("count", [0, 199])
def test_mode_shapes_refuse_more_modes_than_there_are(structure: Structure, count: int):
    with pytest.raises(ValueError, match=f"count must be from 1 to 198, got {count}"):
        mode_shapes(structure, count)


def test_mode_shapes_of_a_design_are_those_of_its_structure(built: Any, shapes: Figure, check_saved: Any):
    figure = design_figures(built)["mode-shapes"]()
    assert [axes.get_title() for axes in figure.axes[:6]] == [axes.get_title() for axes in shapes.axes[:6]]
    check_saved(figure, "mode-shapes")
