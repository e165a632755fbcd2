"""Scenarios set parameters that the components have; a slew ends when the paper says."""

from __future__ import annotations

import numpy as np
import pytest

from flexbench.loop.scenarios import SCENARIOS, scalar_overrides, scenario_parameters
from flexbench.runs.commands import Command
from flexbench.runs.flown_design import flown_part, planned_slew
from flexsat.closed_loop import PORTS, port_values
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs
from flexsat.parameters import ARCSECOND, DEGREE
from flexsat.variants import AS_PUBLISHED, CORRECTED


@pytest.fixture(scope="module", params=CONFIGURATIONS)
def designs(request):
    """Return the designs of each configuration in turn."""
    return build_designs(request.param)


@pytest.mark.parametrize("variant", [CORRECTED, AS_PUBLISHED])
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_name_is_a_parameter_or_input_of_its_component(designs, scenario, variant):
    parameters = scenario_parameters(scenario, variant, seed=4)

    assert set(parameters) == set(PORTS)
    for component, given in parameters.items():
        values = port_values(component, PORTS[component](getattr(designs.corrected, component)), given)
        for name, value in given.items():
            assert np.array_equal(values[name], value), f"{component}.{name}"


def test_slew_uses_the_coarse_tracker_without_jitter():
    slew, fine = scenario_parameters("slew"), scenario_parameters("fine_pointing")

    assert (slew["sensors"]["star_tracker.fine"], slew["sensors"]["jitter.enabled"]) == (False, False)
    assert (fine["sensors"]["star_tracker.fine"], fine["sensors"]["jitter.enabled"]) == (True, True)
    for scenario in (slew, fine):  # the controller assumes the settings of the sensors
        assert scenario["controller"]["star_tracker.fine"] == scenario["sensors"]["star_tracker.fine"]
        assert scenario["controller"]["jitter.feed_forward"] == scenario["sensors"]["jitter.enabled"]
    assert slew["controller"]["command.rotation"] == (0.5 * DEGREE, 0.0, 0.0)
    assert fine["controller"]["command.rotation"] == (0.0, 0.0, 0.0)
    assert slew["controller"]["command.start_time"] == 5.0


def test_open_loop_changes_only_the_open_loop_parameter():
    closed, opened = (scalar_overrides(scenario_parameters(name)) for name in SCENARIOS[1:])

    assert {key for key in closed if closed[key] != opened[key]} == {"controller.open_loop"}
    assert opened["controller.open_loop"] is True


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_as_published_switches_all_errors_of_the_published_code(scenario):
    corrected, published = (
        scalar_overrides(scenario_parameters(scenario, variant)) for variant in (CORRECTED, AS_PUBLISHED)
    )

    switched = {key for key in corrected if corrected[key] != published[key]}
    expected = {f"{component}.as_published" for component in PORTS}
    expected |= {"plant.initial.random_wheel_phases", "controller.reference.smoothed"}
    if scenario != "slew":
        expected |= {"plant.initial.attitude_deviation", *(f"plant.initial.mrp[{i}]" for i in (1, 2, 3))}
        assert published["plant.initial.mrp[2]"] == pytest.approx(0.25 * ARCSECOND, rel=1e-15)  # a quarter of the angle
        assert corrected["plant.initial.attitude_deviation"] == pytest.approx(0.1 * ARCSECOND, rel=1e-15)
    assert switched == expected


def test_seed_is_set_in_plant_and_sensors_only_if_given():
    assert "seed" not in scenario_parameters("slew")["plant"]
    seeded = scalar_overrides(scenario_parameters("slew", seed=7))
    assert {key: value for key, value in seeded.items() if key.endswith("seed")} == {
        "plant.seed": 7,
        "sensors.seed": 7,
    }


def test_results_of_two_calls_are_independent():
    first = scenario_parameters("slew")
    first["plant"]["initial.mrp"] = (1.0, 0.0, 0.0)
    assert scenario_parameters("slew")["plant"]["initial.mrp"] == (0.0, 0.0, 0.0)


def test_an_unknown_scenario_is_refused():
    with pytest.raises(ValueError, match="scenario 'spin': no such scenario; there are slew, fine_pointing"):
        scenario_parameters("spin")


def test_overrides_are_one_scalar_each_numbered_from_one():
    flat = scalar_overrides({"a": {"x": (1.0, 2.0), "y": True}, "b": {"x": 3}})

    assert flat == {"a.x[1]": 1.0, "a.x[2]": 2.0, "a.y": True, "b.x": 3}


def test_slew_of_the_paper_takes_101_s(designs):
    # 0.5 deg at 0.306 deg/min with short ramps: 100.9 s from 5 s on (PHYSICS section 6); a tenth: it gives four digits
    slew = designs.corrected.config.slew
    command = Command(time=slew.start_time, rotation=slew.rotation)
    end = planned_slew(flown_part(designs.corrected), command).end
    assert end == pytest.approx(5.0 + 100.9, abs=0.1)
    assert planned_slew(flown_part(designs.variant(AS_PUBLISHED)), command).end == end
