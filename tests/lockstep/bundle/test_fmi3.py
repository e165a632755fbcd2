"""A bundle as an FMU of FMI 3.0: its variables, its bits in other hosts, and the calls that it refuses."""

import ctypes
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from ctypes import byref, c_bool, c_double, c_int64, c_size_t, c_uint32, c_void_p
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.bundle_host import CLOSED, MS, alone, bits, bundled, recorded
from fmus.c_fmu import compile_library, pack_fmu
from fmus.raw_fmu3 import Library3
from lockstep import Component, System
from lockstep.bundle.ports import Choice
from lockstep.fmi.model_description import SCHEMAS

ERROR = 3
OPEN = Choice(inputs=("all",), outputs=("all",))
SOME = Choice(inputs=("push", "order", "number", "arm.u[2]", "fast.u[3]", "fast.b"), outputs=("all",))
NEEDED = {"linux-vdso.so.1", "libm.so.6", "libc.so.6", "/lib64/ld-linux-x86-64.so.2"}
# an input and an output that are an Enumeration, for the host an Int64 of FMI 3.0, in the bundle an Integer of 32 bits
_CHOICE = """
#include <stdlib.h>
#include "fmi2Functions.h"
static int held;
fmi2Component fmi2Instantiate(fmi2String a, fmi2Type b, fmi2String c, fmi2String d, const fmi2CallbackFunctions *e,
                              fmi2Boolean f, fmi2Boolean g)
{
    return malloc(1); /* it is freed by default */
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean b) { return fmi2OK; }
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[])
{
    for (size_t k = 0; k < n; k++) held = v[k];
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[])
{
    for (size_t k = 0; k < n; k++) v[k] = held;
    return fmi2OK;
}
"""
_CHOICE_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="choice" guid="g"><CoSimulation modelIdentifier="choice"/>
<TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="off" value="1"/><Item name="on" value="2"/>
</Enumeration></SimpleType></TypeDefinitions><ModelVariables>
<ScalarVariable name="in" valueReference="0" causality="input" variability="discrete">
<Enumeration declaredType="Mode" start="1"/></ScalarVariable>
<ScalarVariable name="out" valueReference="1" causality="output" variability="discrete">
<Enumeration declaredType="Mode"/></ScalarVariable></ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs><InitialUnknowns><Unknown index="2"/></InitialUnknowns>
</ModelStructure></fmiModelDescription>"""


@pytest.fixture(scope="module")
def path(cells, tmp_path_factory):
    """Return the bundle with some inputs and all outputs."""
    return bundled(cells, tmp_path_factory.mktemp("fmi3") / "four.fmu", SOME, version="3.0")


@pytest.fixture(scope="module")
def library(path, tmp_path_factory):
    """Return the bundle, unpacked and loaded."""
    return Library3(path, tmp_path_factory.mktemp("unpacked"))


@pytest.fixture
def fmu(library):
    """Return an instance; its log is empty."""
    library.logged.clear()
    made = library.instantiate()
    yield made
    made.free()


def described(path):
    """Return the root of the model description, and the variables by name."""
    root = ET.fromstring(zipfile.ZipFile(path).read("modelDescription.xml"))
    return root, {one.get("name"): one for one in root.find("ModelVariables")}


def test_whole_arrays_are_variables_and_the_description_is_valid(path):
    root, variables = described(path)
    text = zipfile.ZipFile(path).read("modelDescription.xml")

    assert validate_fmu(str(path)) == []
    etree.XMLSchema(file=str(SCHEMAS["3.0"])).assertValid(etree.fromstring(text))
    assert root.attrib["fmiVersion"] == "3.0"
    assert root.find("CoSimulation").attrib["canSerializeFMUState"] == "true"
    assert "binaries/x86_64-linux/four_cells.so" in zipfile.ZipFile(path).namelist()
    assert variables["fast.y"].find("Dimension").attrib == {"start": "3"}
    assert variables["fast.y"].attrib["unit"] == "rad"
    # two of arm's three inputs are connected, so that one element alone is exported; the connector is its own variable
    assert [name for name in variables if name.startswith("arm.u")] == ["arm.u[2]"]
    assert variables["push"].attrib["start"] == "0.0"
    assert variables["fast.label"].find("Start").attrib == {"value": "quick"}
    assert variables["slow.trim"].attrib["variability"] == "tunable"
    references = {one.get("valueReference"): name for name, one in variables.items()}
    outputs = {references[one.get("valueReference")]: [references[k] for k in one.get("dependencies").split()]
               for one in root.find("ModelStructure").iter("Output")}  # fmt: skip
    assert outputs["fast.y"] == ["number", "fast.u[3]", "fast.b"]
    assert outputs["body.y"] == []
    assert outputs.keys() == {name for name, one in variables.items() if one.get("causality") == "output"}


def test_an_array_whose_elements_differ_stays_elements(cells, tmp_path):
    part = replace(cells.components[0], parameters={})
    system = System(name="one", tick=MS, components=(part,))
    _, whole = described(bundled(system, tmp_path / "a.fmu", OPEN, version="3.0"))
    _, some = described(bundled(system, tmp_path / "b.fmu", Choice(outputs=("fast.y[1]", "fast.y[2]")), version="3.0"))

    assert whole["fast.u"].attrib["start"] == "0.0 0.0 0.0"
    assert {"fast.y[1]", "fast.y[2]"} <= some.keys()
    assert "fast.y" not in some


def test_the_master_and_fmpy_have_the_same_bits(cells, tmp_path):
    expected = recorded(cells, 0.02)
    names = expected.keys() - {"arm.text"}
    path = bundled(cells, tmp_path / "four.fmu", version="3.0")
    found = alone(path, 0.02)
    rows = fmpy.simulate_fmu(str(path), stop_time=0.02, step_size=0.001, output_interval=0.001,
                             output=["fast.y", "body.y", "arm.y"])  # fmt: skip

    for name in names:
        assert bits(found[name]) == bits(expected[name]), name
    for name in ("fast.y", "body.y", "arm.y"):
        wanted = np.column_stack([expected[f"{name}[{k}]"] for k in (1, 2, 3)])
        assert np.ascontiguousarray(rows[name]).tobytes() == wanted.tobytes(), name


def test_the_library_needs_the_c_library_alone(library):
    printed = subprocess.run(["ldd", library.path], capture_output=True, text=True, check=True).stdout

    assert {line.split()[0] for line in printed.splitlines()} <= NEEDED


def test_arrays_are_set_and_read_whole_and_the_time_with_them(cells, tmp_path):
    system = System(name="one", tick=MS, components=(replace(cells.components[2], parameters={"gain": 2.0}),))
    loaded = Library3(bundled(system, tmp_path / "one.fmu", OPEN, version="3.0"), tmp_path / "unpacked")
    fmu = loaded.instantiate()
    try:
        assert fmu.set("Float64", ["body.u", "body.gain"], [1.0, 2.0, 3.0, 4.0]) == 0
        assert fmu.set("Boolean", ["body.b"], [True]) == 0
        fmu.initialise()
        assert fmu.step(0.0) == 0
        assert (list(fmu.flags), fmu.reached.value) == ([False] * 3, 0.001)
        assert fmu.get("Float64", ["body.gain", "time", "body.u"]) == (0, [4.0, 0.001, 1.0, 2.0, 3.0])
        assert fmu.get("Boolean", ["body.b"]) == (0, [True])
        assert fmu.get("String", ["body.label"]) == (0, [b"cell"])
    finally:
        fmu.free()


WRONG_VALUES = {
    "there is no Float64 of this number": lambda fmu: fmu.set("Float64", [4_000_000_000], [0.0]),
    "there is no Int32 of this number": lambda fmu: fmu.get("Int32", ["push"])[0],
    "2 values, and the variables have 3 elements": lambda fmu: fmu.get("Float64", ["fast.y"], 2)[0],
    "is an output; only inputs and parameters": lambda fmu: fmu.set("Float64", ["fast.y"], [0.0] * 3),
    "is the time, which cannot be set": lambda fmu: fmu.set("Float64", ["push", "time"], [0.0] * 2),
    "is a fixed parameter; set it before initialization": lambda fmu: fmu.set("Float64", ["arm.gain"], [1.0]),
    "no variable of this type": lambda fmu: fmu.call("GetUInt8", (c_uint32 * 1)(), c_size_t(1), None, c_size_t(1)),
    "and no array of them or of the values": lambda fmu: fmu.call("SetFloat64", None, c_size_t(2), None, c_size_t(2)),
    "the FMU does not have this function": lambda fmu: fmu.call("EnterEventMode"),
    "a flag or the last successful time has no place": lambda fmu: fmu.call(
        "DoStep", c_double(0.0), c_double(0.001), c_bool(True), None, None, None, None
    ),
    "step 0.0015 s must be a multiple of 0.001 s": lambda fmu: fmu.step(0.0, 0.0015),
    "begins at 0.25 s, and the instance is at 0 s": lambda fmu: fmu.step(0.25),
    "has no place for the state, or no state": lambda fmu: fmu.call("SetFMUState", None),
    "the state is none of this instance": lambda fmu: fmu.call("SetFMUState", c_void_p(8)),
    "the bytes are no state of this FMU, or damaged": lambda fmu: fmu.deserialise(b"x" * 200)[0],
    "is not allowed now: the instance is in the state: step mode": lambda fmu: fmu.enter(),
}  # fmt: skip


def test_a_wrong_call_is_refused_in_one_line_and_changes_nothing(library, fmu):
    fmu.initialise()
    before = fmu.serialise(fmu.get_state()[1])
    for text, call in WRONG_VALUES.items():
        library.logged.clear()
        assert call(fmu) == ERROR, text
        assert len(library.logged) == 1, text
        assert library.logged[0][:2] == (ERROR, b"logStatusError")
        assert text in library.logged[0][2]
        assert fmu.serialise(fmu.get_state()[1]) == before, text
    assert fmu.step(0.0) == 0


def test_a_wrong_start_or_instance_is_refused_in_one_line(library, fmu):
    for arguments, text in (
        ({"token": b"{other}"}, "instantiation token {other}: the FMU's is {"),
        ({"resources": None}, "resourcePath (none): it must be the path of the folder resources"),
        ({"resources": b"/nowhere/"}, "resources/program.bin cannot be read"),
        ({"events": True}, "the FMU has no event mode"),
        ({"required": (1,)}, "the FMU has no intermediate update of variables"),
    ):
        library.logged.clear()
        assert library.instantiate(**arguments) is None
        assert [text in line[2] for line in library.logged] == [True], text
    kind = library.dll.fmi3InstantiateModelExchange
    assert kind(b"x", library.token, None, c_bool(False), c_bool(True), None, library.logger) is None
    assert "the FMU is one for co-simulation" in library.logged[-1][2]
    for call, text in (
        (lambda: fmu.enter(0.0, -1.0), "stop time -1 s must be after the start time 0 s"),
        (lambda: fmu.enter(float("nan")), "start time nan s must be a number"),
        (lambda: fmu.enter(tolerance=-1.0), "tolerance -1 must be > 0"),
        (lambda: fmu.step(0.0), "is not allowed now: the instance is in the state: instantiated"),
    ):
        assert call() == ERROR
        assert text in library.logged[-1][2]
    fmu.initialise()


def test_an_enumeration_travels_as_int64_and_too_large_a_value_is_refused(tmp_path):
    (tmp_path / "choice.c").write_text(_CHOICE, encoding="utf-8")
    compile_library(tmp_path / "choice.so", [tmp_path / "choice.c"], options=["-Wno-unused-parameter"])
    source = pack_fmu(tmp_path / "choice.fmu", _CHOICE_DESCRIPTION, tmp_path / "choice.so")
    system = System(name="one", tick=MS, components=(Component(name="it", source=source, period=MS),))
    path = bundled(system, tmp_path / "one.fmu", OPEN, version="3.0")
    assert validate_fmu(str(path)) == []
    loaded = Library3(path, tmp_path / "unpacked")
    fmu, found = loaded.instantiate().initialise(), c_int64()

    def call(name, variable, place):
        numbers = (c_uint32 * 1)(loaded.reference[variable])
        return fmu.call(name, numbers, c_size_t(1), place, c_size_t(1))

    assert call("SetInt64", "it.in", byref(c_int64(2))) == 0
    assert fmu.step(0.0) == 0
    assert (call("GetInt64", "it.out", byref(found)), found.value) == (0, 2)
    assert call("SetInt64", "it.in", byref(c_int64(2**40))) == ERROR
    assert "1099511627776: an enumeration has values of 32 bits" in loaded.logged[-1][2]
    fmu.free()


def test_the_folder_may_have_blanks_and_letters_of_any_language(path, tmp_path):
    folder = tmp_path / "räder 100% #1"
    loaded = Library3(path, folder)
    fmu = loaded.instantiate()
    assert fmu is not None, loaded.logged
    fmu.initialise()
    fmu.free()
    assert ctypes.CDLL(str(Path(loaded.path)))


def test_a_closed_bundle_has_no_input(cells, tmp_path):
    _, variables = described(bundled(cells, tmp_path / "four.fmu", CLOSED, version="3.0"))
    assert "input" not in {one.get("causality") for one in variables.values()}
