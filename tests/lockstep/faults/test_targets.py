"""Targets of a fault: elements of an array in the order of their indices, as a list of amounts needs them."""

from pathlib import Path

import pytest

from lockstep import Component, Connection, System
from lockstep.faults.scenario import Fault
from lockstep.faults.targets import fed_inputs, tunables
from lockstep.fmi.model_description import Description, Variable

SHUFFLED = ["p[10]", "p[2]", "a[2,10]", "p[1]", "a[1,2]", "a[2,2]"]
VECTOR, MATRIX = ["p[1]", "p[2]", "p[10]"], ["a[1,2]", "a[2,2]", "a[2,10]"]
FAULT = Fault(location="faults.toml: fault 1 (bias)", name="fault 1", kind="bias", begin=0, end=None)


def described(causality):
    variables = {
        name: Variable(name=name, reference=k, type="Real", causality=causality, variability="tunable")
        for k, name in enumerate(SHUFFLED)
    }
    return Description(model="m", guid="g", identifier="i", once_per_process=False, saves_state=False, sha256="",
                       variables=variables)  # fmt: skip


def system(*connections):
    components = tuple(Component(name=name, source=Path(f"{name}.fmu"), period=1) for name in ("x", "y"))
    return System(name="demo", tick=1, components=components, connections=connections)


@pytest.mark.parametrize(("array", "elements"), [("p", VECTOR), ("a", MATRIX)])
@pytest.mark.parametrize("pattern", ["y.{}", "x.{} -> *", "x.* -> y.{}", "y.{}[*]"])
def test_connections_are_found_in_numeric_order(array, elements, pattern):
    wires = (Connection(from_component="x", output=name, to_component="y", input=name) for name in SHUFFLED)
    descriptions = {"x": described("output"), "y": described("input")}

    found = fed_inputs([pattern.format(array)], "connection", FAULT, system(*wires), descriptions)

    assert [target.variable.name for target in found] == elements


def test_parameters_are_found_in_numeric_order():
    fault = Fault(location=FAULT.location, name="f", kind="bias", begin=0, end=None, parameters=("y.p", "y.a"))

    found = tunables(fault, system(), {"x": described("parameter"), "y": described("parameter")})

    assert [target.variable.name for target in found] == [*VECTOR, *MATRIX]


def test_range_is_written_out_by_number():
    wires = (Connection(from_component="x", output=name, to_component="y", input=name) for name in SHUFFLED)
    descriptions = {"x": described("output"), "y": described("input")}

    found = fed_inputs(["y.p[1..2]"], "connection", FAULT, system(*wires), descriptions)

    assert [target.name for target in found] == ["y.p[1]", "y.p[2]"]
