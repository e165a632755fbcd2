"""Find the line of a TOML file that gives a key; the parser of the standard library keeps none."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

Key = str | int  # of a table, or the place in a list, from 0
# what may be open at the end of a line: a list, or a list in a list
_CLOSING = ("", "]", "]]", "]}", "]}]")


def line_of(text: str, keys: Sequence[Key]) -> int | None:
    """Return the number of the line, from 1, at which a valid TOML text gives a value; None if it does not.

    That is the first line up to which the text, with what it opens closed, is valid and has the value.
    """
    if not _has(text, keys):
        return None
    lines = text.splitlines()
    for count in range(1, len(lines)):
        begun = "\n".join(lines[:count])
        if any(_has(f"{begun}\n{closing}", keys) for closing in _CLOSING):
            return count
    return len(lines)


def _has(text: str, keys: Sequence[Key]) -> bool:
    try:
        value: Any = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return False
    for key in keys:
        try:
            value = value[key]
        except (KeyError, IndexError, TypeError):
            return False
    return True
