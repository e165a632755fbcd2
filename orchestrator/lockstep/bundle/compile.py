"""Compile the library of a bundle, which is the same for every system: equal sources give equal bytes."""

from __future__ import annotations

import atexit
import importlib.util
import os
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from lockstep.bundle.platforms import PLATFORMS, VERSIONS
from lockstep.errors import InputError
from lockstep.tick.compiled import HEADERS as TICK_HEADERS
from lockstep.tick.compiled import SOURCES as TICK_SOURCES

_SOURCES = Path(__file__).parent / "c"
_WINDOWS = Path(__file__).parent / "windows"
# -ffp-contract=off: no fused operations, so that conversions are those of the master on every processor
_COMPILING = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden",
              "-DTICK_EXPORT=", "-DTICK_ONE_THREAD")  # fmt: skip
_UNIVERSAL = ("string", "stdio", "heap", "convert", "private", "utility", "runtime")  # parts of Windows' C library
_TIME_LIMIT = 600  # [s]


def sources(version: str = "2.0") -> dict[str, bytes]:
    """Return the C files of the library of a version of FMI, by name: not those of other versions."""
    others = tuple(f"fmi{one[0]}_" for one in VERSIONS if one != version)
    files = (path for path in sorted(_SOURCES.iterdir()) if path.suffix in (".c", ".h"))
    own = (path for path in files if path.suffix == ".h" or not path.name.startswith(others))
    return {path.name: path.read_bytes() for path in (*own, *TICK_SOURCES, *TICK_HEADERS)}


@cache
def library(platform: str | None, version: str = "2.0") -> bytes:
    """Return the library for a platform, which Zig compiles; for None, this machine's, by its own C compiler.

    `version` is that of FMI which hosts see.

    Raises
    ------
    InputError
        If there is no compiler, or it fails.
    """
    if platform is None:
        return _compiled(_own_compiler(), ("-Wl,--build-id=none",), ("-ldl",), sources(version))
    command = (_zig(), "cc", "-target", PLATFORMS[platform].target)
    if platform == "win64":
        libraries = ("-lkernel32", *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in _UNIVERSAL))
        runtime = {path.name: path.read_bytes() for path in _WINDOWS.iterdir()}
        return _compiled(command, ("-nostdlib", "-Wl,/Brepro"), libraries, sources(version) | runtime, zig=True)
    return _compiled(command, ("-nostdlib",), ("-lc", "-ldl"), sources(version), zig=True)


def _own_compiler() -> tuple[str, ...]:
    given = shlex.split(os.environ.get("CC", ""))
    for command in (given, ["cc"], ["gcc"], ["clang"]):
        if command and shutil.which(command[0]):
            return tuple(command)
    raise InputError(
        "a bundle needs a C compiler, and there is none; install gcc or clang, name one by CC, or, with the package "
        "ziglang (pip install ziglang), give --platforms linux64"
    )


def _zig() -> str:
    found = importlib.util.find_spec("ziglang")
    program = Path(found.origin).with_name("zig") if found and found.origin else None
    if program is None or not program.is_file():
        raise InputError(
            "--platforms: Zig compiles for chosen platforms, and it is missing: pip install ziglang, or leave "
            "--platforms out to build for this machine alone"
        )
    return str(program)


@cache
def _zig_cache() -> str:
    """Return a folder for what Zig makes once for each platform, such as import libraries."""
    folder = tempfile.mkdtemp(prefix="lockstep-zig-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _compiled(
    command: tuple[str, ...],
    linking: tuple[str, ...],
    libraries: tuple[str, ...],
    files: Mapping[str, bytes],
    zig: bool = False,
) -> bytes:
    # in a folder of its own, with plain names: no path of this machine gets into the library
    with tempfile.TemporaryDirectory(prefix="lockstep-bundle-") as folder:
        for name, content in files.items():
            Path(folder, name).write_bytes(content)
        environment = None  # for Zig without CPATH and its like, which would change what is built
        if zig:
            environment = {"ZIG_GLOBAL_CACHE_DIR": _zig_cache(), "ZIG_LOCAL_CACHE_DIR": folder, "TMPDIR": folder}
        units = sorted(name for name in files if name.endswith(".c"))
        objects = [unit.removesuffix(".c") + ".o" for unit in units]
        each = [(unit, "-o", made) for unit, made in zip(units, objects, strict=True)] if zig else [tuple(units)]
        for words in each:
            _run([*command, *_COMPILING, "-c", *words], folder, environment)
        _run([*command, "-shared", "-s", *linking, "-o", "bundle", *objects, *libraries], folder, environment)
        return Path(folder, "bundle").read_bytes()


def _run(command: list[str], folder: str, environment: Mapping[str, str] | None) -> None:
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=environment, timeout=_TIME_LIMIT
    )
    if done.returncode:
        reason = next((line for line in done.stderr.splitlines() if "error" in line), "it gave no reason")
        raise InputError(f"{Path(command[0]).name} cannot compile the library of a bundle: {reason.strip()}")
