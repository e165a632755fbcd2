"""The interface document is complete and agrees with the systems, and its ranges hold in the closed loop."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from flexbench.html.document import Heading, Table, as_markdown
from flexbench.html.render import as_html
from flexbench.icd.contents import icd_blocks
from flexbench.icd.ranges import signal_ranges
from flexbench.icd.rows import port_rows
from flexbench.loop.scenarios import scenario_parameters
from flexbench.loop.systems import WIRES, build_system, connections
from flexsat.closed_loop import PORTS, ClosedLoop
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs


@pytest.fixture(scope="module")
def designs():
    """Return the designs of both configurations."""
    return {name: build_designs(name) for name in CONFIGURATIONS}


@pytest.fixture(scope="module")
def blocks(designs):
    """Return the document; its timeline reads no FMU."""
    system = build_system(designs["distributed"], "fine_pointing", Path("distributed"))
    return icd_blocks(designs, WIRES, system, [("distributed/plant.fmu", "{guid}", "sha")])


def tables(blocks, heading):
    """Return the tables that follow a heading, up to the next one."""
    start = next(i for i, b in enumerate(blocks) if isinstance(b, Heading) and b.text == heading)
    found = []
    for block in blocks[start + 1 :]:
        if isinstance(block, Heading):
            break
        if isinstance(block, Table):
            found.append(block)
    return found


@pytest.mark.parametrize("component", PORTS)
def test_every_port_is_in_its_table(blocks, designs, component):
    for port in PORTS[component](getattr(designs["centralised"].corrected, component)):
        title = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}[port.causality]
        (table,) = tables(blocks, f"{title} of the {component}")
        (line,) = [row for row in table.rows if row[0] == port.name]
        assert line[-1] == port.description
        assert line[2] == port.kind.capitalize()
        assert port.unit in line[3] or port.kind != "real"
        assert len(line) == len(table.header)


def test_sources_and_destinations_are_those_of_the_systems(designs):
    found = {(component, row.name): row for component in PORTS for row in port_rows(designs, WIRES, component)}
    wires = {
        (c.from_component, c.output.partition("[")[0], c.to_component, c.input.partition("[")[0], c.delay)
        for c in connections(designs["centralised"])
    }
    for source, output, target, name, delay in wires:
        latency = "same tick" if delay == 0 else "1 tick"
        assert found[target, name].partner == f"{source}.{output} ({latency})"
        assert f"{target}.{name} ({latency})" in found[source, output].partner
    fed = {(target, name) for _, _, target, name, _ in wires}
    for key, row in found.items():
        if row.causality == "input" and key not in fed:
            assert row.partner == "set by the scenario"


def test_sizes_starts_and_periods_of_both_configurations(designs):
    found = {component: {row.name: row for row in port_rows(designs, WIRES, component)} for component in PORTS}
    assert found["plant"]["wheel.torque"].size == "6 / 33"
    assert found["plant"]["wheel.torque"].range == "±4.4 / ±0.8"
    assert found["plant"]["wheel.torque_limit"].start == "4.4 / 0.8"
    assert found["sensors"]["gyro.rate"].period == "5 ms"
    assert found["sensors"]["star_tracker.mrp"].period == "100 ms"
    assert found["sensors"]["jitter.force_z"].period == "1 ms"
    assert found["controller"]["wheel.torque"].period == "5 ms"
    assert found["plant"]["energy"].period == "when read"
    assert found["sensors"]["attitude.quaternion"].start == "0, 0, 0, 1"


@pytest.mark.parametrize("name", CONFIGURATIONS)
@pytest.mark.parametrize(("scenario", "stop"), [("fine_pointing", 5.0), ("slew", 10.0)])
def test_signals_of_the_loop_stay_in_their_ranges(designs, name, scenario, stop):
    # the slew starts at 5 s; after 10 s no torque or speed grows by more than 2 % of its bound (to 40 s)
    ranges = signal_ranges(designs[name].corrected)
    ports = {
        f"{component}.{port.name}": ranges[port.name]
        for component in PORTS
        for port in PORTS[component](getattr(designs[name].corrected, component))
        if port.causality == "output" and port.name in ranges
    }
    signals = ClosedLoop(designs[name], scenario_parameters(scenario, seed=1)).run(stop, list(ports), 1).signals
    for port, (low, high) in ports.items():
        if low is not None:
            assert np.min(signals[port]) >= low, port
        if high is not None:
            assert np.max(signals[port]) <= high, port
    used = np.max(np.abs(signals["sensors.jitter.torque_x"])) / ranges["jitter.torque_x"][1]
    assert (used > 0.1) if scenario == "fine_pointing" else used == 0.0  # the bound is near what happens


def test_rows_of_markdown_tables_have_equally_many_cells(blocks):
    text = as_markdown(blocks)
    for group in re.findall(r"(?:^\|.*\n)+", text, re.M):
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in group.splitlines()}) == 1


class Reader(HTMLParser):
    """Collect tags, addresses and text."""

    def __init__(self):
        super().__init__()
        self.open, self.addresses, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for key, value in attrs if key in ("src", "href")]
        if tag not in ("meta", "path"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in ("path", "line", "rect") or self.open[-1] == tag:
            assert self.open.pop() == tag

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_data(self, data):
        self.text.append(data)


def test_page_closes_its_tags_and_needs_no_network(blocks):
    reader = Reader()
    reader.feed(as_html(blocks))
    assert reader.open == []
    assert reader.addresses == []
    words = " ".join(reader.text)
    assert "modified Rodrigues parameters" in words
    assert "nominal speed [rpm]" in words
