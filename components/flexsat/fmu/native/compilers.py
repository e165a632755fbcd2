"""Find the C compiler for a platform: this machine's own, or Zig's, which builds for all from any Linux.

The version of the package `ziglang` pins Zig's compiler, its linker and the C libraries that it links with.
"""

from __future__ import annotations

import atexit
import importlib.metadata
import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ...errors import BuildError
from ..python.shim import c_compiler, require_linux, shim_library
from .platforms import PLATFORMS

_WINDOWS_RUNTIME = Path(__file__).with_name("windows") / "windows_runtime.c"
_STRIPPED = ("-shared", "-s")
# Zig would build static parts of each C library first, which the C files need nothing of
_ZIG_LINKING = (*_STRIPPED, "-nostdlib")
# parts of the Universal C Runtime that the C files call
_UNIVERSAL = ("math", "string", "stdio", "heap", "convert", "private", "utility", "runtime")
_ZIG_TARGETS = {  # oldest versions of the systems, by tuple of FMI 3.0
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-darwin": "x86_64-macos.11.0",
    "aarch64-darwin": "aarch64-macos.11.0",
}
_SUFFIXES = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}
_LIBRARIES = {
    "linux": ("-lc", "-lm"),
    "windows": tuple(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in _UNIVERSAL),
    "darwin": ("-lSystem",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Compiler:
    """A C compiler for one platform.

    Attributes
    ----------
    command : how a command begins
    linking : options of the command that links a library, before the objects
    libraries : those after them
    runtime : C file that is linked with each library; None for no such file
    suffix : of the library
    version : name and version, for the record of the build
    environment : of the command; None for that of this process
    """

    command: tuple[str, ...]
    linking: tuple[str, ...]
    libraries: tuple[str, ...]
    runtime: Path | None
    suffix: str
    version: str
    environment: tuple[tuple[str, str], ...] | None


def compiler_for(target: str | None) -> Compiler:
    """Return the compiler for a tuple of FMI 3.0, such as aarch64-linux; for None, this machine's own.

    Raises
    ------
    BuildError
        If this is another platform than Linux x86-64, or the compiler is missing.
    """
    return _own() if target is None else _zig(target)


def check_compilers(platforms: Sequence[str]) -> None:
    """Raise BuildError if this machine's compiler fails, or it or that for a platform is missing: before the design.

    Arguments as of `binaries`. What is compiled here for the FMUs in Python is kept for their build.
    """
    shim_library()
    for platform in platforms:
        for target in PLATFORMS[platform].targets:
            compiler_for(target)


def _own() -> Compiler:
    require_linux()
    command = tuple(c_compiler())
    # nothing that differs from build to build
    linking = (*_STRIPPED, "-Wl,--build-id=none")
    return Compiler(
        command=command,
        linking=linking,
        libraries=("-lm",),
        runtime=None,
        suffix=".so",
        version=_version(command),
        environment=None,
    )


@cache
def _version(command: tuple[str, ...]) -> str:
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    return (done.stdout.splitlines() or [command[0]])[0]


def _zig(target: str) -> Compiler:
    command = (str(_zig_program()), "cc", "-target", _ZIG_TARGETS[target])
    system = target.partition("-")[2]
    return Compiler(
        command=command,
        linking=(*_ZIG_LINKING, "-Wl,/Brepro") if system == "windows" else _ZIG_LINKING,  # no time of the build
        libraries=_LIBRARIES[system],
        runtime=_WINDOWS_RUNTIME if system == "windows" else None,
        suffix=_SUFFIXES[system],
        version=f"zig {importlib.metadata.version('ziglang')}",
        environment=(("ZIG_GLOBAL_CACHE_DIR", _zig_cache()),),  # CPATH and its like would change what is built
    )


def _zig_program() -> Path:
    found = importlib.util.find_spec("ziglang")
    program = Path(found.origin).with_name("zig") if found and found.origin else None
    if program is None or not program.is_file():
        raise BuildError(
            "binaries for chosen platforms are compiled with Zig, which is missing: pip install ziglang, or "
            "build without --platforms for this machine alone"
        )
    return program


@cache
def _zig_cache() -> str:
    """Return a folder for what Zig makes once for each platform, such as import libraries: it takes it a second."""
    folder = tempfile.mkdtemp(prefix="flexsat_zig_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
