"""JSON files in results folders: written whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lockstep import InputError
from lockstep.data_text import check_shape, parse_json
from lockstep.plain_values import plain_value
from lockstep.whole_file import write_whole

REMEDY = "delete it, or write it again"


def write_json(path: Path, content: Any, indent: int | None = 2) -> Path:
    """Write a JSON file and return its path; `indent` None is for long arrays, which then take one line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(content, indent=indent, default=lambda value: plain_value(value, path.name))  # numpy's
    write_whole(path, f"{text}\n".encode())
    return path


def read_json(path: Path) -> Any:
    """Return the content of a JSON file, None if there is no such file; raise InputError if it cannot be read."""
    if not path.is_file():
        return None
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    return parse_json(content, str(path), REMEDY)


def read_table(path: Path, shape: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the content of a JSON file, None if there is none; raise InputError if it has not this shape."""
    content = read_json(path)
    if content is None:
        return None
    check_shape(content, shape, str(path), REMEDY)
    return dict(content)
