"""System files follow the parameters of the configuration: periods, tick, record period, delays and slew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from flexbench.loop.systems import build_system, write_systems
from flexsat.design.chain import build_designs
from flexsat.parameters import Rates, Slew
from lockstep import load_system

MILLISECOND = 1_000_000  # ns


@pytest.fixture(scope="module")
def designs():
    return build_designs("centralised")


def with_parameters(designs, **changed):
    """Return the designs with other parameters in their configuration; the matrices stay."""
    corrected = designs.corrected
    return replace(designs, corrected=replace(corrected, config=replace(corrected.config, **changed)))


def periods(system):
    return {component.name: component.period for component in system.components}


def test_stock_rates_give_a_tick_of_one_millisecond(designs):
    system = build_system(designs, "slew", Path())

    assert (system.tick, system.record_period) == (MILLISECOND, 5 * MILLISECOND)
    assert periods(system) == {"sensors": MILLISECOND, "controller": 5 * MILLISECOND, "plant": MILLISECOND}
    assert [component.kind for component in system.components] == ["sampled", "sampled", "continuous"]


def test_other_rates_give_other_periods_tick_and_delays(designs):
    other = with_parameters(designs, rates=Rates(plant=2e-3, sensors=2e-3, controller=8e-3))
    system = build_system(other, "slew", Path())

    assert (system.tick, system.record_period) == (2 * MILLISECOND, 8 * MILLISECOND)
    assert periods(system) == {"sensors": 2 * MILLISECOND, "controller": 8 * MILLISECOND, "plant": 2 * MILLISECOND}
    assert {c.delay for c in system.connections if c.from_component == "plant"} == {1}


def test_sensors_read_the_plant_at_its_last_communication_point(designs):
    slow_plant = with_parameters(designs, rates=Rates(plant=2e-3, sensors=1e-3, controller=4e-3))
    system = build_system(slow_plant, "slew", Path())

    assert system.tick == MILLISECOND
    assert {c.delay for c in system.connections if c.from_component == "plant"} == {2}  # one step of the plant
    assert {c.delay for c in system.connections if c.from_component != "plant"} == {0}


def test_written_system_files_follow_the_rates_and_the_slew(designs, delivered, tmp_path):
    for component in ("plant", "sensors", "controller"):
        (tmp_path / f"{component}.fmu").symlink_to(delivered / "centralised" / f"{component}.fmu")
    slew = Slew(rotation=(0.0, 0.01, 0.0), start_time=7.0)
    other = with_parameters(designs, rates=Rates(plant=2e-3, sensors=2e-3, controller=8e-3), slew=slew)

    (path,) = [p for p in write_systems(other, tmp_path) if p.stem == "slew"]
    system = load_system(path)

    assert (system.tick, system.record_period) == (2 * MILLISECOND, 8 * MILLISECOND)
    assert periods(system) == {"sensors": 2 * MILLISECOND, "controller": 8 * MILLISECOND, "plant": 2 * MILLISECOND}
    parameters = system.component("controller").parameters
    assert [parameters[f"command.rotation[{axis}]"] for axis in (1, 2, 3)] == [0.0, 0.01, 0.0]
    assert parameters["command.start_time"] == 7.0
