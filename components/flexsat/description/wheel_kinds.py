"""Read the wheels' kinds of a spacecraft's file: [wheel], the usual one, and tables [wheel_kinds.NAME]."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..parameters import Harmonic, Wheel
from .fields import make, read_fields
from .lines import Key
from .source import Source

TABLE = "wheel_kinds"
HARMONICS = "harmonics"
FACTOR = "factor"


def read_wheel(source: Source, table: Any, keys: Sequence[Key] = ("wheel",)) -> Wheel:
    """Return the wheel of a table; raise SpacecraftFileError if it is refused."""
    values = read_fields(source, table, keys, Wheel, without=(HARMONICS,), also=[HARMONICS, FACTOR])
    if HARMONICS in table:
        values[HARMONICS] = _harmonics(source, table[HARMONICS], [*keys, HARMONICS])
    wheel = make(source, keys, Wheel, values)
    factor = table.get(FACTOR, 1.0)
    if isinstance(factor, bool) or not isinstance(factor, (int, float)) or not 0.0 < factor < math.inf:
        source.refuse([*keys, FACTOR], "must be a number > 0: it multiplies inertia, torques, imbalance and broadband"
                      " jitter of the wheel", factor)  # fmt: skip
    try:
        return wheel if factor == 1.0 else wheel.scaled(float(factor))
    except ValueError as error:
        source.refuse([*keys, FACTOR], str(error), factor)


def read_kinds(source: Source, tables: Any) -> Mapping[str, Wheel]:
    """Return the wheels of the tables [wheel_kinds.NAME] by name; raise SpacecraftFileError if one is refused."""
    if not isinstance(tables, dict):
        source.refuse([TABLE], f"must have a table for each kind, such as [{TABLE}.large]", tables)
    return {name: read_wheel(source, table, [TABLE, name]) for name, table in tables.items()}


def _harmonics(source: Source, entries: Any, keys: Sequence[Key]) -> tuple[Harmonic, ...]:
    if not isinstance(entries, list):
        source.refuse(keys, 'must be a list such as [{ order = 2, force = "1e-8 N/rpm2" }]', entries)
    found = []
    for i, entry in enumerate(entries):
        values = read_fields(source, entry, [*keys, i], Harmonic)
        if "order" not in values:
            source.refuse([*keys, i], "order is missing; write for example order = 2, for twice the wheel's angle")
        found.append(make(source, [*keys, i], Harmonic, values))
    return tuple(found)
