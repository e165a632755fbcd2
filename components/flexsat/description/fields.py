"""Read a table of a spacecraft's file as the fields of a frozen class: units, ranges and choices from their types."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from typing import Any, Literal, NoReturn, TypeVar, get_args, get_origin, get_type_hints

from ..quantities import Range
from .lines import Key
from .source import Source, meant
from .units import number_in

T = TypeVar("T")


def read_fields(
    source: Source,
    table: Any,
    keys: Sequence[Key],
    owner: type,
    without: Collection[str] = (),
    also: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the values of a table by the names of a class's fields, converted and within their ranges.

    Parameters
    ----------
    table, keys : what the file has at these keys
    without : fields that a file does not give
    also : keys that the table may have beside the fields; they are left to the caller
    """
    names = [item.name for item in fields(owner) if item.name not in without]
    source.check_keys(table, keys, [*names, *also])
    hints = get_type_hints(owner, include_extras=True)
    return {name: _value(source, table[name], [*keys, name], hints[name]) for name in names if name in table}


def make(source: Source, keys: Sequence[Key], owner: type[T], values: Mapping[str, Any]) -> T:
    """Return an object of a class; what it refuses is refused at the line of the field that it names, or the table."""
    try:
        return owner(**values)
    except ValueError as error:
        refuse_as(source, keys, owner, str(error))


def refuse_as(source: Source, keys: Sequence[Key], owner: type, message: str) -> NoReturn:
    """Refuse with the message of a class, which names a field as Class.field."""
    found = re.match(rf"{owner.__name__}\.(\w+):? (.*)", message, re.DOTALL)
    if found is None:
        source.refuse(keys, message)
    source.refuse([*keys, found[1]], found[2])


def _value(source: Source, value: Any, keys: Sequence[Key], hint: Any) -> Any:
    unit, limits = "1", Range()
    if hasattr(hint, "__metadata__"):
        unit, *given = hint.__metadata__
        limits, hint = given[0] if given else limits, hint.__origin__
    if get_origin(hint) is tuple:
        return _numbers(source, value, keys, hint, unit, limits)
    if get_origin(hint) is Literal:
        known = get_args(hint)
        if value not in known:
            source.refuse(keys, f"must be {' or '.join(known)}{meant(str(value), known)}", value)
        return value
    if hint is int:
        if isinstance(value, bool) or not isinstance(value, int):
            source.refuse(keys, "must be a whole number", value)
        return _within(source, value, value, keys, unit, limits)
    if hint in (bool, str):
        if not isinstance(value, hint):
            source.refuse(keys, "must be true or false" if hint is bool else "must be a text", value)
        return value
    return _within(source, _number(source, value, keys, unit), value, keys, unit, limits)


def _numbers(source: Source, value: Any, keys: Sequence[Key], hint: Any, unit: str, limits: Range) -> tuple[float, ...]:
    sizes = get_args(hint)
    count = None if sizes[-1] is Ellipsis else len(sizes)
    if not isinstance(value, list) or (count is not None and len(value) != count):
        source.refuse(keys, f"must be a list of {'' if count is None else f'{count} '}numbers in {unit}", value)
    bare = [item for item in value if not isinstance(item, str) and item != 0]
    if bare and len(bare) < len(value) and any(isinstance(item, str) for item in value):
        source.refuse(keys, f"{bare[0]!r} has no unit, and others have one; give each number its unit", value)
    return tuple(
        _within(source, _number(source, item, [*keys, i], unit), item, [*keys, i], unit, limits)
        for i, item in enumerate(value)
    )


def _number(source: Source, value: Any, keys: Sequence[Key], unit: str) -> float:
    try:
        return number_in(unit, value)
    except ValueError as error:
        source.refuse(keys, str(error), value)


def _within(source: Source, number: float, given: Any, keys: Sequence[Key], unit: str, limits: Range) -> Any:
    if number not in limits:
        source.refuse(keys, f"must be {limits}{'' if unit == '1' else f' {unit}'}", given)
    return number
