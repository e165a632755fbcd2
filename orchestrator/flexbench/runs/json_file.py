"""JSON files in results folders: written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from flexsat.fmu.reproducible_zip import write_atomically


def write_json(path: Path, content: Any, indent: int | None = 2) -> Path:
    """Write a JSON file and return its path; `indent` None is for long arrays, which then take one line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, (json.dumps(content, indent=indent) + "\n").encode())
    return path


def read_json(path: Path) -> Any:
    """Return the content of a JSON file, None if there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
