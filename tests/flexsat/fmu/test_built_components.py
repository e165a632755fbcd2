"""The six FMUs of the study as another team receives them, each in a fresh process."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

from fmus.toys.builds import python

CONFIGURATIONS, COMPONENTS = ("centralised", "distributed"), ("plant", "sensors", "controller")
SIX = [f"{name}/{component}" for name in CONFIGURATIONS for component in COMPONENTS]
FLEXSAT = Path(sys.executable).with_name("flexsat")

OPEN = "import json, sys; from pathlib import Path; from driven import *; from session import argument\n"


@pytest.fixture
def fmus(delivered):
    """Return a folder with the FMUs of both configurations."""
    return delivered


@pytest.fixture(params=SIX)
def fmu(request, fmus):
    """Return each of the six in turn."""
    return fmus / f"{request.param}.fmu"


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


WITH_NUMPY_ALONE = """
import importlib.abc, sys
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
RESET = """
with Driven(argument(0), "a") as a, Driven(argument(0), "b") as b:
    a.initialize(); b.initialize()
    first = a.drive(0, 30)
    assert first[0] != first[-1]
    half = b.drive(0, 15)
    assert half == first[:15]
    a.fmu.reset(); a.initialize()
    assert a.drive(0, 30) == first
    assert b.drive(15, 30) == first[15:]  # a's reset did not touch b
loaded = {name.partition(".")[0] for name in sys.modules}
assert not loaded & Refuse.names, loaded & Refuse.names
"""


def test_reset_and_a_second_instance_give_the_same_run_with_numpy_alone(fmu):
    python(WITH_NUMPY_ALONE + OPEN + RESET, fmu)


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
FIXED_PARAMETERS = """
with Driven(argument(0)) as one:
    one.initialize()
    before = one.drive(0, 3)
    try:
        one.set(argument(3), 0.5)
    except FMICallException as error:
        assert error.status == 3
    text = one.messages[0][2]
    assert f"{argument(3)} is a fixed parameter and cannot be set after initialisation, got 0.5" in text, text
    refused(one, 3 * STEP, STEP)
    one.fmu.reset(); one.messages.clear(); one.initialize()
    assert one.drive(0, 3) == before
"""
RESUME = """
with Driven(argument(0)) as one:
    state = one.fmu.deSerializeFMUstate(Path(argument(1)).read_bytes())
    one.fmu.setFMUState(state)
    one.fmu.freeFMUState(state)
    assert one.drive(33, 70) == json.loads(Path(argument(2)).read_text())
"""
PARAMETERS = {"plant": "wheel.torque_limit", "sensors": "gyro.noise", "controller": "slew.authority"}


def test_saved_state_continues_bitwise_in_another_process_and_parameters_are_fixed(fmu, tmp_path):
    files = (tmp_path / "state", tmp_path / "rest")
    python(OPEN + SAVE + FIXED_PARAMETERS, fmu, *files, PARAMETERS[fmu.stem])
    python(OPEN + RESUME, fmu, *files)


@pytest.mark.parametrize("component", ["sensors", "controller"])
def test_sampled_components_refuse_any_other_step(fmus, component):
    python(
        OPEN
        + """
with Driven(argument(0)) as one:
    for step in (0.0005, 0.00101, 0.002, 0.01, 0.0, -0.001):
        one.messages.clear(); one.initialize()
        one.drive(0, 3)
        text = refused(one, 3 * STEP, step)
        assert f"a step of {step} s is not accepted; the step is {STEP} s" in text, text
        one.fmu.reset()
""",
        fmus / "centralised" / f"{component}.fmu",
    )


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_plant_reaches_the_same_state_with_any_step(fmus, name):
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
    one.drive(0, 4, 5e-4); one.drive(2, 5, 1e-3); one.drive(1, 3, 5e-3)
    assert "a step is > 0 s" in refused(one, 0.015, 0.0)
""",
        fmus / name / "plant.fmu",
    )


def test_wheel_friction_may_change_during_a_run(fmus):
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
        # the bus gives way, as nearly all of its inertia is that of the modes: 2 %
        assert abs(before - braked - 46.2 / 4.62 * 1e-3) < 3e-4, speeds
    assert abs(speeds[-1][1] - speeds[0][1]) < 1e-4
    saved = one.fmu.serializeFMUState(one.fmu.getFMUState())
    later = one.drive(6, 9)
    two.fmu.setFMUState(two.fmu.deSerializeFMUstate(bytes(saved)))
    assert two.drive(6, 9) == later  # the friction is part of the state
    one.set("wheel.friction_torque", 0.0)
    before = one.get("wheel.speed")
    one.drive(9, 12)
    assert abs(one.get("wheel.speed") - before) < 1e-3  # the bus rings; the brake would take 3e-2
    try:
        one.set("wheel.friction_torque", -1.0)
    except FMICallException as error:
        assert error.status == 3
    assert "wheel.friction_torque[1] must be >= 0.0, got -1.0" in two.messages[0][2]  # one logger a process
""",
        fmus / "centralised" / "plant.fmu",
    )


def test_builds_in_another_process_and_folder_and_on_another_processor_give_equal_bytes(fmus, tmp_path):
    """Another processor: other kernels of OpenBLAS, two threads, and numpy without AVX2 and FMA."""
    (tmp_path / "elsewhere").mkdir()
    environment = os.environ | {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "LC_ALL": "C"}
    environment |= {"OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "2", "NPY_DISABLE_CPU_FEATURES": "X86_V3"}
    environment["OPENBLAS_THREAD_TIMEOUT"] = "4"  # a thread without work sleeps soon, instead of using a core to wait
    subprocess.run(
        [FLEXSAT, "build", "--flat", "--no-native", "--out", "zweite Fassung"],
        check=True,
        capture_output=True,
        cwd=tmp_path / "elsewhere",
        env=environment,
    )

    again = tmp_path / "elsewhere" / "zweite Fassung"
    names = sorted(
        str(path.relative_to(fmus)) for path in fmus.rglob("*") if path.is_file() and "native" not in path.parts
    )
    assert sorted(str(path.relative_to(again)) for path in again.rglob("*") if path.is_file()) == names
    assert len([name for name in names if name.endswith(".fmu")]) == 12
    differing = [name for name in names if (fmus / name).read_bytes() != (again / name).read_bytes()]
    assert differing == ["ICD.html", "ICD.md", "manifest.json"]  # which list the native FMUs
    lines = (fmus / "ICD.md").read_text().splitlines()
    assert (again / "ICD.md").read_text().splitlines() == [line for line in lines if "/native/" not in line]
