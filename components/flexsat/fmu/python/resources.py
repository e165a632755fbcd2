"""Find the files that travel in an FMU; undo what pythonfmu's wrapper leaves in the host's search path and memory."""

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
WRAPPER = "libpythonfmu-export.so"  # pythonfmu's library; the one named after the model is the shim

_wrappers: set[Path] = set()  # of this FMU's instances, to be finalised at the end of the process


def resource_folder(resources: str) -> Path:
    """Return the folder that the wrapper names; it decodes spaces only, so other characters are decoded here."""
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
    """Return what the export wrote about the build; an empty dict for an instance outside an FMU."""
    path = None if resources is None else resource_folder(resources) / BUILD_FILE
    if path is None or not path.is_file():
        return {}
    facts: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return facts


def remove_from_search_path(resources: str | None) -> None:
    """Remove the entry that the wrapper adds to the search path at each instantiation and leaves there."""
    sys.path[:] = [entry for entry in sys.path if entry != resources]
    sys.path_importer_cache.pop(str(resources), None)


def finalise_at_exit(resources: str) -> None:
    """Free the interpreter state of the wrapper's library once, before the process ends.

    pythonfmu 0.7 frees it twice: the destructor of a static pointer frees the state, then the library's own destructor
    writes to the freed memory. Depending on its address, the host ends with "corrupted double-linked list" after all
    its work is done. The second destructor does nothing if its exported function has run before the first.
    """
    if sys.platform == "linux":
        folder = resource_folder(resources).parent / "binaries" / "linux64"
        if not _wrappers:
            atexit.register(_finalise)
        _wrappers.add(folder / WRAPPER)


def _finalise() -> None:
    for path in _wrappers:
        try:
            library = ctypes.CDLL(str(path), mode=os.RTLD_NOLOAD | os.RTLD_NOW)
        except OSError:  # unloaded by the host: then its destructors have run in the right order
            continue
        library.finalizePythonInterpreter()
