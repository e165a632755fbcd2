"""The seed of a run: one default for every command that simulates."""

import pytest

from flexbench.cli.options import seed_overrides, seeds
from lockstep import Component, System
from lockstep.fmi import model_description
from lockstep.fmi.model_description import Variable

SEED = Variable(name="seed", reference=0, type="Integer", causality="parameter")
DESCRIPTIONS = {"seeded": {"seed": SEED}, "output": {"seed": Variable(name="seed", reference=0, type="Integer",
                causality="output")}, "none": {}}  # fmt: skip


@pytest.fixture
def system(tmp_path, monkeypatch):
    """Return a function that makes a system of components, each with one of the descriptions."""

    class Description:
        def __init__(self, variables):
            self.variables = variables

    monkeypatch.setattr(model_description, "read_description", lambda c: Description(DESCRIPTIONS[c.source.stem]))

    def make(**kinds):
        return System(
            name="s", tick=1, stop_time=10,
            components=tuple(
                Component(name=name.replace("__", "/"), source=tmp_path / kind, period=1, parameters=parameters)
                for name, (kind, parameters) in kinds.items()
            ),
            connections=(),
        )  # fmt: skip

    return make


def test_plant_and_sensors_have_the_default_seed(system):
    made = system(aocs__sensors=("seeded", {}), plant=("seeded", {}), controller=("seeded", {}))
    assert list(seed_overrides(made, None).items()) == [("plant.seed", 1), ("aocs/sensors.seed", 1)]


@pytest.mark.parametrize("plant", [("none", {}), ("output", {}), ("seeded", {"seed": 5})])
def test_the_default_seed_is_for_components_with_a_seed_and_no_value_of_it(system, plant):
    assert seed_overrides(system(plant=plant, sensors=("seeded", {})), None) == {"sensors.seed": 1}


def test_a_given_seed_is_set_or_refused_by_the_run(system):
    assert seed_overrides(system(plant=("none", {}), sensors=("seeded", {"seed": 5})), 3) == {
        "plant.seed": 3,
        "sensors.seed": 3,
    }
    assert seed_overrides(system(other=("seeded", {})), 3) == {"plant.seed": 3, "sensors.seed": 3}


def test_several_seeds_begin_with_the_default():
    assert list(seeds(3)) == [1, 2, 3]
