"""A figure drawn for a page: as SVG, or as PNG where that is smaller."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from flexbench.figures.drawing import png_bytes
from flexbench.report import figure_images


def drawn() -> Figure:
    """Return a figure with one line, its layout not computed yet."""
    figure = Figure(layout="constrained")
    figure.subplots().plot([0.0, 1.0], [0.0, 0.123456789])
    return figure


def test_a_figure_of_many_lines_is_a_png_of_the_same_layout(monkeypatch: pytest.MonkeyPatch):
    vector = figure_images._image("slew-seed1", drawn())
    monkeypatch.setattr(figure_images, "LARGE", len(vector.data) - 1)
    raster = figure_images._image("slew-seed1", drawn())

    assert (vector.type, vector.data[:4], vector.name) == ("image/svg+xml", b"<svg", "slew-seed1")
    assert (raster.type, raster.name, raster.title) == ("image/png", "slew-seed1", vector.title)
    assert raster.data == png_bytes(drawn())
