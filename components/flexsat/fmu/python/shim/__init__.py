"""Compile the shim, the C library that a host loads before pythonfmu's wrapper; `shim.c` describes it."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from ....errors import BuildError

SOURCES = ("shim.c", "calls.c", "states.c", "messages.c", "shim.h", "fmi2.h")
WRAPPER = "libpythonfmu-export.so"  # in the shim's folder; shim.c states the same name
_FLAGS = (
    "-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden", "-s",
    "-Wl,--build-id=none",  # equal sources give equal bytes
)  # fmt: skip


def shim_sources() -> dict[str, bytes]:
    """Return the sources by file name; they are part of what an FMU's GUID is made from."""
    return {name: Path(__file__).with_name(name).read_bytes() for name in SOURCES}


@cache
def shim_library(python: str = f"libpython{sys.version_info[0]}.{sys.version_info[1]}.so.1.0") -> bytes:
    """Compile the library for Linux x86-64; it is the same for every FMU.

    Parameters
    ----------
    python : library that the shim loads where the host has no Python

    Raises
    ------
    BuildError
        If this is another platform, or there is no C compiler (`CC`, or cc, or gcc), or it fails.
    """
    require_linux()
    compiler = c_compiler()
    with tempfile.TemporaryDirectory(prefix="flexsat_shim_") as folder:
        for name, content in shim_sources().items():
            Path(folder, name).write_bytes(content)
        # compiled in the folder by plain names: no path of this machine gets into the library
        units = [name for name in SOURCES if name.endswith(".c")]
        command = [*compiler, *_FLAGS, f'-DLIBPYTHON="{python}"', "-o", "shim.so", *units, "-ldl"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            reason = next((line for line in done.stderr.splitlines() if "error" in line), "it gave no reason")
            raise BuildError(f"{compiler[0]} cannot compile {SOURCES[0]}: {reason.strip()}")
        return Path(folder, "shim.so").read_bytes()


def require_linux() -> None:
    """Raise BuildError unless this is the platform that the FMUs are built for and on."""
    here = f"{platform.system()} {platform.machine()}"
    if here != "Linux x86_64":
        raise BuildError(f"FMUs are built on Linux x86_64, and this is {here}; build them there")


def c_compiler() -> list[str]:
    """Return the C compiler as the beginning of a command: `CC`, or cc, or gcc; raise BuildError if there is none."""
    given = os.environ.get("CC", "").split()
    compiler = given or [name for name in ("cc", "gcc") if shutil.which(name)][:1]
    if not compiler or not shutil.which(compiler[0]):
        raise BuildError(f"C compiler {' '.join(given) or 'cc'!r}: not found; install gcc, or name one in CC")
    return compiler
