"""System files follow the parameters of the configuration: periods, tick, record period, delays and slew."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from fmpy.ssp.ssd import get_connections, read_ssd
from lxml import etree

from flexbench.loop.systems import build_system, write_systems
from flexsat.design.chain import Designs, build_designs
from flexsat.parameters import Rates, Slew
from flexsat.variants import CORRECTED
from lockstep import load_system, read_signals, simulate
from lockstep.ssp.documents.xml import NS
from lockstep.system.clock import seconds

MILLISECOND = 1_000_000  # ns


@pytest.fixture(scope="module")
def designs():
    return build_designs("centralised")


def with_parameters(designs, **changed):
    """Return the designs with other parameters in their configuration; the matrices stay."""
    corrected = replace(designs.corrected, config=replace(designs.corrected.config, **changed))
    return Designs({one: designs.variant(one) for one in designs.variants} | {CORRECTED: corrected})


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


def test_a_star_tracker_of_3_hz_gives_periods_that_are_fractions_of_nanoseconds(designs):
    rates = Rates(plant=1 / 1200, sensors=1 / 1200, controller=1 / 300, star_tracker=1 / 3)
    system = build_system(with_parameters(designs, rates=rates), "slew", Path())

    twelve_hundredth = Fraction(10**9, 1200)  # [ns]
    assert (system.tick, system.record_period) == (twelve_hundredth, 4 * twelve_hundredth)
    assert {c.delay for c in system.connections if c.from_component == "plant"} == {1}
    assert rates.star_tracker == seconds(400 * system.tick)


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


COMMANDS = {f"command_rotation_{axis}": ("rad", f"command.rotation[{axis}]") for axis in (1, 2, 3)}
COMMANDS["command_start_time"] = ("s", "command.start_time")


def flat(name):
    """Return a variable's name in the FMUs with flat names."""
    return name.replace(".", "_").replace("[", "_").rstrip("]")


@pytest.mark.parametrize(("file", "named"), [("slew.ssp", str), ("flat/slew.ssp", flat)])
def test_a_package_shows_commands_attitude_and_torque_to_the_outside(delivered, file, named):
    top = read_ssd(str(delivered / "centralised" / file)).system  # a reader of others
    ends = {(a.name, b.parent.name, b.name) for a, b in get_connections(top) if a.parent is top}
    starts = {(b.name, a.parent.name, a.name) for a, b in get_connections(top) if b.parent is top}
    kinds = {connector.name: connector.kind for connector in top.connectors}

    assert {(name, "controller", named(variable)) for name, (_, variable) in COMMANDS.items()} <= ends
    assert ("external_torque_3", "plant", named("external.torque[3]")) in ends
    assert ("attitude_quaternion_4", "plant", named("attitude.quaternion[4]")) in starts
    assert ("wheel_torque_6", "controller", named("wheel.torque[6]")) in starts
    assert all(name.isidentifier() for name in kinds)  # OMSimulator takes no others
    assert set(kinds.values()) == {"input", "output"}
    assert len(ends) + len(starts) == len(kinds) == 36


def test_inputs_of_the_whole_system_have_units_and_the_values_of_the_scenario(delivered):
    """A host that sends zero where nothing is connected would command no slew."""
    path = delivered / "centralised" / "slew.ssd"
    system, top = load_system(path), etree.parse(path).getroot().find("ssd:System", NS)
    values = {
        parameter.get("name"): float(parameter[0].get("value"))
        for parameter in top.find("ssd:ParameterBindings", NS).iterfind(".//ssv:Parameter", NS)
    }
    units = {c.get("name"): c[0].get("unit") for c in top.iterfind("ssd:Connectors/ssd:Connector", NS)}

    assert values["command_rotation_1"] > 0.0
    assert system.inputs == ()
    for name, (unit, variable) in COMMANDS.items():
        assert values[name] == system.component("controller").parameters[variable]
        assert units[name] == unit
    assert (units["wheel_torque_1"], units["external_force_1"], units["rate_1"]) == ("N.m", "N", "rad/s")


def test_systems_for_hosts_that_refuse_connectors_to_the_outside(delivered):
    both = [load_system(delivered / "centralised" / folder / "slew.ssp") for folder in (".", "closed")]

    assert [len(system.ports) for system in both] == [36, 0]
    assert both[0].connections == both[1].connections
    assert [c.parameters for c in both[0].components] == [c.parameters for c in both[1].components]


def test_flat_systems_give_the_results_of_the_structured_ones(delivered, tmp_path):
    results = []
    for naming in (".", "flat"):
        system = load_system(delivered / "centralised" / naming / "fine_pointing.ssd")
        simulate(system, tmp_path / naming / "run", stop_time=0.05)
        results.append(read_signals(tmp_path / naming / "run"))
    structured, other = results
    names = {name: ".".join((*name.split(".")[:1], flat(name.partition(".")[2]))) for name in structured.columns}

    assert sorted(names.values()) == sorted(other.columns)
    assert all((structured[name] == other[names[name]]).all() for name in names)
