"""Compile the C files of a native FMU into the libraries that hosts load: equal sources give equal bytes."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path

from ...errors import BuildError
from ...ports.table import FmiVersion
from ..documentation.native_notes import NativeNotes
from .compilers import Compiler, compiler_for
from .kept_objects import VARIABLE as KEPT_OBJECTS
from .kept_objects import kept_object
from .platforms import folders, needs
from .sources import INCLUDE
from .universal_binary import universal_binary

# -ffp-contract=off: no fused operations, so that results are the same on every processor
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
_COMPILING = tuple(option for option in OPTIONS if option != "-shared")
TOP = 10_000  # bytes of a file that its includes stand in; matrices follow them
_SYSTEM_HEADER = re.compile(rb"^#include <([\w./]+)>", re.MULTILINE)
_MOST_OBJECTS = 1000  # that are kept: more than the FMUs of all platforms have


def binaries(
    sources: Mapping[str, bytes], name: str, platforms: Sequence[str] = (), fmi: FmiVersion = "2.0"
) -> dict[str, bytes]:
    """Compile sources for some platforms, and return the libraries by their path below binaries/.

    Parameters
    ----------
    sources : C files and headers by name
    name : of the library
    platforms : keys of PLATFORMS, which Zig compiles for; none for Linux x86-64 with this machine's compiler
    fmi : version that names the folders

    Raises
    ------
    BuildError
        If this is another platform than Linux x86-64, or the compiler is missing, or it fails.
    """
    found: dict[str, bytes] = {}
    for folder, targets in folders(platforms, fmi).items():
        suffix = compiler_for(targets[0] if platforms else None).suffix
        libraries = {target: compile_library(sources, name, target if platforms else None) for target in targets}
        universal = len(libraries) > 1
        found[f"{folder}/{name}{suffix}"] = universal_binary(libraries) if universal else libraries[targets[0]]
    return found


def native_notes(name: str, platforms: Sequence[str], fmi: FmiVersion) -> NativeNotes:
    """Return what the documentation says of the libraries; arguments as of `binaries`."""
    return NativeNotes(
        compile_command=compile_command(name),
        microsoft_command=microsoft_command(name),
        binaries=needs(platforms, fmi),
    )


def compile_library(sources: Mapping[str, bytes], name: str, target: str | None = None) -> bytes:
    """Compile sources for one platform, and return the library.

    Parameters
    ----------
    sources : C files and headers by name
    name : of the library
    target : tuple of FMI 3.0, which Zig compiles for; None for Linux x86-64 with this machine's compiler

    Raises
    ------
    BuildError
        As `binaries`.
    """
    compiler = compiler_for(target)
    units = sorted(file for file in sources if file.endswith(".c"))
    objects = {unit: _object(compiler, unit, tuple(_needed(unit, sources).items())) for unit in units}
    if compiler.runtime is not None:
        unit = compiler.runtime.name
        objects[unit] = _object(compiler, unit, ((unit, compiler.runtime.read_bytes()),))
    library = f"{name}{compiler.suffix}"
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        for unit, content in objects.items():
            Path(folder, _object_name(unit)).write_bytes(content)
        linked = [_object_name(unit) for unit in objects]
        _run(compiler, [*compiler.linking, "-o", library, *linked, *compiler.libraries], folder, name)
        return Path(folder, library).read_bytes()


def compile_command(name: str) -> str:
    """Return the command that compiles an FMU's library in its folder sources/."""
    return f"cc {' '.join(OPTIONS)} -o {name}.so *.c -lm"


def microsoft_command(name: str) -> str:
    """Return the same for Microsoft's compiler."""
    return f"cl /O2 /fp:precise /W3 /D_CRT_SECURE_NO_WARNINGS /LD /Fe{name}.dll *.c"


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


@lru_cache(_MOST_OBJECTS)
def _object(compiler: Compiler, unit: str, files: tuple[tuple[str, bytes], ...]) -> bytes:
    """Compile a unit that several FMUs have, once; in each process, or once for all that keep objects."""
    if not os.environ.get(KEPT_OBJECTS):
        return _compiled(compiler, unit, files)
    system_headers = sorted({name for _, content in files for name in _SYSTEM_HEADER.findall(content[:TOP])})
    inputs = [_identity(compiler), _headers(compiler, tuple(system_headers)), unit.encode()]
    inputs += [part for name, content in files for part in (name.encode(), content)]
    return kept_object(inputs, lambda: _compiled(compiler, unit, files))


def _compiled(compiler: Compiler, unit: str, files: Iterable[tuple[str, bytes]]) -> bytes:
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        for file, content in files:
            Path(folder, file).write_bytes(content)
        _run(compiler, [*_COMPILING, "-c", unit, "-o", _object_name(unit)], folder, unit)
        return Path(folder, _object_name(unit)).read_bytes()


def _identity(compiler: Compiler) -> bytes:
    """Return what distinguishes a compiler with its options from others, and from itself before an update."""
    program = shutil.which(compiler.command[0]) or compiler.command[0]
    found = Path(program).stat()
    update = (os.path.realpath(program), found.st_size, found.st_mtime_ns)
    return repr((compiler.command, compiler.version, _COMPILING, update)).encode()


@cache
def _headers(compiler: Compiler, names: tuple[bytes, ...]) -> bytes:
    """Return what the compiler's own headers come to, with all macros: another C library gives other objects."""
    lines = [b"#if %s__has_include(<%s>)\n#include <%s>\n#endif\n" % (_condition(name), name, name) for name in names]
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        Path(folder, "headers.c").write_bytes(b"".join(lines))
        _run(compiler, [*_COMPILING, "-E", "-dD", "headers.c", "-o", "headers.i"], folder, "headers.c")
        return Path(folder, "headers.i").read_bytes()


def _condition(header: bytes) -> bytes:
    """Return what must hold beside its being there: Clang has the headers of x86 everywhere, to refuse them."""
    return b"defined(__x86_64__) && " if header.endswith((b"mmintrin.h", b"cpuid.h")) else b""


def _run(compiler: Compiler, arguments: Sequence[str], folder: str, name: str) -> None:
    # in the folder, with plain names: no path of this machine gets into the library
    environment = None
    if compiler.environment is not None:
        environment = dict(compiler.environment) | {"ZIG_LOCAL_CACHE_DIR": folder, "TMPDIR": folder}
    command = [*compiler.command, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        reason = next((line for line in done.stderr.splitlines() if "error" in line), "it gave no reason")
        raise BuildError(f"{compiler.version if environment else command[0]} cannot compile {name}: {reason.strip()}")
