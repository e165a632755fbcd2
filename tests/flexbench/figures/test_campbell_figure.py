"""The Campbell diagram against the linear model of the design."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

from flexbench.figures import campbell as figure_module
from flexbench.figures.campbell import FASTEST, HARMONIC_SPEEDS, MAP_SPEEDS, campbell_diagram
from flexbench.figures.drawing import AXES, axis_name
from flexbench.figures.figure_lists import design_figures
from flexbench.studies.waterfall.campbell import harmonic_deformation, imbalance_deformation
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import RPM
from flexsat.spacecraft.campbell_crossings import modal_frequencies

HERTZ = 2.0 * np.pi


def computed_once(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of a spacecraft and the same further arguments that keeps its results."""
    results: dict[tuple[int, bytes], Any] = {}

    def of(spacecraft: Any, *rest: Any) -> Any:
        key = id(spacecraft), b"".join(np.asarray(one).tobytes() for one in rest)
        if key not in results:
            results[key] = function(spacecraft, *rest)
        return results[key]

    return of


@pytest.fixture(scope="module")
def computed(built: Any) -> Iterator[SimpleNamespace]:
    """Return the first harmonic and the figure; the figures of the module compute what they draw once."""
    harmonic = computed_once(harmonic_deformation)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_module, "campbell", computed_once(figure_module.campbell))
        patch.setattr(figure_module, "harmonic_deformation", harmonic)
        yield SimpleNamespace(harmonic=harmonic, figure=design_figures(built)["campbell"]())


@pytest.fixture(scope="module")
def campbell(computed: SimpleNamespace) -> Figure:
    return computed.figure


def test_campbell_draws_modes_harmonic_and_chosen_speeds(campbell: Figure, designs: Any, points: Any):
    for axes, configuration in zip(campbell.axes[:2], CONFIGURATIONS, strict=True):
        design = designs[configuration]
        modes = modal_frequencies(design.structure, MAP_SPEEDS, FASTEST) / HERTZ
        for k in (0, 12, 24):
            assert_allclose(points(axes, f"mode {k + 1}"), np.column_stack([MAP_SPEEDS / RPM, modes[k]]), rtol=1e-12)
        assert len([line for line in axes.get_lines() if str(line.get_label()).startswith("mode")]) == len(modes) > 25
        assert_allclose(points(axes, "first harmonic"), [[0.0, 0.0], [1000.0, 1000.0 / 60.0]], rtol=1e-12)
        nominal, names = design.response.nominal / RPM, [axis_name(axis) for axis in design.spacecraft.wheels.axis]
        lines = [drawn for drawn in axes.collections if isinstance(drawn, LineCollection)]
        for name in "xyz":
            speed = nominal[[one == name for one in names]]
            drawn = points(axes, f"chosen, about {name}")
            assert_allclose(drawn, np.column_stack([speed, speed / 60.0]), rtol=1e-12)
            (bands,) = [one for one in lines if np.allclose(one.get_edgecolor(), to_rgba(AXES[name].colour))]
            reach = np.array(bands.get_segments())
            assert_allclose(reach[:, :, 0], np.column_stack([speed - 25.0, speed + 25.0]), rtol=1e-12)


def test_campbell_marks_the_crossings_either_side_of_bands_that_avoid_them(designs: Any, points: Any):
    design, gap = designs["centralised"], np.array([[300.0, 450.0], [310.0, 460.0], [200.0, 260.0]] * 2)
    avoiding = replace(design, response=replace(design.response, gap=gap * RPM))
    upper, lower = Figure().subplots(2)
    figure_module._draw_chosen(upper, lower, avoiding)
    for row, name in enumerate("xyz"):
        drawn = points(upper, f"gap, about {name}")
        assert_allclose(drawn[:, 0], np.tile(gap[row], 2), rtol=1e-12)
        assert_allclose(drawn[:, 1], drawn[:, 0] / 60.0, rtol=1e-12)


def test_campbell_marks_the_speeds_of_the_mesh_of_record(campbell: Figure, points: Any):
    """Those chosen on 198 modes; on the 25 of PHYSICS section 5 they are 351 and 223 rpm, from 223 to 833 rpm."""
    central, spread = ([points(axes, f"chosen, about {name}")[:, 0] for name in "xyz"] for axes in campbell.axes[:2])
    assert_allclose([np.unique(np.round(speed)).item() for speed in central], [403.0, 403.0, 223.0])
    everything = np.concatenate(spread)
    assert_allclose([np.round(everything.min()), np.round(everything.max())], [223.0, 548.0])


def test_campbell_colours_are_the_response_of_the_worst_wheel(campbell: Figure, designs: Any):
    for axes, configuration in zip(campbell.axes[:2], CONFIGURATIONS, strict=True):
        craft = designs[configuration].structure
        mesh = axes.collections[0]
        grid, values = mesh.get_coordinates(), np.asarray(mesh.get_array()).reshape(mesh.get_coordinates().shape[:2])
        assert_allclose(grid[0, :, 0], MAP_SPEEDS / RPM, rtol=1e-12)
        for column in (3, 20):
            frequency = np.asarray(grid[::40, column, 1]) * HERTZ
            expected = imbalance_deformation(craft, MAP_SPEEDS[column], frequency).max(axis=0) * 1e6
            assert_allclose(values[::40, column], expected, rtol=1e-9)
        low, high = mesh.get_clim()
        assert high >= values.max()
        assert high / low == pytest.approx(1e5)
        assert mesh.get_cmap().name == "cividis"


def test_campbell_draws_the_first_harmonic_of_every_wheel(campbell: Figure, designs: Any, computed: Any, points: Any):
    for axes, configuration in zip(campbell.axes[2:4], CONFIGURATIONS, strict=True):
        design = designs[configuration]
        craft = design.structure
        expected = computed.harmonic(craft, HARMONIC_SPEEDS) * 1e6
        drawn = {}
        for line in axes.get_lines():
            kind, _, wheel = str(line.get_label()).partition(" ")
            if kind == "wheel":
                drawn[int(wheel) - 1] = np.asarray(line.get_ydata(), dtype=float)
                assert line.get_color() == AXES[axis_name(craft.wheels.axis[int(wheel) - 1])].colour
        for wheel, values in drawn.items():
            assert_allclose(values, expected[wheel], rtol=1e-12)
        for wheel in range(craft.wheel_count):  # drawn itself, or by another with the same response
            gaps = [np.max(np.abs(np.log10(expected[wheel] / values))) for values in drawn.values()]
            assert min(gaps) < 0.002
        nominal = design.response.nominal
        for name in "xyz":
            wheels = [k for k, axis in enumerate(craft.wheels.axis) if axis_name(axis) == name]
            made = [imbalance_deformation(craft, nominal[k], nominal[[k]])[k, 0] * 1e6 for k in wheels]
            assert_allclose(points(axes, f"chosen, about {name}")[:, 1], made, rtol=1e-9)


def test_campbell_has_units_and_a_legend(campbell: Figure, legend: Any):
    upper, _, lower, _, bar = campbell.axes
    assert upper.get_ylabel() == "frequency [Hz]"
    assert lower.get_ylabel().endswith("RMS deformation [µm]")
    assert lower.get_xlabel() == "wheel speed [rpm]"
    assert bar.get_ylabel() == "RMS deformation, worst wheel [µm]"
    assert lower.get_yscale() == "log"
    assert {"first harmonic: Hz = rpm/60", "mode of the free spacecraft", "below 200 rpm: not searched"} < set(
        legend(campbell)
    )
    assert sum("chosen, ±25 rpm" in text for text in legend(campbell)) == 3


def test_campbell_of_both_configurations_is_legible(campbell: Figure, crowded: Any):
    assert crowded(campbell) == []


@pytest.mark.usefixtures("computed")
def test_campbell_of_one_configuration_is_legible_and_saved(designs: Any, check_saved: Any):
    check_saved(campbell_diagram({"distributed": designs["distributed"]}), "campbell")


def test_campbell_of_no_design_is_refused():
    with pytest.raises(ValueError, match="one configuration at least"):
        campbell_diagram({})
