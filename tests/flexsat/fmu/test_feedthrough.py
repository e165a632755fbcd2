"""Outputs that react to an input within the step, against the dependencies that the model description declares."""

import json

import pytest

from fmus.toys.builds import python

CONFIGURATIONS = ("centralised", "distributed")

# For each scalar input: the outputs that change in the step that reads it, against the declared dependencies.
SAMPLED = """
import json
import fmpy
from driven import *
from session import argument
changes, parameter_sets, at = json.loads(argument(1)), json.loads(argument(2)), int(argument(3))
description = fmpy.read_model_description(argument(0))
claimed = {u.variable.name: {d.name for d in u.dependencies} for u in description.outputs}
port = lambda name: name.partition("[")[0]
moved = set()
for parameters in parameter_sets:
    with Driven(argument(0)) as one:
        one.initialize(**parameters)
        one.drive(0, at)
        one.feed(at)
        for v in one.of.get(("input", "Boolean"), []):
            one.fmu.setBoolean([v.valueReference], [True])
        state = one.fmu.getFMUState()
        names = [v.name for v in one.of["output", "Real"] + one.of.get(("output", "Boolean"), [])]
        def step():
            one.fmu.doStep(at * STEP, STEP)
            assert not one.messages, one.messages
            return one.outputs()
        usual = step()
        one.fmu.setFMUState(state)
        assert step() == usual
        for v in one.of["input", "Real"] + one.of.get(("input", "Boolean"), []):
            one.fmu.setFMUState(state)
            if v.type == "Boolean":
                one.fmu.setBoolean([v.valueReference], [False])
            else:
                (before,) = one.fmu.getReal([v.valueReference])
                one.fmu.setReal([v.valueReference], [before + changes[port(v.name)]])
            for name, was, now in zip(names, usual, step()):
                if was != now:
                    assert v.name in claimed[name], f"{name} moved with {v.name}, which is not among its dependencies"
                    moved.add((name, v.name))
        one.fmu.freeFMUState(state)
never = {(port(o), port(i)) for o in claimed for i in claimed[o]} - {(port(o), port(i)) for o, i in moved}
expected = {tuple(pair) for pair in json.loads(argument(4))}
assert never == expected, f"declared and never moving: {sorted(never - expected)}, moving: {sorted(expected - never)}"
assert len(moved) > 100
"""


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_feedthrough_of_the_sensors_is_as_declared(delivered, name):
    changes = {
        "attitude.quaternion": 1e-3,
        "wheel.speed": 1e-2,
        "gyro_site.rate": 1e-6,
        "accelerometer_site.acceleration": 1e-3,
        "wheel.angle": 1e-2,
    }
    at = 100  # 0.1 s: everything is sampled in this step
    python(SAMPLED, delivered / name / "sensors.fmu", *map(json.dumps, (changes, [{}], at, [])))


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_feedthrough_of_the_controller_is_as_declared(delivered, name):
    changes = {
        "gyro.rate": 1e-8,
        "accelerometer.acceleration": 1e-2,
        "encoder.speed": 1e-3,
        "encoder.angle": 1e-2,
        "star_tracker.mrp": 1e-8,
        "command.rotation": 1e-3,
        "command.start_time": -1.0,
        "applied.wheel.torque": 1e-2,
    }
    # The reference begins where the first sample says; after that it follows no measurement. A slew begins after its
    # shaped torque: a command moves the torque at once and the reference later.
    never = [("reference.mrp", "star_tracker.mrp"), ("reference.mrp", "star_tracker.valid")]
    # At 0.6 s: nothing commanded, and then a slew since 0.5 s, which is at once; a slew from 1.5 s on, and then one at
    # once. Limits that no noise reaches, of which the slew uses little.
    idle = {"command.start_time": 0.5, "command.rotation[1]": 0.0}
    waiting = {"command.start_time": 1.5, "command.rotation[1]": 1e-3}
    limits = {"wheel.torque_limit": 1e6, "wheel.speed_band": 1e6, "slew.authority": 7e-6}
    runs = [
        {"reference.smoothed": smoothed} | given | limits for smoothed in (True, False) for given in (idle, waiting)
    ]
    runs.append(idle | limits | {"filter.disturbance": True, "filter.gyro_bias": True})
    python(SAMPLED, delivered / name / "controller.fmu", *map(json.dumps, (changes, runs, 120, never)))


PLANT = """
import fmpy
from driven import *
from session import argument
description = fmpy.read_model_description(argument(0))
claimed = {u.variable.name: {d.name for d in u.dependencies} for u in description.outputs}
port = lambda name: name.partition("[")[0]
STEPS = 2e-4, 2e-5
through, later, at_once = set(), set(), set()  # at_once: by setting and reading alone, without a step
with Driven(argument(0)) as one:
    one.initialize()
    one.drive(0, 20)
    one.feed(20)
    state = one.fmu.getFMUState()
    outputs = one.of["output", "Real"]
    references = [v.valueReference for v in outputs]
    def step(h):
        one.fmu.doStep(0.02, h)
        assert not one.messages, one.messages
        return one.fmu.getReal(references)
    usual, still = {}, one.fmu.getReal(references)
    for h in STEPS:  # short for modes up to 80 Hz
        one.fmu.setFMUState(state)
        usual[h] = step(h)
    for v in one.of["input", "Real"]:
        change = {}
        one.fmu.setFMUState(state)
        (before,) = one.fmu.getReal([v.valueReference])
        one.fmu.setReal([v.valueReference], [before + 0.3])
        for output, was, now in zip(outputs, still, one.fmu.getReal(references)):
            if abs(now - was) >= 1e-9 * max(1.0, abs(was)):
                assert v.name in claimed[output.name], (output.name, v.name)
                at_once.add((port(output.name), port(v.name)))
            else:
                assert output.name.startswith("accelerometer") or was == now, output.name
        one.fmu.setReal([v.valueReference], [before])
        assert one.fmu.getReal(references) == still, v.name
        for h in STEPS:
            one.fmu.setFMUState(state)
            (before,) = one.fmu.getReal([v.valueReference])
            one.fmu.setReal([v.valueReference], [before + 0.3])
            change[h] = [abs(now - was) for now, was in zip(step(h), usual[h])]
        for output, long, short in zip(outputs, change[STEPS[0]], change[STEPS[1]]):
            # What goes through the state vanishes with the step, ten times at least; what feeds through does not.
            # 1e-9: below it the difference of two numbers of order one is rounding
            if long < 1e-9 * max(1.0, abs(usual[STEPS[0]][outputs.index(output)])):
                continue
            if short > 0.5 * long:
                assert v.name in claimed[output.name], (output.name, v.name, long, short)
                through.add((port(output.name), port(v.name)))
            else:
                assert short < 0.2 * long, (output.name, v.name, long, short)
                later.add((port(output.name), port(v.name)))
    one.fmu.freeFMUState(state)
declared = {(port(o), port(i)) for o in claimed for i in claimed[o]}
# a torque about z turns the body about z, and what lies off that axis senses along it
assert at_once == through, at_once ^ through
assert declared - through == {("accelerometer_site.acceleration", "jitter.torque_z")}, declared - through
assert {o for o, _ in later} >= {"rate", "wheel.speed", "gyro_site.rate", "energy", "angular_momentum"}, later
"""


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_feedthrough_of_the_plant_is_what_does_not_vanish_with_the_step(delivered, name):
    python(PLANT, delivered / name / "plant.fmu")
