"""Find the files that travel in an FMU, and keep the search path of the host clean."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote

BUILD_FILE = "build.json"  # written by the export: model name, GUID, version


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
