"""What a native FMU of FMI 3.0 contains: a variable a port, valid files, and every function of the standard."""

import re
import shutil
import subprocess
import zipfile
from ctypes import c_double, c_size_t, c_uint32
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.model_description import read_build_description
from fmpy.validation import validate_fmu
from lxml import etree

from flexsat.description.built_in import configuration
from flexsat.fmu.documentation.content import MODEL_PICTURE, accompanying_files
from flexsat.fmu.documentation.device_rows import DeviceRows
from flexsat.fmu.documentation.experiments import Experiment
from flexsat.fmu.documentation.reference_results import Run
from flexsat.fmu.documentation.terminals import terminals_xml
from flexsat.fmu.native.compile import OPTIONS, native_notes
from flexsat.fmu.native.export import native_content
from flexsat.fmu.native.fmi3_description import OPTIONS as BUILD_OPTIONS
from flexsat.fmu.native.sources import FOLDER
from flexsat.ports.table import Port, PortTable
from fmus.native.native_toy import build_follower, compiler_is_missing, counter_component
from fmus.raw_fmu3 import ERROR, OK, Library3

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
WARNINGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off", "-fsyntax-only")


@pytest.fixture(scope="module")
def unpacked(native_toy_fmi3, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(native_toy_fmi3) as archive:
        archive.extractall(folder)
    return folder


def assert_valid(content, schema):
    etree.XMLSchema(etree.parse(SCHEMAS / schema)).assertValid(etree.fromstring(content))


def test_the_files_are_valid_and_fmpy_finds_nothing_to_object_to(native_toy_fmi3, unpacked):
    assert_valid((unpacked / "modelDescription.xml").read_bytes(), "fmi3ModelDescription.xsd")
    assert_valid((unpacked / "sources" / "buildDescription.xml").read_bytes(), "fmi3BuildDescription.xsd")
    assert validate_fmu(str(native_toy_fmi3)) == []
    found = fmpy.simulate_fmu(str(native_toy_fmi3), stop_time=0.02, step_size=0.01, output_interval=0.01,
                              start_values={"gain": 2.0})  # fmt: skip
    assert found["level"].shape == (3, 3)
    assert np.array_equal(found["level"][0], [2.0] * 3)
    assert found["angle"].tolist() == [0.0, 0.01, 0.02]


def test_each_port_is_one_variable_with_the_facts_of_fmi_2(native_toy, unpacked):
    with zipfile.ZipFile(native_toy) as archive:
        two = ElementTree.fromstring(archive.read("modelDescription.xml"))
    three = ElementTree.parse(unpacked / "modelDescription.xml").getroot()
    time, *variables = three.find("ModelVariables")
    types = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
    texts = {"true": "true", "false": "false"}

    assert (time.tag, time.get("valueReference"), time.get("causality")) == ("Float64", "0", "independent")
    scalars = iter(two.find("ModelVariables"))
    for variable in variables:
        size = variable.find("Dimension")
        own = [next(scalars) for _ in range(1 if size is None else int(size.get("start")))]
        assert [s.get("name") for s in own] == (
            [variable.get("name")] if size is None else [f"{variable.get('name')}[{k + 1}]" for k in range(len(own))]
        )
        for attribute in ("description", "causality", "variability", "initial"):
            assert {s.get(attribute) for s in own} == {variable.get(attribute)}, attribute
        for attribute in ("unit", "displayUnit", "min", "max"):
            assert {s[0].get(attribute) for s in own} == {variable.get(attribute)}, attribute
        assert variable.tag == types[own[0][0].tag]
        given = [s[0].get("start") for s in own if s[0].get("start") is not None]
        text = variable.find("Start")
        shown = variable.get("start", "").split() if text is None else [text.get("value")]
        assert [texts.get(v, v) for v in given] == shown
    assert next(scalars, None) is None
    references = [int(v.get("valueReference")) for v in variables]
    assert sorted(references) == list(range(1, len(variables) + 1))
    units = {u.get("name"): [(e.tag, e.attrib) for e in u] for u in three.find("UnitDefinitions")}
    assert all(units[u.get("name")] == [(e.tag, e.attrib) for e in u] for u in two.find("UnitDefinitions"))
    assert three.find("DefaultExperiment").attrib == two.find("DefaultExperiment").attrib


def test_the_structure_is_that_of_fmi_2_by_ports(native_toy, unpacked):
    with zipfile.ZipFile(native_toy) as archive:
        two = ElementTree.fromstring(archive.read("modelDescription.xml"))
    three = ElementTree.parse(unpacked / "modelDescription.xml").getroot()
    names = {v.get("valueReference"): v.get("name") for v in three.find("ModelVariables")}
    scalars = [v.get("name").partition("[")[0] for v in two.find("ModelVariables")]

    for old, new in (("Outputs", "Output"), ("InitialUnknowns", "InitialUnknown")):
        expected = {}
        for unknown in two.find(f"ModelStructure/{old}"):
            known = {scalars[int(k) - 1] for k in unknown.get("dependencies").split()}
            expected.setdefault(scalars[int(unknown.get("index")) - 1], set()).update(known)
        found = {
            names[u.get("valueReference")]: {names[k] for k in u.get("dependencies").split()}
            for u in three.findall(f"ModelStructure/{new}")
        }
        assert found == expected


def test_flags_are_those_of_the_library(unpacked):
    kind = ElementTree.parse(unpacked / "modelDescription.xml").getroot().find("CoSimulation").attrib
    true = {name for name, value in kind.items() if value == "true"}
    assert true == {"canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize"}
    assert {"needsExecutionTool", "hasEventMode", "providesIntermediateUpdate", "canBeInstantiatedOnlyOncePerProcess",
            "canReturnEarlyAfterIntermediateUpdate", "providesAdjointDerivatives"} <= kind.keys()  # fmt: skip


def test_every_function_of_the_standard_is_there_and_nothing_else(unpacked):
    library = unpacked / "binaries" / "x86_64-linux" / "toy.so"
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    names = {line.split()[-1] for line in symbols.splitlines()}
    declared = set(re.findall(r"FMI3\((fmi3\w+)\)", (FOLDER / "fmi3" / "fmi3.h").read_text(encoding="utf-8")))

    assert names == declared
    assert len(names) == 75  # fmi3Functions.h of FMI 3.0.2; hosts look for all of them, whatever an FMU is for


def test_the_library_needs_libc_and_libm_alone(unpacked):
    library = unpacked / "binaries" / "x86_64-linux" / "toy.so"
    listed = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
    needed = {line.split()[0].rsplit("/", 1)[-1] for line in listed.splitlines()}
    assert needed <= {"linux-vdso.so.1", "libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_sources_of_the_build_description_compile_without_warnings(unpacked, compiler):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} here")
    (build,) = read_build_description(str(unpacked))
    (files,) = build.sourceFileSets
    assert sorted(files.sourceFiles) == sorted(path.name for path in (unpacked / "sources").glob("*.c"))
    written = ElementTree.parse(unpacked / "sources" / "buildDescription.xml").getroot().find(".//SourceFileSet")
    assert (files.language, written.get("compilerOptions")) == ("C99", BUILD_OPTIONS)
    assert set(BUILD_OPTIONS.split()) < set(OPTIONS)
    own = [name for name in files.sourceFiles if name.startswith("fmi3")]

    done = subprocess.run([compiler, *WARNINGS, *own], cwd=unpacked / "sources", capture_output=True, text=True)

    assert done.returncode == 0, done.stderr


def test_equal_sources_give_equal_bytes_of_another_fmu_than_that_of_fmi_2(native_toy, unpacked):
    made = native_content(counter_component(), "3.0")
    with zipfile.ZipFile(native_toy) as archive:
        identity = archive.read("sources/identity.c")

    assert all((unpacked / name).read_bytes() == content for name, content in made.entries.items())
    assert made.guid.encode() in made.entries["sources/identity.c"]
    assert made.guid.encode() not in identity


def test_accompanying_files_have_a_column_and_a_member_a_port():
    experiment = Experiment(name="run", description="d", step=0.1, stop_time=0.1, record_every=1,
                            parameters={"p": (1.0, 2.0)}, stimuli=lambda _table, _time: {})  # fmt: skip
    ports = (
        Port(name="wheel.torque", causality="input", size=2, description="torque"),
        Port(name="on", causality="input", kind="boolean", description="on"),
        Port(name="external.force", causality="input", size=1, description="force"),
        Port(name="external.torque", causality="input", size=1, description="torque"),
        Port(name="y", causality="output", size=2, description="output"),
        Port(name="p", causality="parameter", size=2, description="parameter"),
    )
    run = Run(experiment=experiment, inputs=[[0.0, 1.5, -2.0, 0.1, 0.2, True]], outputs=[[0.0, 3.0, 4.0]])
    table = PortTable(ports)
    facts = {
        "model_name": "m",
        "version": "1",
        "step": 0.1,
        "stop": 1.0,
        "fmi": "3.0",
        "native": native_notes("m", (), "3.0"),
    }
    made = accompanying_files("plant", table, [run], {MODEL_PICTURE: b"png"}, config=configuration("centralised"),
                              devices=DeviceRows(mass="", wheels=(), gyros=(), accelerometers=()), **facts)  # fmt: skip

    folder = "extra/org.fmi-standard.fmi-ls-ref"
    order = [port.name for port in table if port.causality == "input"]
    assert made.extra[f"{folder}/run-stimuli.csv"].decode().splitlines()[0] == ",".join(
        f'"{name}"' for name in ("time", *order)
    )
    assert made.extra[f"{folder}/run-references.csv"] == b'"time","y"\n0.0,3.0 4.0\n'
    assert b'name="p[2]"' in made.extra[f"{folder}/run-parameters.ssv"]
    terminals = made.extra["terminalsAndIcons/terminalsAndIcons.xml"]
    assert_valid(terminals, "fmi3TerminalsAndIcons.xsd")
    members = [m.attrib for m in ElementTree.fromstring(terminals).iter("TerminalMemberVariable")]
    assert members[0] == {"variableName": "wheel.torque", "memberName": "wheel.torque", "variableKind": "signal"}
    assert b"wheel.torque[2]" in terminals_xml(table)  # of FMI 2.0
    assert made.extra["documentation/diagram.png"] == b"png"
    assert MODEL_PICTURE not in made.extra
    page = made.documentation["index.html"].decode()
    assert "FMI 3.0 for co-simulation" in page
    assert "Float64[2], continuous" in page
    assert "fmi2" not in page
    assert 'src="diagram.png"' in page
    assert "x86_64-linux" in made.documentation["externalDependencies.txt"].decode()
    assert "fmi2" not in made.documentation["externalDependencies.txt"].decode()


def test_directional_derivatives_are_those_of_whole_ports(tmp_path):
    if compiler_is_missing():
        pytest.skip(compiler_is_missing())
    build_follower(tmp_path / "follower.fmu", "3.0")
    library = Library3(tmp_path / "follower.fmu", tmp_path / "unpacked")
    kind = ElementTree.parse(library.folder / "modelDescription.xml").getroot().find("CoSimulation")
    assert kind.get("providesDirectionalDerivatives") == "true"
    reference = library.reference
    one = library.instantiate().initialise()

    def derivative(unknown, known, seed, size):
        references = [(c_uint32 * len(names))(*[reference[n] for n in names]) for names in (unknown, known)]
        found = (c_double * size)(*[77.0] * size)
        status = one.call("GetDirectionalDerivative", references[0], c_size_t(len(unknown)), references[1],
                          c_size_t(len(known)), (c_double * len(seed))(*seed), c_size_t(len(seed)), found,
                          c_size_t(size))  # fmt: skip
        return status, list(found)

    assert derivative(["x", "y"], ["u"], [1.0, 0.0], 3) == (OK, [0.0, 1.5, 1.0])
    assert derivative(["y"], ["u"], [10.0, 1.0], 2) == (OK, [16.0, 10.0])
    for arguments, reason in (
        ((["u"], ["u"], [1.0, 1.0], 2), "unknown 1: value reference 1 is not that of a Float64 output"),
        ((["y"], ["gain"], [1.0], 2), f"known 1: value reference {reference['gain']} is not that of a Float64 input"),
        ((["n"], ["u"], [1.0, 1.0], 1), f"unknown 1: value reference {reference['n']} is not that of a Float64 output"),
        ((["y"], ["u"], [1.0], 2), "1 values, where the knowns have 2 elements"),
        ((["y"], ["u"], [1.0, 2.0], 1), "1 values, where the unknowns have 2 elements"),
        ((["y"], ["u"], [1.0, float("nan")], 2), "seed 2 must be finite, got nan"),
    ):
        one.call("Reset")
        one.initialise().library.logged.clear()
        assert derivative(*arguments) == (ERROR, [77.0] * arguments[-1])
        assert [text for *_, text in library.logged] == [f"getDirectionalDerivative: {reason}"]
    one.free()


def test_a_name_that_is_no_identifier_is_refused():
    toy = counter_component()
    with pytest.raises(ValueError, match="model_name must be a C identifier, got 'a b'"):
        native_content(replace(toy, about=replace(toy.about, model_name="a b")), "3.0")
