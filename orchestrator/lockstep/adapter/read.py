"""Read an adapter file, or refuse it in one line that names file, entry, key, value and remedy."""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from lockstep.adapter.rotation import rotation_problem
from lockstep.data_text import parse_toml
from lockstep.errors import InputError, suggestion
from lockstep.fmi.safe_zip import open_file
from lockstep.system.adapter_file import (
    ATTITUDES,
    DIRECTIONS,
    SCALARS_AT,
    Adapter,
    AdapterEntry,
    Direction,
    Matrix,
    Number,
)
from lockstep.system.clock import Time, nanoseconds
from lockstep.system.unit_table import UNITS

_TOP = ("step", "kind", "ignore", "input", "output", "constants", "parameters", "substitutes")
_GENERAL = ("port", "variable", "index_base", "unit", "scale", "offset", "sign", "order", "frame", "true", "false",
            "hold")  # fmt: skip
_ATTITUDE = ("attitude", "scalar", "direction", "body_frame", "inertial_frame")
FILE_KEYS = {  # for the reference
    "(top of the file)": _TOP,
    "[[input]], [[output]]": _GENERAL,
    "of an attitude": _ATTITUDE,
}
_FORMER = {"ours": "port", "theirs": "variable"}  # keys of an entry in files of earlier versions
_LONGEST = 10_000_000_000  # [ns]; a step beyond is a slip of units


def read_adapter(path: Path) -> Adapter:
    """Read an adapter file, or raise InputError."""
    with open_file(path, None, "adapter") as stream:
        text = stream.read()
    content = parse_toml(text, str(path))
    where = path.name
    _known(content, _TOP, where)
    tables = {direction: _tables(content, direction, where) for direction in ("input", "output")}
    if any(key in table for group in tables.values() for table in group for key in _FORMER):
        print(f"{where}: the keys ours and theirs are now named port and variable; rename them", file=sys.stderr)
    entries = [
        _entry(where, direction, number, _renamed(table, f"{where}: {direction} {number}"))
        for direction, group in tables.items()
        for number, table in enumerate(group, start=1)
    ]
    return Adapter(
        path=path.absolute(),
        sha256=hashlib.sha256(text).hexdigest(),
        step=_step(content, where),
        kind=_kind(content, where),
        entries=tuple(entries),
        constants=_values(content, "constants", where),
        parameters=_values(content, "parameters", where),
        substitutes=_values(content, "substitutes", where),
        ignore=_texts(content.get("ignore", []), f"{where}: ignore"),
    )


def _step(content: Mapping[str, Any], where: str) -> Time | None:
    if "step" not in content:
        return None
    value = content["step"]
    fraction = isinstance(value, str) and "/" in value
    if isinstance(value, bool) or not (fraction or isinstance(value, int | float)):
        raise InputError(f"{where}: step = {value!r} must be a number of seconds, for example 0.01")
    step = nanoseconds(value, f"{where}: step")
    if not 0 < step <= _LONGEST:
        raise InputError(f"{where}: step = {value} must be in (0, 10] s")
    return step


def _kind(content: Mapping[str, Any], where: str) -> Literal["sampled", "continuous"] | None:
    match content.get("kind"):
        case None:
            return None
        case "sampled":
            return "sampled"
        case "continuous":
            return "continuous"
    raise InputError(f"{where}: kind = {content['kind']!r} must be sampled or continuous")


def _tables(content: Mapping[str, Any], key: str, where: str) -> list[Mapping[str, Any]]:
    tables = content.get(key, [])
    if not (isinstance(tables, list) and all(isinstance(table, dict) for table in tables)):
        raise InputError(f"{where}: {key} = {tables!r} must be tables; write [[{key}]]")
    return tables


def _renamed(table: Mapping[str, Any], location: str) -> Mapping[str, Any]:
    """Return an entry with the present names of its keys, or refuse one that has both."""
    for old, new in _FORMER.items():
        if old in table and new in table:
            raise InputError(f"{location}: has {old} and {new}, which are one key; remove {old}")
    return {_FORMER.get(key, key): value for key, value in table.items()}


def _entry(where: str, direction: str, number: int, table: Mapping[str, Any]) -> AdapterEntry:
    location = f"{where}: {direction} {number}"
    for key in ("variable", "port"):
        if key not in table:
            raise InputError(f"{location}: {key} is missing; every [[{direction}]] needs port and variable")
    variables = _names(table["variable"], f"{location}: variable")
    location = f"{location} ({variables[0]})"
    _known(table, (*_GENERAL, *_ATTITUDE), location)
    given = [key for key in _ATTITUDE[1:] if key in table]
    if "attitude" not in table and given:
        raise InputError(f'{location}: {given[0]} = {table[given[0]]!r} needs attitude = "quaternion" or "mrp" as well')
    if table.get("attitude") == "mrp" and "scalar" in table:
        raise InputError(f"{location}: scalar = {table['scalar']!r}: an MRP has no scalar; remove it")
    if "frame" in table and "attitude" in table:
        raise InputError(f"{location}: frame is for vectors; an attitude has body_frame and inertial_frame")
    unit = table.get("unit")
    if unit is not None and "attitude" in table:
        raise InputError(f"{location}: unit = {unit!r}: an attitude has no unit; remove it")
    if unit is not None and unit not in UNITS:
        raise InputError(f"{location}: unit = {unit!r} is unknown; there are {', '.join(UNITS)}")
    true, false = (_numbers(table.get(key, default), f"{location}: {key}")[0] for key, default in _FLAGS)
    if true == false:
        raise InputError(f"{location}: true = {true:g} and false = {false:g} must differ")
    scale = _numbers(table.get("scale", 1.0), f"{location}: scale")
    if 0.0 in scale:
        raise InputError(f"{location}: scale = {table['scale']!r} must not be 0: it has no inverse")
    sign = _numbers(table.get("sign", 1), f"{location}: sign")
    if not set(sign) <= {1.0, -1.0}:
        raise InputError(f"{location}: sign = {table['sign']!r} must be 1 or -1; for other factors there is scale")
    toward: Direction = "input" if direction == "input" else "output"
    hold = table.get("hold")
    if hold is not None and (toward == "output" or not isinstance(hold, str)):
        raise InputError(f"{location}: hold = {hold!r} must name a Boolean interface port, and is for inputs only")
    return AdapterEntry(
        location=location,
        direction=toward,
        ports=_names(table["port"], f"{location}: port"),
        variables=variables,
        index_base=_whole(table.get("index_base", 1), f"{location}: index_base"),
        unit=unit,
        scale=scale,
        offset=_numbers(table.get("offset", 0.0), f"{location}: offset"),
        sign=sign,
        order=_order(table, location),
        frame=_matrix(table, "frame", location),
        attitude=_choice(table, "attitude", ATTITUDES, None, location),
        scalar=_choice(table, "scalar", SCALARS_AT, "last", location) or "last",
        rotation=_choice(table, "direction", DIRECTIONS, DIRECTIONS[0], location) or DIRECTIONS[0],
        body_frame=_matrix(table, "body_frame", location),
        inertial_frame=_matrix(table, "inertial_frame", location),
        true=true,
        false=false,
        hold=hold,
    )


_FLAGS = (("true", 1.0), ("false", 0.0))


def _known(table: Mapping[str, Any], keys: Sequence[str], location: str) -> None:
    for key in table:
        if key not in keys:
            raise InputError(
                f"{location}: {key} = {table[key]!r}: no such key; there are {', '.join(keys)}{suggestion(key, keys)}"
            )


def _names(value: object, what: str) -> tuple[str, ...]:
    names = _texts([value] if isinstance(value, str) else value, what)
    if not names or not all(names):
        raise InputError(f"{what} = {value!r} must be a name or a list of names")
    if any(name.count("*") > 1 for name in names) or (len(names) > 1 and any("*" in name for name in names)):
        raise InputError(f"{what} = {value!r}: one star at most, and not in a list")
    return names


def _texts(value: object, what: str) -> tuple[str, ...]:
    if not (isinstance(value, list) and all(isinstance(text, str) for text in value)):
        raise InputError(f"{what} = {value!r} must be a list of texts")
    return tuple(value)


def _numbers(value: object, what: str) -> tuple[float, ...]:
    values = value if isinstance(value, list) else [value]
    numbers = [float(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v)]
    if not values or len(numbers) < len(values):
        raise InputError(f"{what} = {value!r} must be a finite number, or a list with one for each element")
    return tuple(numbers)


def _whole(value: object, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise InputError(f"{what} = {value!r} must be a whole number from 0")
    return value


def _order(table: Mapping[str, Any], location: str) -> tuple[int, ...] | None:
    order = table.get("order")
    if order is None:
        return None
    whole = isinstance(order, list) and all(isinstance(k, int) and not isinstance(k, bool) for k in order)
    if not whole or sorted(order) != list(range(1, len(order) + 1)):
        raise InputError(f"{location}: order = {order!r} must hold each of 1 to the number of elements once")
    return tuple(order)


def _choice(
    table: Mapping[str, Any], key: str, accepted: Iterable[str], default: str | None, location: str
) -> str | None:
    value: str | None = table.get(key, default)
    if value is not None and value not in accepted:
        raise InputError(f"{location}: {key} = {value!r} must be {' or '.join(accepted)}")
    return value


def _matrix(table: Mapping[str, Any], key: str, location: str) -> Matrix | None:
    rows = table.get(key)
    if rows is None:
        return None
    shape = isinstance(rows, list) and [len(row) if isinstance(row, list) else 0 for row in rows] == [3, 3, 3]
    if not shape:
        raise InputError(f"{location}: {key} = {rows!r} must be three rows of three numbers")
    matrix = tuple(_numbers(row, f"{location}: {key}") for row in rows)
    problem = rotation_problem(matrix)
    if problem:
        raise InputError(f"{location}: {key} = {rows!r} is no rotation: {problem}")
    return matrix


def _values(content: Mapping[str, Any], key: str, where: str) -> dict[str, Number]:
    table = content.get(key, {})
    if not isinstance(table, dict):
        raise InputError(f"{where}: {key} = {table!r} must be a table; write [{key}]")
    values: dict[str, Number] = {}
    for name, value in table.items():
        items = value if isinstance(value, list) else [value]
        if not all(isinstance(item, float | int | bool | str) for item in items):
            raise InputError(f"{where}: {key}: {name} = {value!r} must be a value or a list; quote names with dots")
        named = (
            {f"{name}[{k}]": item for k, item in enumerate(value, start=1)}
            if isinstance(value, list)
            else {name: value}
        )
        if twice := values.keys() & named:
            raise InputError(f"{where}: {key}: {min(twice)} has two values; remove one of them")
        values |= named
    return values
