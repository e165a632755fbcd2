"""The figure of structure, wheels and sensors against the design."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from numpy.testing import assert_allclose

from flexbench.figures.drawing import AXES, axis_name
from flexbench.figures.figure_lists import design_figures
from flexbench.figures.structure import ARROW, structure_layout
from flexsat.description.built_in import CONFIGURATIONS


@pytest.fixture(scope="module")
def structure(built: Any) -> Figure:
    return design_figures(built)["structure"]()


def test_structure_draws_each_wheel_at_its_place_and_along_its_axis(structure: Figure, designs: Any, points: Any):
    for axes, name in zip(structure.axes, CONFIGURATIONS, strict=True):
        craft = designs[name].spacecraft
        names = np.array([axis_name(axis) for axis in craft.wheels.axis])
        arrows = {str(one.get_label())[-1]: one for one in axes.collections if isinstance(one, Quiver)}
        for axis in "xy":
            drawn, chosen = arrows[axis], names == axis
            assert_allclose(drawn.XY, craft.wheels.position[chosen, :2], atol=0.0)
            assert_allclose(np.column_stack([drawn.U, drawn.V]) / ARROW, craft.wheels.axis[chosen, :2], atol=1e-12)
            assert_allclose(drawn.get_facecolor()[0], to_rgba(AXES[axis].colour))
        for sign, label in ((1.0, "about +z"), (-1.0, "about -z")):
            chosen = (names == "z") & (craft.wheels.axis[:, 2] == sign)
            rings = points(axes, label)
            assert len(rings) == np.count_nonzero(chosen)
            distance = np.linalg.norm(rings - craft.wheels.position[chosen, :2], axis=1)
            assert np.all(distance < 2.0)  # m, from its own site; sites are 6 m apart and more
        counted = sum(len(one.U) for one in arrows.values()) + sum(len(points(axes, f"about {s}z")) for s in "+-")
        assert counted == craft.wheel_count


def test_structure_draws_the_sensors_at_each_site(structure: Figure, designs: Any, points: Any):
    for axes, name in zip(structure.axes, CONFIGURATIONS, strict=True):
        craft = designs[name].spacecraft
        sites = points(axes, "site")
        assert_allclose(np.unique(sites, axis=0), np.unique(craft.accelerometers.position[:, :2], axis=0), atol=0.0)
        for label in ("gyros", "accelerometers"):
            distance = np.linalg.norm(points(axes, label)[:, None] - sites, axis=2)
            assert_allclose(np.sort(np.argmin(distance, axis=0)), np.arange(11))  # one each
            assert np.all(distance.min(axis=1) < 3.5)  # m
        assert len(points(axes, "star tracker")) == 1
        # 60 tiles of 2 m side: 623.538 m2 (PHYSICS section 1)
        x, y = np.moveaxis(np.array([path.vertices[:6] for path in axes.collections[0].get_paths()]), 2, 0)
        area = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1))
        assert area == pytest.approx(623.538, abs=1e-3)


def test_structure_has_numbers_units_and_a_legend(structure: Figure, legend: Any, words: Any):
    centralised, distributed = structure.axes
    assert centralised.get_title("left") == "centralised: 6 wheels of 4.62 kg·m², 4.4 N·m"
    assert distributed.get_title("left") == "distributed: 33 wheels of 0.84 kg·m², 0.8 N·m"
    assert (centralised.get_xlabel(), centralised.get_ylabel()) == ("x [m]", "y [m]")
    assert words(centralised) == "wheels 1-6"
    assert sorted(words(distributed).split("\n")) == sorted(f"wheels {3 * k + 1}-{3 * k + 3}" for k in range(11))
    assert "gyros, 23: x, y, z on the bus; x, y at each site" in legend(structure)
    assert "accelerometers, 13: x, y, z on the bus; z at each site" in legend(structure)


def test_structure_of_both_configurations_is_legible(structure: Figure, crowded: Any):
    assert crowded(structure) == []


def test_structure_of_one_configuration_is_legible_and_saved(designs: Any, check_saved: Any):
    svg = check_saved(structure_layout({"distributed": designs["distributed"]}), "structure-distributed")
    assert "<!-- wheels 31-33 -->" in svg


def test_structure_of_no_design_is_refused():
    with pytest.raises(ValueError, match="one configuration at least"):
        structure_layout({})
