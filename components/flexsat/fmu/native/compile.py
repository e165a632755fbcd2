"""Compile the C files of a native FMU into the library that a host loads: equal sources give equal bytes."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

from ...errors import BuildError
from ..python.shim import c_compiler, require_linux

# -ffp-contract=off: no fused operations, so that results are the same on every processor
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
_REPRODUCIBLE = ("-s", "-Wl,--build-id=none")


def compile_library(sources: Mapping[str, bytes], name: str, options: tuple[str, ...] = _REPRODUCIBLE) -> bytes:
    """Compile sources for Linux x86-64, and return the library.

    Parameters
    ----------
    sources : C files and headers by name
    name : of the library, for messages
    options : of the compiler, beside OPTIONS

    Raises
    ------
    BuildError
        If this is another platform, or there is no C compiler (`CC`, or cc, or gcc), or it fails.
    """
    require_linux()
    compiler = c_compiler()
    with tempfile.TemporaryDirectory(prefix="flexsat_native_") as folder:
        for file, content in sources.items():
            Path(folder, file).write_bytes(content)
        # compiled in the folder by plain names: no path of this machine gets into the library
        units = sorted(file for file in sources if file.endswith(".c"))
        command = [*compiler, *OPTIONS, *options, "-o", "library.so", *units, "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            reason = next((line for line in done.stderr.splitlines() if "error" in line), "it gave no reason")
            raise BuildError(f"{compiler[0]} cannot compile {name}: {reason.strip()}")
        return Path(folder, "library.so").read_bytes()


def compile_command(name: str) -> str:
    """Return the command that compiles an FMU's library in its folder sources/."""
    return f"cc {' '.join(OPTIONS)} -o {name}.so *.c -lm"
