"""What of an adapter's entry connections of SSP can do: for each element of theirs one of ours, and a transformation.

SSP has linear transformations of single numbers, and tables of Integers and Booleans. So it can rename, permute, scale,
shift, change signs and units, conjugate a quaternion and number a flag. It cannot mix elements, as a rotation does, nor
hold a value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockstep.adapter.bind import Bound
from lockstep.adapter.conversion import convert
from lockstep.fmi.model_description import Variable
from lockstep.system.adapter_file import Entry
from lockstep.system.transformation import Table, family

_NEGLIGIBLE = 1e-15  # of a rotation's element: what rounding leaves where 0 belongs


class Inexpressible(Exception):
    """SSP cannot say it; the text says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One element: theirs = factor * ours + offset, or what the table makes of ours; for outputs the other way round.

    `ours` is the place among the entry's variables of ours, `theirs` that among those of theirs.
    """

    ours: int
    theirs: int
    factor: float = 1.0
    offset: float = 0.0
    table: Table | None = None


def pairs(bound: Bound) -> tuple[Pair, ...]:
    """Return the elements of an entry, or raise Inexpressible."""
    if bound.ours[0].type == "Boolean":
        return tuple(_flag(bound.entry, their, k) for k, their in enumerate(bound.theirs))
    for our, their in zip(bound.ours, bound.theirs, strict=False):
        kinds = family(our.type), family(their.type)
        if kinds[0] != kinds[1]:
            raise Inexpressible(f"{our.type} and {their.type} are not connected in SSP: {their.name}")
    if bound.conversion.matrix is None or bound.conversion.rest is None:
        raise Inexpressible("an MRP and a quaternion, or an MRP in other frames, are no linear functions of each other")
    return _linear(bound.entry, bound.conversion.matrix, bound.conversion.rest, bound.ours)


def quaternion_pairs(bound: Bound) -> tuple[Pair, ...]:
    """Return the elements of an attitude's entry for four variables of ours, a scalar-last quaternion, in its place."""
    if bound.entry.attitude != "quaternion":
        raise Inexpressible("theirs is no quaternion")
    conversion = convert(bound.entry, 4, 4, [1.0] * 4, [0.0] * 4)
    assert conversion.matrix is not None
    assert conversion.rest is not None
    return _linear(bound.entry, conversion.matrix, conversion.rest, ())


def _linear(
    entry: Entry, matrix: NDArray[np.float64], rest: NDArray[np.float64], ours: Sequence[Variable]
) -> tuple[Pair, ...]:
    found = []
    for k, row in enumerate(matrix):
        (places,) = np.nonzero(np.abs(row) > _NEGLIGIBLE)
        if len(places) != 1:
            raise Inexpressible(
                f"a rotation that mixes axes: element {k + 1} of theirs is made of {len(places)} of ours"
            )
        place = int(places[0])
        factor, offset = float(row[place]), float(rest[k])
        if entry.direction == "output":
            factor, offset = 1.0 / factor, -offset / factor
        if ours and family(ours[place].type) == "Integer" and not (factor.is_integer() and offset.is_integer()):
            raise Inexpressible(f"{factor:g} * {ours[place].name} + {offset:g} of an Integer is no whole number")
        found.append(Pair(ours=place, theirs=k, factor=factor, offset=offset))
    return tuple(found)


def _flag(entry: Entry, their: Variable, place: int) -> Pair:
    kind = family(their.type)
    if kind == "Real":
        raise Inexpressible(f"a flag of a Real is no transformation of SSP: {their.name}")
    true, false = entry.true, entry.false
    if kind == "Boolean":  # any number but 0 is true in their FMU
        answers = ((False, bool(false)), (True, bool(true)))
        if entry.direction == "output":
            answers = ((False, false != 0.0), (True, false != 1.0))
        plain = answers == ((False, False), (True, True))
        table = None if plain else Table(kind="Boolean", entries=answers)
        return Pair(ours=place, theirs=place, table=table)
    if not (true.is_integer() and false.is_integer()):
        raise Inexpressible(f"true = {true:g} and false = {false:g} are not Integers, as {their.name} is")
    if entry.direction == "input":
        return Pair(ours=place, theirs=place, table=Table(kind="Integer", entries=((0, int(false)), (1, int(true)))))
    # what has no entry stays as it is, and then every number but 0 is true
    entries = ((int(false), 0),) if false == 0.0 else ((int(false), 0), (0, 1))
    return Pair(ours=place, theirs=place, table=Table(kind="Integer", entries=entries))
