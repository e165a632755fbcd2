"""The diagram of a system: components, connections, delays and schedule."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation

from flexbench.figures.architecture import architecture_diagram, wires
from flexbench.figures.figure_lists import design_figures
from flexbench.loop.systems import WIRES, build_system
from lockstep import Component, Connection, InputError, System
from lockstep.plan.timeline import timeline


@pytest.fixture(scope="module")
def system(built: Any) -> System:
    return build_system(built["distributed"], "fine_pointing", Path())


@pytest.fixture(scope="module")
def architecture(built: Any) -> Figure:
    return design_figures(built)["architecture-distributed"]()


def test_architecture_lists_every_connection_of_the_real_system(architecture: Figure, system: System, words: Any):
    text = words(architecture.axes[0])
    found = {(wire.producer, wire.consumer, wire.delay): wire.ports for wire in wires(system)}
    assert found.keys() == {(source, target, delay) for source, target, _, delay in WIRES}
    sizes = Counter((c.from_component, c.output.partition("[")[0]) for c in system.connections)
    for source, target, ports, delay in WIRES:
        assert list(found[source, target, delay]) == list(ports)
        for port in ports:
            count = sizes[source, port] // sum(w[0] == source and port in w[2] for w in WIRES)
            assert found[source, target, delay][port] == count
            assert (port if count == 1 else f"{port} [{count}]") in text
    assert sum(sum(ports.values()) for ports in found.values()) == len(system.connections)
    for line in ("106 values, delay 1 tick: true now", "106 values, same tick", "66 values, same tick",
                 "33 values, same tick"):  # fmt: skip
        assert line in text


def test_architecture_draws_components_with_rates_and_ports(architecture: Figure, words: Any):
    boxes = [
        patch.get_label()
        for patch in architecture.axes[0].patches
        if patch.get_label() in ("sensors", "controller", "plant")
    ]
    assert boxes == ["sensors", "controller", "plant"]  # in the order of a tick
    text = words(architecture.axes[0])
    assert "every 5 ms, sampled\n106 in, 33 out" in text
    assert "every 1 ms, continuous\n99 in, 106 out" in text
    assert "every 1 ms, sampled\n106 in, 172 out" in text


def test_architecture_draws_the_schedule_of_two_periods(architecture: Figure, system: System):
    axes = architecture.axes[1]
    steps = timeline(system, 10)
    drawn = Counter(
        (patch.get_label(), round(patch.get_x(), 6)) for patch in axes.patches if isinstance(patch, Rectangle)
    )
    assert drawn == Counter((f"{step.component}, step", step.start / 1e6) for step in steps)
    true = {(str(line.get_label()), float(np.asarray(line.get_xdata())[0])) for line in axes.get_lines()}
    assert true == {(f"{step.component}, true", (step.end if step.continuous else step.start) / 1e6) for step in steps}
    arrows = [text for text in axes.texts if isinstance(text, Annotation)]
    assert len(arrows) == sum(not read.initial for step in steps for read in step.reads)
    assert axes.get_xlabel() == "time [ms]"
    assert [label.get_text() for label in axes.get_yticklabels()] == ["sensors", "controller", "plant"]


def test_architecture_shows_a_delay_in_place(system: System, words: Any):
    figure = architecture_diagram(system.with_delay("sensors", "controller", 5))
    assert "106 values, delay 5 ticks = 5 ms" in words(figure.axes[0])


def test_architecture_draws_any_system(crowded: Any, words: Any):
    offsets = {"a": 0, "b": 0, "c": 1_000_000, "lone": 0}
    components = tuple(
        Component(name=name, source=Path(f"{name}.fmu"), period=2_000_000, kind="sampled", offset=offset)
        for name, offset in offsets.items()
    )
    ends = (("a", "y", "b", 0), ("a", "z", "b", 2), ("a", "y", "c", 0), ("c", "y", "a", 2), ("b", "y", "b", 1))
    connections = [
        Connection(
            from_component=source,
            output=f"{port}[{k}]",
            to_component=target,
            input=f"{port}_{source}[{k}]",
            delay=delay,
        )
        for source, port, target, delay in ends
        for k in (1, 2)
    ]
    system = System(name="any", tick=1_000_000, components=components, connections=tuple(connections))

    figure = architecture_diagram(system, {"a": ("a note",)})

    text = words(figure.axes[0])
    assert text.count("2 values") == 5
    assert {"lone", "a note"} <= set(text.split("\n"))
    assert "every 2 ms from 1 ms on\nsampled" in text
    assert crowded(figure) == []


def test_architecture_refuses_what_cannot_be_scheduled(system: System):
    with pytest.raises(InputError, match="one of the future"):
        architecture_diagram(system.with_delay("plant", "sensors", 0))


def test_architecture_has_notes_and_is_legible_and_saved(architecture: Figure, check_saved: Any, words: Any):
    text = words(architecture.axes[0])
    assert {"star tracker every 100 ms;", "20 gains in turn;", "198 modes, 33 wheels"} <= set(text.split("\n"))
    check_saved(architecture, "architecture-distributed")
