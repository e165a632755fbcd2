"""What a native FMU contains, and what its library needs: libc and libm, and a C compiler to build it again."""

import html
import re
import shutil
import subprocess
import zipfile
from xml.etree import ElementTree

import fmpy
import pytest

from flexsat.errors import BuildError
from flexsat.fmu.documentation.page import external_dependencies
from flexsat.fmu.documentation.render import fill
from flexsat.fmu.native import compile as compilation
from flexsat.fmu.native.compile import compile_command, compile_library, microsoft_command, native_notes
from flexsat.fmu.native.export import native_content
from flexsat.fmu.native.kept_objects import VARIABLE as KEPT_OBJECTS
from flexsat.fmu.native.port_source import port_table
from flexsat.ports.table import Port, PortTable
from fmus.native.native_toy import counter_component
from fmus.raw_fmu import OK, Library

WARNINGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off", "-fsyntax-only")


@pytest.fixture(scope="module")
def unpacked(native_toy, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(native_toy) as archive:
        archive.extractall(folder)
    return folder


def test_the_description_is_that_of_the_python_fmu_but_for_what_differs(toy, unpacked):
    with zipfile.ZipFile(toy) as archive:
        python = ElementTree.fromstring(archive.read("modelDescription.xml"))
    native = ElementTree.parse(unpacked / "modelDescription.xml").getroot()

    for part in ("ModelVariables", "UnitDefinitions", "ModelStructure", "DefaultExperiment", "LogCategories"):
        texts = [[(e.tag, e.attrib) for e in root.find(part).iter()] for root in (python, native)]
        assert texts[0] == texts[1], part
    kind = native.find("CoSimulation").attrib
    assert kind == python.find("CoSimulation").attrib | {
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "false",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    assert native.get("guid") != python.get("guid")
    assert "PythonFMU" not in native.get("generationTool")
    listed = [file.get("name") for file in native.find("CoSimulation/SourceFiles")]
    assert listed == sorted(path.name for path in (unpacked / "sources").glob("*.c"))
    assert {"counter.c", "fmi2_life_cycle.c", "memory.c", "ports.c"} <= set(listed)
    assert fmpy.read_model_description(str(unpacked), validate=True).modelName == "toy"


def test_equal_sources_give_equal_bytes(unpacked, monkeypatch):
    monkeypatch.delenv(KEPT_OBJECTS, raising=False)  # nothing is kept: it is compiled again
    compilation._object.cache_clear()
    component = counter_component()
    made = native_content(component)

    for name, content in made.entries.items():
        assert (unpacked / name).read_bytes() == content, name
    assert made.guid.encode() in made.entries["sources/identity.c"]
    assert all(b"/tmp" not in content for content in made.entries.values())


def test_the_library_needs_libc_and_libm_alone_and_exports_fmi_alone(unpacked):
    library = unpacked / "binaries" / "linux64" / "toy.so"
    listed = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
    needed = {line.split()[0].rsplit("/", 1)[-1] for line in listed.splitlines()}

    assert needed <= {"linux-vdso.so.1", "libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    names = {line.split()[-1] for line in symbols.splitlines()}
    assert all(name.startswith("fmi2") for name in names)
    assert len(names) == 34  # of FMI 2.0 for co-simulation


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_sources_compile_without_warnings(unpacked, compiler):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} here")
    sources = sorted(path.name for path in (unpacked / "sources").glob("*.c"))

    done = subprocess.run([compiler, *WARNINGS, *sources], cwd=unpacked / "sources", capture_output=True, text=True)

    assert done.returncode == 0, done.stderr


def test_the_command_of_the_documentation_builds_the_library(native_toy, tmp_path):
    command = compile_command("toy")
    notes = native_notes("toy", (), "2.0")
    page = fill("hosting_native.html", model_name="toy", file="toy.fmu", stop_time=1.0, step_size=0.01, output="angle",
                native=notes, major="2")  # fmt: skip
    shown = html.unescape(re.search(r"<pre>\n(cc .*)\n</pre>", page.decode()).group(1))
    assert shown == command
    dependencies = external_dependencies(notes).decode()
    assert {command, microsoft_command("toy")} <= {line.strip() for line in dependencies.splitlines()}
    with zipfile.ZipFile(native_toy) as archive:
        archive.extractall(tmp_path)
    subprocess.run(shown, shell=True, cwd=tmp_path / "sources", check=True)
    (tmp_path / "sources" / "toy.so").rename(tmp_path / "binaries" / "linux64" / "toy.so")
    shutil.make_archive(str(tmp_path / "rebuilt"), "zip", tmp_path)
    library = Library(tmp_path / "rebuilt.zip", tmp_path / "unpacked")
    one = library.instantiate().initialise()
    assert one.step(0.0) == OK
    one.free()


def test_a_build_without_a_compiler_is_refused_in_one_line(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(BuildError, match=r"C compiler 'no-such-compiler': not found; install gcc, or name one in CC"):
        compile_library({"x.c": b"int x;"}, "x")
    monkeypatch.delenv("CC")
    with pytest.raises(BuildError, match=r"cannot compile x.c: x.c:1:1: error"):
        compile_library({"x.c": b"nonsense"}, "x")


def test_limits_starts_and_flat_names_are_in_the_table_of_ports():
    ports = (
        Port(name="gain", causality="parameter", size=2, start=(1.0, 0.1), maximum=2.5, description="gain"),
        Port(name="mode", causality="parameter", kind="integer", start=3, minimum=-1, description="mode",
             variability="tunable"),
        Port(name="y.out", causality="output", size=1, on_demand=True, description="output"),
    )  # fmt: skip
    text = port_table(PortTable(ports, "flat"))

    assert "static const double starts_1[2] = {\n    0x1.p0, 0x1.999999999999ap-4,\n};" in text
    assert (
        '{"gain", REAL, PARAMETER | ARRAY | STARTS, 1, 2,\n     -DBL_MAX, 0x1.4p1, NULL, "2.5", 0x1.p0, starts_1'
        in text
    )
    assert '{"mode", INTEGER, PARAMETER | TUNABLE | STARTS, 0, 1,\n     -0x1.p0, DBL_MAX, "-1", NULL, 0x1.8p1,' in text
    assert '{"y_out", REAL, OUTPUT | ARRAY | ON_DEMAND, 0, 1,' in text
    assert "port_of_reference[] = {\n    0, 1, 1, 2,\n};" in text
    with pytest.raises(ValueError, match="port names: its elements start with different texts"):
        port_table(PortTable([Port(name="names", causality="parameter", kind="string", size=2, start=("a", "b"),
                                   description="names")]))  # fmt: skip
