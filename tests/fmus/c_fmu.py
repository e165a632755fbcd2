"""Compile FMUs that are written in C, and pack them: one place for compiler, flags, headers and archive layout."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import fmpy

HEADERS = Path(fmpy.__file__).parent / "c-code"  # of FMI 1.0, 2.0 and 3.0
FLAGS = ("-std=gnu11", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC")
PLATFORM = {1: fmpy.platform, 2: fmpy.platform, 3: fmpy.platform_tuple}  # folder below binaries/ by FMI version
kept: Path | None = None  # folder of libraries that this session has compiled; tests/conftest.py gives it
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

    Many tests want the same one: it is compiled once a session.

    Parameters
    ----------
    fmi : major version, of the defaults; there are none for FMI 1.0
    defines : NAME or NAME=value
    include : folders of headers
    options : further options of gcc, after the usual ones
    """
    defaults = [_DEFAULTS / f"fmi{fmi}_defaults.c"] if fmi > 1 else []
    folders, units = [*include], [*sources, *defaults]
    arguments = [*(f"-D{define}" for define in defines), *(f"-I{folder}" for folder in (HEADERS, *folders))]
    command = ["gcc", *FLAGS, *options, *arguments, *map(str, units), "-lm"]
    library.parent.mkdir(parents=True, exist_ok=True)
    known = None if kept is None else kept / _key(command, {path.parent for path in units} | set(folders))
    if known is None or not known.exists():
        subprocess.run([*command, "-o", library], check=True)
    if known is None:
        return
    if known.exists():
        shutil.copyfile(known, library)
        library.chmod(0o755)
        return
    known.parent.mkdir(exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=known.parent, delete=False) as copy:  # whole for other workers, or not there
        copy.write(library.read_bytes())
    Path(copy.name).replace(known)


def _key(command: Iterable[str], folders: Iterable[Path]) -> str:
    """Return a name for what a command makes of the C files of some folders."""
    files = sorted(path for folder in folders for path in folder.glob("*.[ch]"))
    parts = [*(word.encode() for word in command), *(b"%s\0%s" % (str(f).encode(), f.read_bytes()) for f in files)]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


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
