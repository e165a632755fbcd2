"""Compile FMUs that are written in C, and pack them: one place for compiler, flags, headers and archive layout."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import fmpy

HEADERS = Path(fmpy.__file__).parent / "c-code"  # of FMI 1.0, 2.0 and 3.0
FLAGS = ("-std=gnu11", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC")
PLATFORM = {1: fmpy.platform, 2: fmpy.platform, 3: fmpy.platform_tuple}  # folder below binaries/ by FMI version
_DEFAULTS = Path(__file__).parent / "default_functions"


def compile_library(
    library: Path,
    sources: Iterable[Path],
    *,
    fmi: int = 2,
    defines: Iterable[str] = (),
    include: Iterable[Path] = (),
    options: Iterable[str] = (),
) -> None:
    """Compile sources to the library of an FMU, with defaults of the FMI functions that they lack.

    Parameters
    ----------
    fmi : major version, of the defaults; there are none for FMI 1.0
    defines : NAME or NAME=value
    include : folders of headers
    options : further options of gcc, after the usual ones
    """
    defaults = [_DEFAULTS / f"fmi{fmi}_defaults.c"] if fmi > 1 else []
    arguments = [*(f"-D{define}" for define in defines), *(f"-I{folder}" for folder in (HEADERS, *include))]
    command = ["gcc", *FLAGS, *options, *arguments, "-o", library, *sources, *defaults, "-lm"]
    library.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(command, check=True)


def pack_fmu(
    path: Path, description: str, library: Path, *, fmi: int = 2, files: Mapping[str, str] | None = None
) -> Path:
    """Write an FMU of a model description, a library and further files by name; return its path.

    The library keeps its file name: the model identifier of the description must be its stem.
    """
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{PLATFORM[fmi]}/{library.name}")
        for name, content in (files or {}).items():
            archive.writestr(name, content)
    return path


def quoted(name: str, value: str) -> str:
    """Return the definition of a C string, for `defines`."""
    return f'{name}="{value}"'
