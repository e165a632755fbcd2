"""The libraries of one native FMU for all platforms: what they export and need, their folders, and the same bytes."""

import importlib.util
import json
import os
import re
from importlib.metadata import version

import pytest

from flexsat.errors import BuildError
from flexsat.fmu.documentation.page import external_dependencies
from flexsat.fmu.documentation.render import fill
from flexsat.fmu.native import compile as compilation
from flexsat.fmu.native import compilers
from flexsat.fmu.native.compile import compile_library, native_notes
from flexsat.fmu.native.compilers import check_compilers
from flexsat.fmu.native.export import native_content
from flexsat.fmu.native.kept_objects import VARIABLE
from flexsat.fmu.native.platforms import PLATFORMS, folders
from fmus.native.library_facts import elf_facts, macos_facts, universal_parts
from fmus.native.native_toy import counter_component

ALL = tuple(PLATFORMS)
TARGETS = [target for platform in PLATFORMS.values() for target in platform.targets]
LINKER_OF_MACOS = {"_mh_dylib_header", "__dso_handle"}  # its linker adds them to every library
GLIBC = (2, 17)
SOURCES = {
    "x.c": b'#include "x.h"\n#include <math.h>\n#include <stdio.h>\nconst double x[] = {0x1.8p-3, 1e300};\n'
    b'EXPORT int f(char *text, double v) { return snprintf(text, 99, "%g %s", exp(v) * x[0], __FILE__); }\n',
    "x.h": b"#ifdef _WIN32\n#define EXPORT __declspec(dllexport)\n#else\n"
    b'#define EXPORT __attribute__((visibility("default")))\n#endif\n',
}

needs_zig = pytest.mark.skipif(
    importlib.util.find_spec("ziglang") is None, reason="Zig compiles for other platforms: pip install ziglang"
)


@pytest.fixture(scope="module")
def toy():
    """Return the toy's files with libraries for some platforms; tests/hosts builds for the others."""
    return native_content(counter_component(), platforms=("linux64", "darwin64")).entries


@needs_zig
def test_one_fmu_has_a_library_for_each_platform_that_exports_fmi_alone(toy):
    libraries = {name: content for name, content in toy.items() if name.startswith("binaries/")}
    assert set(libraries) == {"binaries/linux64/toy.so", "binaries/darwin64/toy.dylib"}
    linux = elf_facts(libraries["binaries/linux64/toy.so"])
    intel, apple = map(macos_facts, universal_parts(libraries["binaries/darwin64/toy.dylib"]))

    assert [facts.machine for facts in (linux, intel, apple)] == ["EM_X86_64", 0x01000007, 0x0100000C]
    assert linux.needed <= {"libc.so.6", "libm.so.6"}
    assert max(linux.versions) <= GLIBC
    assert len(linux.exports) == 34  # of FMI 2.0 for co-simulation
    assert all(name.startswith("fmi2") for name in linux.exports)
    for facts in (intel, apple):
        assert facts.needed == {"/usr/lib/libSystem.B.dylib"}
        assert facts.versions == ((11, 0),)
        assert facts.exports == linux.exports | LINKER_OF_MACOS
    assert apple.signed  # without a signature, macOS loads no library on ARM


@needs_zig
def test_the_record_of_the_build_names_the_compiler_of_each_library(toy):
    made = json.loads(toy["resources/build.json"])
    here = native_content(counter_component())
    own = json.loads(here.entries["resources/build.json"])["compilers"]

    assert made["compilers"] == dict.fromkeys(("linux64", "darwin64"), f"zig {version('ziglang')}")
    assert here.guid == made["guid"]  # of the sources
    assert list(own) == ["linux64"]
    assert re.search(r"\d+\.\d+", own["linux64"])


@needs_zig
@pytest.mark.parametrize("target", TARGETS)
def test_two_builds_give_the_same_bytes(target, tmp_path, monkeypatch):
    monkeypatch.delenv(VARIABLE)  # nothing is kept: each compiles
    first = compile_library(SOURCES, "x", target)
    for name in ("one", "elsewhere", "home"):
        (tmp_path / name).mkdir()
    compilation._object.cache_clear()
    monkeypatch.setattr(compilers, "_zig_cache", lambda: str(tmp_path / "one"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "elsewhere"))
    monkeypatch.chdir(tmp_path)
    others = {"HOME": str(tmp_path / "home"), "LANG": "de_DE.UTF-8", "TZ": "Asia/Tokyo", "CPATH": str(tmp_path),
              "C_INCLUDE_PATH": str(tmp_path), "CFLAGS": "-O0", "SOURCE_DATE_EPOCH": "99"}  # fmt: skip
    for name, value in others.items():
        monkeypatch.setenv(name, value)
    (tmp_path / "math.h").write_text("#error another header\n")
    before = os.umask(0o077)
    try:
        second = compile_library(SOURCES, "x", target)
    finally:
        os.umask(before)

    assert first == second
    assert b"x.c" in first  # the name of the file, and no path
    assert not [path for path in (b"/tmp", b"ziglang", str(tmp_path).encode()) if path in first]
    assert list((tmp_path / "elsewhere").iterdir()) == list((tmp_path / "home").iterdir()) == []


def test_folders_have_the_names_of_the_version():
    assert list(folders((), "2.0")) == ["linux64"]
    assert list(folders((), "3.0")) == ["x86_64-linux"]
    assert list(folders(ALL, "2.0")) == list(ALL)
    assert list(folders(ALL, "3.0")) == TARGETS


def test_the_documentation_lists_the_platforms():
    for fmi in ("2.0", "3.0"):
        notes = native_notes("toy", ALL, fmi)
        page = fill("hosting_native.html", model_name="toy", file="toy.fmu", stop_time=1.0, step_size=0.01,
                    output="angle", native=notes, major=fmi[0]).decode()  # fmt: skip
        for folder in folders(ALL, fmi):
            assert f"<li><code>{folder}</code>: " in page
            assert f"binaries/{folder}: " in external_dependencies(notes, fmi).decode()
        assert page.count("glibc 2.17 or newer") == 2
        assert page.count("(not tested)") == 2  # macOS on both processors


def test_without_zig_a_build_for_platforms_is_refused_in_one_line(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "ziglang" else find(name))
    check_compilers(())
    with pytest.raises(BuildError, match=r"compiled with Zig, which is missing: pip install ziglang, or build without"):
        check_compilers(("win64",))


@needs_zig
def test_what_zig_refuses_is_an_error_in_one_line():
    with pytest.raises(BuildError, match=r"^zig [\d.]+ cannot compile y.c: y.c:1:1: error: [^\n]*$"):
        compile_library({"y.c": b"nonsense"}, "y", "aarch64-linux")
