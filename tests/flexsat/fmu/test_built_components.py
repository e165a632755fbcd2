"""The six FMUs of the study as another team receives them, each in a fresh process."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.toys.builds import python

CONFIGURATIONS, COMPONENTS = ("centralised", "distributed"), ("plant", "sensors", "controller")
SIX = [f"{name}/{component}" for name in CONFIGURATIONS for component in COMPONENTS]
FLEXSAT = Path(sys.executable).with_name("flexsat")

# Drive an instance with inputs that depend on the step's number alone, and note every output bitwise.
OPEN = """
import json, random, sys
from pathlib import Path
from session import *
from session import argument

STEP = {"plant": 1e-3, "sensors": 1e-3, "controller": 5e-3}[Path(argument(0)).stem]

class Driven(Session):
    def __init__(self, path, name="one"):
        super().__init__(path, name)
        self.of = {}
        for v in self.description.modelVariables:
            self.of.setdefault((v.causality, v.type), []).append(v)

    def feed(self, k):
        draw = random.Random(k)
        reals = [v for v in self.of["input", "Real"] if not v.name.startswith("command.")]
        self.fmu.setReal([v.valueReference for v in reals], [float(v.start) + draw.gauss(0.0, 1e-4) for v in reals])
        for v in self.of.get(("input", "Boolean"), []):
            self.fmu.setBoolean([v.valueReference], [k % 20 == 0])

    def outputs(self):
        values = self.fmu.getReal([v.valueReference for v in self.of["output", "Real"]])
        flags = self.of.get(("output", "Boolean"), [])
        return [x.hex() for x in values] + [bool(x) for v in flags for x in self.fmu.getBoolean([v.valueReference])]

    def drive(self, first, last, step=STEP):
        trace = []
        for k in range(first, last):
            self.feed(k)
            self.fmu.doStep(k * step, step)
            trace.append(self.outputs())
        assert not self.messages, self.messages
        return trace

def refused(one, time, step):
    try:
        one.fmu.doStep(time, step)
    except FMICallException as error:
        assert error.status == 2, error.status  # fmi2Discard
        return one.messages[-1][2]
    raise AssertionError("the step was accepted")
"""


@pytest.fixture
def fmus(delivered):
    """Return a folder with the FMUs of both configurations."""
    return delivered


@pytest.fixture(params=SIX)
def fmu(request, fmus):
    """Return each of the six in turn."""
    return fmus / f"{request.param}.fmu"


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(str(fmu)) == []


def test_the_schema_of_fmi_accepts_the_model_description(fmu):
    folder = Path(fmpy.__file__).parent / "schema" / "fmi2"
    schema = etree.XMLSchema(etree.parse(str(folder / "fmi2ModelDescription.xsd")))
    with zipfile.ZipFile(fmu) as archive:
        schema.assertValid(etree.fromstring(archive.read("modelDescription.xml")))


def test_the_model_description_is_complete(fmu):
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        assert archive.testzip() is None
    variables = root.findall("ModelVariables/ScalarVariable")
    units = {unit.get("name") for unit in root.findall("UnitDefinitions/Unit")}
    outputs = [str(k) for k, v in enumerate(variables, start=1) if v.get("causality") == "output"]

    assert {v.get("causality") for v in variables} == {"input", "output", "parameter"}
    assert [v.get("name") for v in variables if not v.get("description")] == []
    for variable in variables:
        value = variable[0]
        if value.tag == "Real":
            assert value.get("unit") in units, variable.get("name")
        assert (value.get("start") is None) == (variable.get("causality") == "output"), variable.get("name")
    for part in ("Outputs", "InitialUnknowns"):
        unknowns = root.findall(f"ModelStructure/{part}/Unknown")
        assert [unknown.get("index") for unknown in unknowns] == outputs
        assert all(unknown.get("dependencies") is not None for unknown in unknowns)
    kind = root.find("CoSimulation")
    assert kind is not None
    assert kind.get("canHandleVariableCommunicationStepSize") == ("true" if fmu.stem == "plant" else "false")
    assert (kind.get("canGetAndSetFMUstate"), kind.get("canSerializeFMUstate")) == ("true", "true")
    experiment = root.find("DefaultExperiment")
    assert experiment is not None
    assert experiment.get("stepSize") == {"plant": "0.001", "sensors": "0.001", "controller": "0.005"}[fmu.stem]


def test_reset_and_a_second_instance_give_the_same_run(fmu):
    python(
        OPEN
        + """
with Driven(argument(0), "a") as a, Driven(argument(0), "b") as b:
    a.initialize(); b.initialize()
    first = a.drive(0, 30)
    assert first[0] != first[-1]
    half = b.drive(0, 15)
    assert half == first[:15]
    a.fmu.reset(); a.initialize()
    assert a.drive(0, 30) == first
    assert b.drive(15, 30) == first[15:]  # a's reset did not touch b
""",
        fmu,
    )


SAVE = """
with Driven(argument(0)) as one:
    one.initialize()
    one.drive(0, 33)
    state = one.fmu.getFMUState()
    Path(argument(1)).write_bytes(bytes(one.fmu.serializeFMUState(state)))
    rest = one.drive(33, 70)
    one.fmu.setFMUState(state)
    assert one.outputs() != rest[-1]
    assert one.drive(33, 70) == rest
    one.fmu.freeFMUState(state)
    Path(argument(2)).write_text(json.dumps(rest))
"""
RESUME = """
with Driven(argument(0)) as one:
    state = one.fmu.deSerializeFMUstate(Path(argument(1)).read_bytes())
    one.fmu.setFMUState(state)
    one.fmu.freeFMUState(state)
    assert one.drive(33, 70) == json.loads(Path(argument(2)).read_text())
"""


def test_a_state_saved_in_the_middle_of_a_run_continues_bitwise_in_another_process(fmu, tmp_path):
    python(OPEN + SAVE, fmu, tmp_path / "state", tmp_path / "rest")
    python(OPEN + RESUME, fmu, tmp_path / "state", tmp_path / "rest")


@pytest.mark.parametrize(("component", "own"), [("sensors", 0.001), ("controller", 0.005)])
@pytest.mark.parametrize("step", [0.0005, 0.00101, 0.002, 0.01, 0.0, -0.001])
def test_a_step_that_a_sampled_component_cannot_do_is_refused(fmus, component, own, step):
    python(
        OPEN
        + f"""
with Driven(argument(0)) as one:
    one.initialize()
    one.drive(0, 3)
    text = refused(one, 3 * STEP, {step})
    assert "a step of {step} s is not accepted; the step is {own} s" in text, text
""",
        fmus / "centralised" / f"{component}.fmu",
    )


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_plant_takes_any_step_and_ends_up_in_the_same_place(fmus, name):
    python(
        OPEN
        + """
import numpy as np
# A constant torque over 40 ms in steps of 0.5, 1 and 5 ms. The linear part is exact whatever the step; the gyroscopic
# terms err by 3e-5 of a micrometre (PHYSICS section 8), which is far less than a thousandth of what moves here.
ends = {}
for step in (5e-4, 1e-3, 5e-3):
    with Driven(argument(0)) as one:
        one.initialize()
        for k in range(round(0.04 / step)):
            wheels = sum(v.name.startswith("wheel.torque[") for v in one.of["input", "Real"])
            one.set("wheel.torque", *[0.1 * (-1) ** i for i in range(wheels)])
            one.fmu.doStep(k * step, step)
        ends[step] = np.array(one.get("modal.displacement", 25) + one.get("rate", 3))
        assert not one.messages
size = np.abs(ends[5e-4]).max()
assert size > 0.0
for step in (1e-3, 5e-3):
    assert np.abs(ends[step] - ends[5e-4]).max() < 1e-3 * size, step
# steps may change in the middle of a run, and none is not one
with Driven(argument(0)) as one:
    one.initialize()
    one.drive(0, 4, 5e-4); one.drive(2, 4, 1e-3); one.drive(1, 3, 5e-3)
    assert "a step is > 0 s" in refused(one, 0.014, 0.0)
""",
        fmus / name / "plant.fmu",
    )


PARAMETERS = {"plant": "wheel.torque_limit", "sensors": "gyro.noise", "controller": "slew.authority"}


def test_parameters_are_fixed_after_initialisation(fmu):
    python(
        OPEN
        + """
with Driven(argument(0)) as one:
    one.initialize()
    before = one.drive(0, 3)
    one.set(argument(1), 0.5)
    text = one.messages[0][2]
    assert f"{argument(1)} is a fixed parameter and cannot be set after initialisation, got 0.5" in text, text
    refused(one, 3 * STEP, STEP)
    one.fmu.reset(); one.messages.clear(); one.initialize()
    assert one.drive(0, 3) == before
""",
        fmu,
        PARAMETERS[fmu.stem],
    )


def test_a_wheel_may_seize_while_a_run_goes_on(fmus):
    python(
        OPEN
        + """
with Driven(argument(0)) as one, Driven(argument(0), "two") as two:
    one.initialize(), two.initialize()
    one.drive(0, 3)
    one.set("wheel.friction_torque", 46.2, 0.0)
    speeds = [one.get("wheel.speed", 2)]
    for k in range(3, 6):
        one.drive(k, k + 1)
        speeds.append(one.get("wheel.speed", 2))
    for (braked, free), (before, _) in zip(speeds[1:], speeds):
        assert abs(before - braked - 46.2 / 4.62 * 1e-3) < 1e-4, speeds  # the structure and the motor: 1 %
    assert abs(speeds[-1][1] - speeds[0][1]) < 1e-4
    saved = one.fmu.serializeFMUState(one.fmu.getFMUState())
    later = one.drive(6, 9)
    two.fmu.setFMUState(two.fmu.deSerializeFMUstate(bytes(saved)))
    assert two.drive(6, 9) == later  # the friction is part of the state
    one.set("wheel.friction_torque", 0.0)
    before = one.get("wheel.speed")
    one.drive(9, 12)
    assert abs(one.get("wheel.speed") - before) < 1e-4
    one.set("wheel.friction_torque", -1.0)
    assert "wheel.friction_torque[1] must be >= 0.0, got -1.0" in two.messages[0][2]  # one logger a process
""",
        fmus / "centralised" / "plant.fmu",
    )


def test_two_builds_give_equal_bytes_whatever_the_process_and_the_folder(fmus, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    environment = os.environ | {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "LC_ALL": "C"}
    subprocess.run(
        [FLEXSAT, "build", "--flat", "--out", "zweite Fassung"],
        check=True,
        capture_output=True,
        cwd=tmp_path / "elsewhere",
        env=environment,
    )

    again = tmp_path / "elsewhere" / "zweite Fassung"
    names = sorted(str(path.relative_to(fmus)) for path in fmus.rglob("*") if path.is_file())
    assert sorted(str(path.relative_to(again)) for path in again.rglob("*") if path.is_file()) == names
    assert len([name for name in names if name.endswith(".fmu")]) == 12
    assert [name for name in names if (fmus / name).read_bytes() != (again / name).read_bytes()] == []


def test_numpy_is_all_that_it_needs(fmu):
    python(
        """
import importlib.abc
class Refuse(importlib.abc.MetaPathFinder):
    names = {"scipy", "control", "clarabel", "flexsat", "flexbench", "lockstep", "matplotlib", "pyarrow", "rich"}
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"{name} is not installed here", name=name)
sys.meta_path.insert(0, Refuse())
try:
    import scipy
except ModuleNotFoundError:
    pass
else:
    raise AssertionError("scipy is there")
"""
        + OPEN
        + """
with Driven(argument(0)) as one:
    one.initialize()
    one.drive(0, 30)
loaded = {name.partition(".")[0] for name in sys.modules}
assert not loaded & Refuse.names, loaded & Refuse.names
""",
        fmu,
    )


# For each scalar input: which outputs move in the step that reads it, against what the description claims.
SAMPLED = """
import fmpy
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
def test_the_feedthrough_of_the_sensors_is_as_declared(fmus, name):
    changes = {
        "attitude.quaternion": 1e-3,
        "wheel.speed": 1e-2,
        "gyro_site.rate": 1e-6,
        "accelerometer_site.acceleration": 1e-3,
        "wheel.angle": 1e-2,
    }
    at = 100  # 0.1 s: everything is sampled in this step
    python(OPEN + SAMPLED, fmus / name / "sensors.fmu", *map(json.dumps, (changes, [{}], at, [])))


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_feedthrough_of_the_controller_is_as_declared(fmus, name):
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
    # With smoothed guidance the reference is a function of the command and the time, but its modes stay at rest; with
    # time-optimal guidance it is the state of a model, which moves a step later than its torque.
    never = [(f"reference.modal.{what}", f"command.{by}") for what in ("displacement", "velocity")
             for by in ("rotation", "start_time")]  # fmt: skip
    # At 0.6 s: nothing commanded, and then a slew since 0.5 s; a slew from 1.5 s on, and then one since 0.5 s. The
    # controller takes a new command until the old slew begins. Limits that no noise reaches, of which the slew uses
    # little.
    idle = {"command.start_time": 0.5, "command.rotation[1]": 0.0}
    waiting = {"command.start_time": 1.5, "command.rotation[1]": 1e-3}
    limits = {"wheel.torque_limit": 1e6, "wheel.speed_band": 1e6, "slew.authority": 7e-6}
    runs = [
        {"reference.smoothed": smoothed} | given | limits for smoothed in (True, False) for given in (idle, waiting)
    ]
    python(OPEN + SAMPLED, fmus / name / "controller.fmu", *map(json.dumps, (changes, runs, 120, never)))


PLANT = """
import fmpy
description = fmpy.read_model_description(argument(0))
claimed = {u.variable.name: {d.name for d in u.dependencies} for u in description.outputs}
port = lambda name: name.partition("[")[0]
through, later = set(), set()
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
    usual = {}
    for h in (1e-3, 1e-4):
        one.fmu.setFMUState(state)
        usual[h] = step(h)
    for v in one.of["input", "Real"]:
        change = {}
        for h in (1e-3, 1e-4):
            one.fmu.setFMUState(state)
            (before,) = one.fmu.getReal([v.valueReference])
            one.fmu.setReal([v.valueReference], [before + 0.3])
            change[h] = [abs(now - was) for now, was in zip(step(h), usual[h])]
        for output, long, short in zip(outputs, change[1e-3], change[1e-4]):
            # What goes through the state vanishes with the step, ten times at least; what feeds through does not.
            # 1e-9: below it the difference of two numbers of order one is rounding
            if long < 1e-9 * max(1.0, abs(usual[1e-3][outputs.index(output)])):
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
assert declared - through == {("accelerometer_site.acceleration", "jitter.torque_z")}, declared - through
assert {o for o, _ in later} >= {"rate", "wheel.speed", "gyro_site.rate", "energy", "angular_momentum"}, later
"""


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_feedthrough_of_the_plant_is_what_does_not_vanish_with_the_step(fmus, name):
    python(OPEN + PLANT, fmus / name / "plant.fmu")
