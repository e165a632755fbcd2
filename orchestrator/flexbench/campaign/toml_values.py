"""Values of tables of a campaign file, or one line that names table, key, value and remedy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lockstep.errors import InputError, suggestion


def refuse_unknown(table: Mapping[str, Any], known: Sequence[str], where: str) -> None:
    """Raise InputError for a key that a table does not have."""
    for key in table:
        if key not in known:
            raise InputError(f"{where}: {key}: no such key; there are {', '.join(known)}{suggestion(key, known)}")


def one_of(table: Mapping[str, Any], key: str, known: Sequence[str], where: str, default: str | None = None) -> str:
    """Return a text that is one of those known."""
    value = table.get(key, default)
    if not isinstance(value, str) or value not in known:
        hint = suggestion(value, known) if isinstance(value, str) else ""
        raise InputError(f"{where}: {key} = {value!r}: must be one of {', '.join(known)}{hint}")
    return value


def text_of(table: Mapping[str, Any], key: str, where: str, default: str) -> str:
    """Return a text."""
    value = table.get(key, default)
    if not isinstance(value, str):
        raise InputError(f"{where}: {key} = {value!r}: must be a text")
    return value


def whole_of(table: Mapping[str, Any], key: str, where: str, default: int) -> int:
    """Return a whole number that is not negative."""
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise InputError(f"{where}: {key} = {value!r}: must be a whole number, 0 or more")
    return value


def number_of(table: Mapping[str, Any], key: str, where: str, default: float | None = None) -> float | None:
    """Return a finite number, or the default."""
    value = table.get(key, default)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{where}: {key} = {value!r}: must be a number")
    return float(value)


def flag_of(table: Mapping[str, Any], key: str, where: str, default: bool) -> bool:
    """Return a flag."""
    value = table.get(key, default)
    if not isinstance(value, bool):
        raise InputError(f"{where}: {key} = {value!r}: must be true or false")
    return value


def texts_of(table: Mapping[str, Any], key: str, where: str) -> tuple[str, ...]:
    """Return a list of texts, which may be written as one text."""
    value = table.get(key, [])
    texts = [value] if isinstance(value, str) else value
    if not isinstance(texts, list) or not all(isinstance(text, str) and text for text in texts):
        raise InputError(f"{where}: {key} = {value!r}: must be a text, or a list of texts")
    return tuple(texts)
