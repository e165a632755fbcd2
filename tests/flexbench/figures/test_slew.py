"""The figure of the slew: data, units, marks and published values."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

from flexbench.figures.slew import slew_comparison
from flexbench.runs.flown_design import flown_part
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ARCSECOND, ConfigurationName
from flexsat.variants import AS_PUBLISHED
from lockstep import Signals

UNIT = re.compile(r"\[.+\]$")
START, END = 5.0, 25.0  # s, of the slew


def slewing(signals: Signals) -> Signals:
    """Return a run whose reference turns about z, too slowly for the errors that are drawn, with feed-forward."""
    inside = (signals.time >= START - 1e-9) & (signals.time < END - 1e-9)
    slow = {"controller.reference.rate[3]": 2e-9 * inside, "controller.reference.torque[1]": 1e-12 * inside}
    return replace(signals, columns={**signals.columns, **slow})


@pytest.fixture(scope="module")
def slew(runs: dict[ConfigurationName, Signals], flown: Any) -> Figure:
    return slew_comparison({name: slewing(signals) for name, signals in runs.items()}, flown)


def panel(figure: Figure, title: str) -> Axes:
    (found,) = [axes for axes in figure.axes if axes.get_title("left").startswith(title)]
    return found


def test_slew_has_ten_panels_with_units_over_the_whole_run(slew: Figure):
    assert len(slew.axes) == 10
    assert len({axes.get_title("left") for axes in slew.axes}) == 10
    for axes in slew.axes:
        assert UNIT.search(axes.get_ylabel()), axes.get_title("left")
        assert_allclose(axes.get_xlim(), (0.0, 30.0), rtol=1e-9)
    assert [axes.get_xlabel() for axes in slew.axes] == [""] * 6 + ["time [s]"] * 4


def test_slew_marks_its_start_and_end_in_every_panel(slew: Figure):
    for axes in slew.axes:
        pairs = [line.get_xdata() for line in axes.get_lines() if len(line.get_xdata()) == 2]
        upright = {float(first) for first, second in pairs if first == second}
        assert sorted(upright) == pytest.approx([START, END])


def test_slew_shows_the_limit_of_one_wheel_of_each_layout(slew: Figure):
    """P, table 1: 4.4 N.m of a wheel on the bus, 0.8 N.m of one over the structure."""
    level = {float(y[0]) for y in (line.get_ydata() for line in panel(slew, "One wheel").get_lines())
             if len(y) == 2 and y[0] == y[1]}  # fmt: skip
    assert sorted(level) == pytest.approx([-4.4, -0.8, 0.8, 4.4])


def test_slew_draws_errors_in_the_units_of_the_labels(slew: Figure, lines: Any, heights: Any):
    pointing = panel(slew, "Pointing")
    assert "[arcsec]" in pointing.get_ylabel()
    assert pointing.get_yscale() == "log"
    assert_allclose(heights(lines(pointing, "centralised")[0]), 2.0, rtol=1e-6)
    assert_allclose(heights(lines(pointing, "distributed")[0]), 1.0, rtol=1e-6)
    rotation = panel(slew, "Rotation")
    assert_allclose(heights(lines(rotation, "centralised")[0]), 2.0 / 3600.0, rtol=1e-6)
    assert_allclose(heights(lines(rotation, "reference")[0]), 0.0, atol=0.0)


def test_slew_shows_a_spike_of_one_sample(slew: Figure):
    deformation = panel(slew, "Deformation")
    assert deformation.dataLim.y1 == pytest.approx(5.0)  # um
    assert deformation.get_ylim()[1] > 5.0


def test_slew_sums_torque_over_wheels_and_time(slew: Figure, lines: Any, heights: Any):
    for name, wheels in (("centralised", 6), ("distributed", 33)):
        assert_allclose(heights(lines(panel(slew, "Wheel torque, over"), name)[0])[-1], 0.25 * wheels * 30.0)


def test_slew_cost_grows_to_the_sum_over_samples(slew: Figure, designs: Any, lines: Any, heights: Any):
    cost = panel(slew, "LQR cost")
    for name in CONFIGURATIONS:
        weights = designs[name].regulator.torque_weight
        expected = 6001 * 0.5 * 0.25**2 * weights.sum()
        assert_allclose(heights(lines(cost, f"{name}, control")[0])[-1], expected, rtol=1e-9)
        assert heights(lines(cost, f"{name}, total")[0])[-1] > expected


def test_slew_draws_the_x_wheels_against_their_band(slew: Figure, lines: Any):
    wheels = panel(slew, "Wheels")
    about_x = {"centralised": range(1, 7, 3), "distributed": range(1, 34, 3)}  # +x +y +z, -x -y -z, ...
    for name, numbers in about_x.items():
        assert [line.get_label() for line in lines(wheels, name)] == [f"{name}, wheel {k}" for k in numbers]
    (band,) = wheels.patches
    assert_allclose((band.get_y(), band.get_y() + band.get_height()), (-25.0, 25.0), rtol=1e-12)  # rpm


def test_slew_distinguishes_the_configurations_without_colour(slew: Figure, lines: Any, legend: Any):
    one, other = (lines(panel(slew, "Rotation"), name)[0] for name in CONFIGURATIONS)
    assert one.get_color() != other.get_color()
    assert one.get_linewidth() != other.get_linewidth()
    assert one._dash_pattern != other._dash_pattern
    labels = legend(slew)
    assert labels[:3] == ["centralised", "distributed", "reference"]


def test_slew_of_one_configuration_is_drawn_alone(runs: Any, flown: Any, legend: Any):
    figure = slew_comparison({"distributed": runs["distributed"]}, flown)
    assert "centralised" not in legend(figure)


def test_slew_draws_the_published_values(
    flown: Any, whole_runs: Any, crowded: Any, lines: Any, heights: Any, legend: Any
):
    slew = slew_comparison({name: slewing(signals) for name, signals in whole_runs.items()}, flown)
    expected = {  # PHYSICS section 7
        ("Pointing error", "centralised"): 49.0,
        ("Pointing error", "distributed"): 1.8,
        ("Angular rate error", "centralised"): 1.1e-3,
        ("Angular rate error", "distributed"): 1.1e-4,
        ("Deformation", "centralised"): 2.3,
        ("Deformation", "distributed"): 0.33,
    }
    for (title, name), value in expected.items():
        (line,) = lines(panel(slew, title), f"published, {name}")
        assert_allclose(heights(line), value, rtol=1e-12)
        assert_allclose(np.asarray(line.get_xdata()), (150.0, 300.0), rtol=1e-9)
    costs = [heights(line)[0] for line in lines(panel(slew, "LQR cost"), "published, ")]
    assert sorted(costs) == [34.0, 219.0, 461.0, 1.9e4]
    settled = [line.get_xdata()[0] for line in lines(panel(slew, "Pointing"), "published settling")]
    assert_allclose(settled, [END + 100.0, END + 30.0])
    assert crowded(slew) == []
    assert any("published" in text for text in legend(slew))


def test_slew_of_the_published_variant_is_compared_over_its_window(designs: Any, lines: Any, made_signals: Any):
    design = replace(designs["distributed"], variant=AS_PUBLISHED)
    signals = made_signals(design, ARCSECOND, 60_001)

    figure = slew_comparison({"distributed": signals}, {"distributed": flown_part(design)})

    for title, start, end in (("Angular rate", 75.0, 150.0), ("Deformation", 75.0, 150.0), ("Pointing", 150.0, 300.0)):
        (line,) = lines(panel(figure, title), "published, distributed")
        assert_allclose(np.asarray(line.get_xdata()), (start, end), rtol=1e-9)


def test_slew_of_a_short_run_has_no_published_values(slew: Figure):
    labels = [str(line.get_label()) for axes in slew.axes for line in axes.get_lines()]
    assert not [label for label in labels if label.startswith("published")]


def test_slew_without_results_is_refused(flown: Any):
    with pytest.raises(ValueError, match="one configuration at least"):
        slew_comparison({}, flown)


def test_slew_of_a_single_row_is_drawn(designs: Any, flown: Any, made_signals: Any):
    signals = {"centralised": made_signals(designs["centralised"], ARCSECOND, 1)}

    assert len(slew_comparison(signals, flown).axes) == 10


def test_slew_of_a_controller_of_others_has_no_cost(runs: Any, flown: Any):
    foreign = {name: replace(design, cost=None, speed_band=float("nan")) for name, design in flown.items()}
    figure = slew_comparison(runs, foreign)

    assert not panel(figure, "LQR cost").get_lines()
    assert not panel(figure, "Wheels").patches
    assert panel(figure, "Bending").get_lines()
