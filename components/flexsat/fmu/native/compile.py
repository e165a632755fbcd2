"""Compile the C files of a native FMU into the library that a host loads: equal sources give equal bytes."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from ...errors import BuildError
from ..python.shim import c_compiler, require_linux
from .sources import GENERATED, INCLUDE

# -ffp-contract=off: no fused operations, so that results are the same on every processor
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
_COMPILING = tuple(option for option in OPTIONS if option != "-shared")
TOP = 10_000  # bytes of a file that its includes stand in; matrices follow them
_LINKING = ("-shared", "-s", "-Wl,--build-id=none")  # nothing that differs from build to build


def compile_library(sources: Mapping[str, bytes], name: str) -> bytes:
    """Compile sources for Linux x86-64, and return the library.

    Parameters
    ----------
    sources : C files and headers by name
    name : of the library, for messages

    Raises
    ------
    BuildError
        If this is another platform, or there is no C compiler (`CC`, or cc, or gcc), or it fails.
    """
    require_linux()
    compiler = tuple(c_compiler())
    units = sorted(file for file in sources if file.endswith(".c"))
    objects = {}
    for unit in units:
        needed = _needed(unit, sources)
        if not GENERATED & needed.keys():  # the same in other FMUs
            objects[unit] = _object(compiler, unit, tuple(needed.items()))
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        for file, content in sources.items():
            Path(folder, file).write_bytes(content)
        for unit, content in objects.items():
            Path(folder, _object_name(unit)).write_bytes(content)
        own = [unit for unit in units if unit not in objects]
        if own:
            _run([*compiler, *_COMPILING, "-c", *own], folder, name)
        linked = [_object_name(unit) for unit in units]
        _run([*compiler, *_LINKING, "-o", "library.so", *linked, "-lm"], folder, name)
        return Path(folder, "library.so").read_bytes()


def compile_command(name: str) -> str:
    """Return the command that compiles an FMU's library in its folder sources/."""
    return f"cc {' '.join(OPTIONS)} -o {name}.so *.c -lm"


def _object_name(unit: str) -> str:
    return unit.removesuffix(".c") + ".o"


def _needed(unit: str, sources: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return a unit with all headers that it includes, and those include."""
    found: dict[str, bytes] = {}
    todo = [unit]
    while todo:
        file = todo.pop()
        if file in sources and file not in found:
            found[file] = sources[file]
            todo += INCLUDE.findall(sources[file][:TOP].decode("ascii"))
    return dict(sorted(found.items()))


@cache
def _object(compiler: tuple[str, ...], unit: str, files: tuple[tuple[str, bytes], ...]) -> bytes:
    """Compile a unit that several FMUs have, once."""
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        for file, content in files:
            Path(folder, file).write_bytes(content)
        _run([*compiler, *_COMPILING, "-c", unit], folder, unit)
        return Path(folder, _object_name(unit)).read_bytes()


def _run(command: Sequence[str], folder: str, name: str) -> None:
    # in the folder, with plain names: no path of this machine gets into the library
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = next((line for line in done.stderr.splitlines() if "error" in line), "it gave no reason")
        raise BuildError(f"{command[0]} cannot compile {name}: {reason.strip()}")
