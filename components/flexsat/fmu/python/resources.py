"""Find the files that travel in an FMU, and leave the host clean: its search path, and its memory when it ends."""

from __future__ import annotations

import atexit
import ctypes
import json
import os
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote

BUILD_FILE = "build.json"  # written by the export: model name, GUID, version
WRAPPER = "libpythonfmu-export.so"  # pythonfmu's library; the one named after the model stands in front of it

_libraries: set[Path] = set()  # wrappers of this FMU's instances, to be let go at the end of the process


def resource_folder(resources: str) -> Path:
    """Return the folder that the wrapper names; it decodes spaces only, so the rest is decoded here if need be."""
    folder = Path(resources)
    return folder if folder.is_dir() else Path(unquote(resources))


def find_resource(resources: str | None, name: str) -> Path:
    """Return the path of a resource."""
    if resources is None:
        raise ValueError(f"resource {name!r}: this instance was made without a resources folder")
    path = resource_folder(resources) / name
    if not path.is_file():
        raise ValueError(f"resource {name!r} is missing in {path.parent}")
    return path


def build_facts(resources: str | None) -> dict[str, Any]:
    """Return what the export wrote about the build; nothing for an instance outside an FMU."""
    path = None if resources is None else resource_folder(resources) / BUILD_FILE
    if path is None or not path.is_file():
        return {}
    facts: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return facts


def leave_search_path(resources: str | None) -> None:
    """Take the entry out that the wrapper adds to the search path at each instantiation and never removes."""
    sys.path[:] = [entry for entry in sys.path if entry != resources]
    sys.path_importer_cache.pop(str(resources), None)


def let_go_at_exit(resources: str) -> None:
    """See to it that the wrapper's library lets go of its interpreter state once, before the process ends.

    pythonfmu 0.7 does it twice: the destructor of a static pointer frees the state, then the library's own destructor
    writes to what was freed. Depending on where that lies, the host dies with "corrupted double-linked list" after all
    its work is done. The second does nothing when its exported function has run before the first.
    """
    if sys.platform == "linux":
        folder = resource_folder(resources).parent / "binaries" / "linux64"
        if not _libraries:
            atexit.register(_let_go)
        _libraries.add(folder / WRAPPER)


def _let_go() -> None:
    for path in _libraries:
        try:
            library = ctypes.CDLL(str(path), mode=os.RTLD_NOLOAD | os.RTLD_NOW)
        except OSError:  # unloaded by the host: then its destructors have run one after the other, in order
            continue
        library.finalizePythonInterpreter()
