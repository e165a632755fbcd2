"""A list of values reaches the elements of an array in the order of their indices, whatever the FMU's order."""

import random
from pathlib import Path

import numpy as np
import pytest

from lockstep import Component, InputError, System
from lockstep.fmi.model_description import Description, Variable
from lockstep.plan.overrides import resolve_override, resolve_overrides
from lockstep.system.system import Feed, SystemInput
from lockstep.system.transformation import Hop

VECTOR = [f"p[{k}]" for k in range(12)]  # counted from 0
MATRIX = [f"a[{row},{column}]" for row in (1, 2) for column in range(1, 11)]
SYSTEM = System(name="demo", tick=1, components=(Component(name="c", source=Path("c.fmu"), period=1),))


@pytest.fixture
def descriptions():
    """Return a component whose parameters stand in no order."""
    names = random.Random(3).sample([*VECTOR, *MATRIX], len(VECTOR) + len(MATRIX))
    variables = {
        name: Variable(name=name, reference=number, type="Real", causality="parameter")
        for number, name in enumerate(names)
    }
    description = Description(model="m", guid="g", identifier="i", once_per_process=False, saves_state=False,
                              sha256="", variables=variables)  # fmt: skip
    return {"c": description}


@pytest.mark.parametrize(("array", "elements"), [("p", VECTOR), ("a", MATRIX)])
@pytest.mark.parametrize("as_text", [True, False])
def test_list_is_given_in_numeric_row_major_order(descriptions, array, elements, as_text):
    values = [float(k) for k in range(len(elements))]
    given = ",".join(map(str, values)) if as_text else values

    found = resolve_overrides(f"c.{array}", given, SYSTEM, descriptions)

    assert [(variable.name, value) for _, variable, value in found] == list(zip(elements, values, strict=True))


def test_a_matrix_of_numpy_is_given_by_its_rows(descriptions):
    values = np.arange(20.0).reshape(2, 10)
    found = resolve_overrides("c.a", values, SYSTEM, descriptions)
    assert [(variable.name, value) for _, variable, value in found] == list(zip(MATRIX, values.ravel(), strict=True))


def test_list_of_another_length_is_refused(descriptions):
    with pytest.raises(InputError, match=r"c\.p: got 2 values for p\[0\.\.11\]"):
        resolve_override("c.p", [1.0, 2.0], SYSTEM, descriptions)


def test_inputs_of_the_whole_system_are_taken_in_numeric_order(descriptions):
    names = ["u[10]", "u[2]", "u[1]"]
    feeds = {name: (Feed(component="c", input=f"p[{name[2:-1]}]", hops=(Hop(),)),) for name in names}
    inputs = tuple(SystemInput(name=name, unit=None, feeds=feeds[name]) for name in names)
    system = System(name="demo", tick=1, components=SYSTEM.components, inputs=inputs)

    found = resolve_overrides("u", "1,2,10", system, descriptions)

    assert {variable.name: value for _, variable, value in found} == {"p[1]": 1.0, "p[2]": 2.0, "p[10]": 10.0}
