"""Compose the transformations between two ports: conversion of units, linear transformations, mapping tables.

A path is a sequence of hops; one hop is one connection of SSP, or one entry of a parameter mapping. A hop converts
units first, then applies at most one transformation. Connections through connectors of systems have several hops.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Literal

from lockstep.errors import InputError, RunError, compact, suggestion
from lockstep.system.units import Unit, checked_conversion

MapValue = str | int | bool
Function = Callable[[int], int]
_LIMITS = {32: (-(2**31), 2**31 - 1), 64: (-(2**63), 2**64 - 1)}  # by the bits in which Integers are exchanged


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A mapping transformation of SSP. Values without an entry are unchanged; Enumerations map item names."""

    kind: Literal["Boolean", "Integer", "Enumeration"]
    entries: tuple[tuple[MapValue, MapValue], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Hop:
    """One connection: the units are converted, then factor * value + offset or the table is applied.

    `type`, `unit` and `items` are those that the system file declares for the connector at its end; an undeclared unit
    is that of the value before the hop.
    """

    factor: float = 1.0
    offset: float = 0.0
    table: Table | None = None
    convert_units: bool = True
    type: str | None = None
    unit: Unit | None = None
    items: Mapping[str, int] = field(default_factory=dict)

    @property
    def converts_units_only(self) -> bool:
        """Whether it does nothing but convert units."""
        return self.table is None and (self.factor, self.offset) == (1.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """An end of a path: a variable's type (of FMI 2.0 or 3.0), unit, and items if it is an Enumeration."""

    type: str
    unit: Unit | None = None
    relative: bool = False  # a difference: the unit's offset does not apply
    items: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """All hops in one: gain * value + bias for Reals, `function` for what is exchanged as integers.

    Booleans are 0 and 1 for the function; None is the value itself.
    """

    gain: float = 1.0
    bias: float = 0.0
    function: Function | None = None


def family(type_name: str) -> str:
    """Return the family in which a type is exchanged: Real, Integer (Enumerations too), Boolean or String."""
    if type_name.startswith("Float"):
        return "Real"
    return "Integer" if type_name.startswith(("Int", "UInt", "Enumeration")) else type_name


def convert(source: End, target: End, hops: Sequence[Hop], what: str) -> Conversion:
    """Compose the hops between two variables.

    Integer and Boolean may be connected if a mapping transformation lies between them. 0 is false, every other number
    true; false is 0, true is 1.

    Raises
    ------
    InputError
        If types or units do not fit, or a transformation does not apply to the type. `what` names the path.
    """
    start, end = family(source.type), family(target.type)
    if start == end == "Real":
        gain, bias = _linear(source, target, hops, what)
        return Conversion(gain=gain, bias=bias)
    if start in ("Integer", "Boolean") and end in ("Integer", "Boolean"):
        return Conversion(function=_discrete(source, target, hops, what))
    if start != end:
        raise InputError(f"{what}: connects {source.type} to {target.type}; types must be equal")
    if not all(hop.converts_units_only for hop in hops):
        raise InputError(f"{what}: no transformation is defined for {source.type}; remove it")
    return Conversion()


def _linear(source: End, target: End, hops: Sequence[Hop], what: str) -> tuple[float, float]:
    gain, bias, unit = 1.0, 0.0, source.unit
    for number, hop in enumerate(hops):
        if hop.table is not None:
            raise InputError(f"{what}: {hop.table.kind}MappingTransformation is not for {source.type}")
        following = target.unit if number == len(hops) - 1 else hop.unit
        if hop.convert_units:
            rate, shift = checked_conversion(unit, following, source.relative and target.relative, what)
            gain, bias = rate * gain, rate * bias + shift
            following = following or unit
        gain, bias, unit = hop.factor * gain, hop.factor * bias + hop.offset, following
    if not (isfinite(gain) and isfinite(bias)):
        raise InputError(f"{what}: its factors and offsets come to {gain:g} and {bias:g}; they must be finite")
    return gain, bias


def _discrete(source: End, target: End, hops: Sequence[Hop], what: str) -> Function | None:
    functions: list[Function] = []
    kind, items = family(source.type), source.items
    wide = any(end.type in ("Int64", "UInt64", "UInt32") for end in (source, target))
    bits = 64 if wide else 32
    for number, hop in enumerate(hops):
        last = number == len(hops) - 1
        following = target.type if last else hop.type or kind
        leads_to = target.items if last and target.items else hop.items or items
        if hop.table is not None:
            functions += [_as("Boolean")] if hop.table.kind == "Boolean" else []
            functions.append(_lookup(hop.table, items, leads_to, what))
        elif not hop.converts_units_only:
            functions.append(_whole(hop, kind, following, what, bits))
        elif items and leads_to and dict(items) != dict(leads_to):
            raise InputError(
                f"{what}: connects Enumerations of {_items(items)} and of {_items(leads_to)}; "
                "an EnumerationMappingTransformation has to map them"
            )
        if family(following) != kind:
            if hop.table is None:
                raise InputError(
                    f"{what}: connects {kind} to {family(following)}; types must be equal, or a "
                    "BooleanMappingTransformation or IntegerMappingTransformation has to map them"
                )
            kind = family(following)
            functions.append(_as(kind))
        items = leads_to
    if not functions:
        return None

    def composed(value: int) -> int:
        for function in functions:
            value = function(value)
        return value

    return composed


def _items(items: Mapping[str, int]) -> str:
    return compact(f"{name} = {number}" for name, number in items.items())


def _as(kind: str) -> Function:
    return (lambda value: int(value != 0)) if kind == "Boolean" else int


def _lookup(table: Table, source: Mapping[str, int], target: Mapping[str, int], what: str) -> Function:
    found: dict[int, int] = {}
    for given, result in table.entries:
        key, value = _number(given, source, what), _number(result, target, what)
        if key in found:
            raise InputError(f"{what}: {table.kind}MappingTransformation maps {given} twice")
        found[key] = value
    return lambda value: found.get(value, value)


def _number(entry: MapValue, items: Mapping[str, int], what: str) -> int:
    if not isinstance(entry, str):
        return int(entry)
    if entry not in items:
        raise InputError(f"{what}: no enumeration item {entry}; there are {compact(items)}{suggestion(entry, items)}")
    return items[entry]


def _whole(hop: Hop, kind: str, following: str, what: str, bits: int) -> Function:
    if (kind, family(following)) != ("Integer", "Integer"):
        raise InputError(f"{what}: a linear transformation is not for {kind}; use a mapping transformation")
    factor, offset = hop.factor, hop.offset
    if not (factor.is_integer() and offset.is_integer()):
        numbers = f"factor {factor:g} and offset {offset:g}"
        raise InputError(f"{what}: {numbers} of an Integer must be whole numbers; Integers are exchanged exactly")
    gain, bias = int(factor), int(offset)
    lowest, highest = _LIMITS[bits]

    def linear(value: int) -> int:
        result = gain * value + bias
        if not lowest <= result <= highest:
            raise RunError(f"{what}: {gain} * {value} + {bias} does not fit into {bits} bits")
        return result

    return linear


def transferred(
    value: MapValue | float, unit: Unit | None, hops: Sequence[Hop], target: End, what: str
) -> tuple[MapValue | float, bool]:
    """Apply hops to one value of a parameter; return also whether it is then in the target's unit.

    Names of Enumeration items stay names.

    Raises
    ------
    InputError
        Like `convert`.
    """
    if not hops:
        return value, False
    if isinstance(value, str):
        for hop in hops:
            if hop.table is not None and hop.table.kind == "Enumeration":
                value = dict(hop.table.entries).get(value, value)
            elif not hop.converts_units_only:
                raise InputError(f"{what}: a transformation of the text {value!r} is not defined; remove it")
        return value, False
    if isinstance(value, float) or family(target.type) == "Real":
        if isinstance(value, bool):
            raise InputError(f"{what}: {value!r} is not of its type {target.type}")
        start = End(type="Real", unit=unit, relative=target.relative)
        end = End(type="Real", unit=target.unit, relative=target.relative)
        gain, bias = _linear(start, end, hops, what)
        return gain * value + bias, True
    start = End(type="Boolean" if isinstance(value, bool) else "Integer", items=target.items)
    conversion = convert(start, target, hops, what)
    result = int(value) if conversion.function is None else conversion.function(int(value))
    return (bool(result) if family(target.type) == "Boolean" else result), True
