"""The C sources by the rules of Microsoft's compiler: its headers, 32-bit `long`, no extension, no long strings.

The compiler is clang for Microsoft's target; the headers declare what the sources use of Microsoft's C library.
"""

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from flexsat.fmu.native.sources import component_sources, generated_sources
from fmus.native.native_toy import HERE, counter_component

HEADERS = HERE / "microsoft"
OPTIONS = ("--target=x86_64-pc-windows-msvc", "-fms-compatibility", "-fms-compatibility-version=19.30", "-std=c99",
           "-nostdlibinc", "-isystem", str(HEADERS), "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion",
           "-Wshorten-64-to-32", "-Wvla", "-Wgnu", "-pedantic", "-Werror")  # fmt: skip
LONGEST_STRING = 65535  # bytes
LARGE = 1_000_000  # bytes of generated matrices, all of one form

pytestmark = pytest.mark.skipif(shutil.which("clang") is None, reason="no clang here: apt-get install clang")


def complaints(folder: Path, units: list[str]) -> str:
    """Return what the compiler says of C files in a folder."""
    done = subprocess.run(["clang", *OPTIONS, *units], cwd=folder, capture_output=True, text=True, check=False)
    return done.stderr


def sources(fmu: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("sources/")]
        return {name.removeprefix("sources/"): archive.read(name) for name in names}


def test_the_sources_compile_without_warnings(delivered, tmp_path):
    counter = counter_component()
    layer = component_sources(counter.main, "3.0") | generated_sources("counter", counter.table, {})
    found = {name: sources(delivered / "centralised" / "native" / f"{name}.fmu")
             for name in ("plant", "sensors", "controller")}  # fmt: skip
    seen: set[bytes] = set()
    for name, files in {**found, "FMI 3.0": layer}.items():
        folder = tmp_path / name
        folder.mkdir()
        for file, content in files.items():
            (folder / file).write_bytes(content)
            longest = max(map(len, re.findall(rb'"(?:[^"\\]|\\.)*"', content)), default=0)
            assert longest < LONGEST_STRING, file
        new = [file for file, content in files.items()
               if file.endswith(".c") and content not in seen and len(content) < LARGE]  # fmt: skip
        seen |= set(files.values())
        assert complaints(folder, new) == "", name


def test_the_check_notices_what_microsoft_has_not(tmp_path):
    for name, line in {
        "a": "int f(unsigned long long x) { return (int)(long)x == 1; } long g(unsigned long long x) { return x; }",
        "b": "#include <math.h>\ndouble f(void) { return M_PI; }",
        "c": "int f(int n) { double x[n]; return (int)sizeof x; }",
        "d": "#include <unistd.h>\nint x;",
        "e": "int f(int x) { return x ?: 1; }",
    }.items():
        folder = tmp_path / name
        folder.mkdir()
        (folder / "x.c").write_text(f"{line}\n")
        assert "error" in complaints(folder, ["x.c"]), name
