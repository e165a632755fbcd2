"""The interface document of missions is complete and agrees with the system of a mission."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexbench.html.document import Heading, Table, as_markdown
from flexbench.icd.mission_contents import mission_icd_blocks
from flexbench.loop import missions
from flexsat.design.chain import build_designs


@pytest.fixture(scope="module")
def designs():
    return build_designs("centralised")


@pytest.fixture(scope="module")
def system(designs):
    return missions.mission_system(designs, "mission", Path("centralised"))


@pytest.fixture(scope="module")
def tables(designs, system):
    """Return the tables by the heading above them, headers aside; the timeline reads no FMU."""
    ports = missions.mission_ports(designs)
    blocks = mission_icd_blocks(designs.corrected, ports, system, [("centralised/missions/mission.fmu", "{a}", "b")])
    assert "| centralised/missions/mission.fmu" in as_markdown(blocks).replace("`", "")
    found, title = {}, ""
    for block in blocks:
        title = block.text if isinstance(block, Heading) else title
        if isinstance(block, Table):
            found.setdefault(title, []).extend(block.rows)
    return found


def test_every_port_of_missions_is_in_its_table(tables, designs):
    for component, ports in missions.mission_ports(designs).items():
        titles = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}
        for port in ports:
            (line,) = [row for row in tables[f"{titles[port.causality]} of the {component}"] if row[0] == port.name]
            assert line[-1] == port.description
            assert port.unit in line[3] or port.kind != "real"


def test_both_ends_of_every_connection_are_named(tables, system, designs):
    of_missions = missions.mission_ports(designs)
    ends = {
        (component, row[0]): row[-2] for component in of_missions
        for title in ("Inputs", "Outputs") for row in tables[f"{title} of the {component}"]
    }  # fmt: skip
    for one in system.connections:
        source, target = one.output.partition("[")[0], one.input.partition("[")[0]
        latency = {0: "same tick", 1: "1 tick"}.get(one.delay, f"{one.delay} ticks")
        if one.from_component in of_missions:
            assert f"{one.to_component}.{target} ({latency})" in ends[one.from_component, source]
        if one.to_component in of_missions:
            assert ends[one.to_component, target] == f"{one.from_component}.{source} ({latency})"
    assert ends["mission", "shown.encoder.speed"] == "controller.encoder.speed (5 ticks)"
    assert ends["thrusters", "thrust.pulses"] == "recording"
    assert len(tables["Elements of the arrays"]) == 6 + 12  # wheels and thrusters
