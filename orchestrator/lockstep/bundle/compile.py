"""Compile the library of a bundle, which is the same for every system: equal sources give equal bytes."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from lockstep.bundle.platforms import PLATFORMS
from lockstep.errors import InputError
from lockstep.tick.compiled import HEADERS as TICK_HEADERS
from lockstep.tick.compiled import SOURCES as TICK_SOURCES

_SOURCES = Path(__file__).parent / "c"
_WINDOWS = Path(__file__).parent / "windows"
# -ffp-contract=off: no fused operations, so that conversions are those of the master on every processor
_OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden", "-s",
            "-DTICK_EXPORT=", "-DTICK_ONE_THREAD")  # fmt: skip
_UNIVERSAL = ("string", "stdio", "heap", "convert", "private", "utility", "runtime")  # parts of Windows' C library
_TIME_LIMIT = 600  # [s]


def sources() -> dict[str, bytes]:
    """Return the C files of the library, by name."""
    own = (path for path in sorted(_SOURCES.iterdir()) if path.suffix in (".c", ".h"))
    return {path.name: path.read_bytes() for path in (*own, *TICK_SOURCES, *TICK_HEADERS)}


@cache
def library(platform: str | None) -> bytes:
    """Return the library for a platform, which Zig compiles; for None, this machine's, by its own C compiler.

    Raises
    ------
    InputError
        If there is no compiler, or it fails.
    """
    if platform is None:
        command = [*_own_compiler(), *_OPTIONS, "-Wl,--build-id=none"]
        return _compiled(command, ("-ldl",), sources(), {})
    zig = _zig()
    target = PLATFORMS[platform].target
    command = [zig, "cc", "-target", target, *_OPTIONS, "-nostdlib"]
    if platform == "win64":
        libraries = ("-lkernel32", *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in _UNIVERSAL))
        files = sources() | {path.name: path.read_bytes() for path in _WINDOWS.iterdir()}
        return _compiled([*command, "-Wl,/Brepro"], libraries, files, {"ZIG": "1"})
    return _compiled(command, ("-lc", "-ldl"), sources(), {"ZIG": "1"})


def compiler_text(platform: str | None) -> str:
    """Return what compiles the library for a platform, for messages and the documentation."""
    return "cc" if platform is None else f"zig {importlib.metadata.version('ziglang')}"


def _own_compiler() -> list[str]:
    given = shlex.split(os.environ.get("CC", ""))
    for command in (given, ["cc"], ["gcc"], ["clang"]):
        if command and shutil.which(command[0]):
            return command
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


def _compiled(
    command: list[str], libraries: tuple[str, ...], files: Mapping[str, bytes], environment: Mapping[str, str]
) -> bytes:
    # in a folder of its own, with plain names: no path of this machine gets into the library
    with tempfile.TemporaryDirectory(prefix="lockstep-bundle-") as folder:
        for name, content in files.items():
            Path(folder, name).write_bytes(content)
        units = sorted(name for name in files if name.endswith(".c"))
        variables = None
        if environment:
            caches = {"ZIG_LOCAL_CACHE_DIR": folder, "ZIG_GLOBAL_CACHE_DIR": folder, "TMPDIR": folder}
            variables = {"PATH": os.environ.get("PATH", ""), **caches}
        done = subprocess.run(
            [*command, "-o", "bundle", *units, *libraries],
            cwd=folder, capture_output=True, text=True, check=False, env=variables, timeout=_TIME_LIMIT,
        )  # fmt: skip
        if done.returncode:
            reason = next((line for line in done.stderr.splitlines() if "error" in line), "it gave no reason")
            raise InputError(f"{Path(command[0]).name} cannot compile the library of a bundle: {reason.strip()}")
        return Path(folder, "bundle").read_bytes()
