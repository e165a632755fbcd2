"""Decide which adapter entries can be written as SSP connections: each FMU variable from one interface port.

SSP has linear transformations of single numbers, and tables for Integers and Booleans. So a connection can rename,
permute, scale, shift, change signs and units, invert an attitude and number a flag. It cannot mix elements, as a
rotation does, nor hold a value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockstep.adapter.bind import Bound
from lockstep.adapter.conversion import convert
from lockstep.fmi.model_description import Variable
from lockstep.system.adapter_file import AdapterEntry
from lockstep.system.transformation import Table, family

_NEGLIGIBLE = 1e-15  # of a rotation's element: what rounding leaves where 0 belongs


class Inexpressible(Exception):
    """Report that SSP has no connection for an entry; the text gives the reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One element of an entry: the value at its source times factor plus offset, or looked up in the table.

    `port` is the position among the entry's interface ports, `variable` that among its FMU variables. The source is the
    port for inputs, the variable for outputs.
    """

    port: int
    variable: int
    factor: float = 1.0
    offset: float = 0.0
    table: Table | None = None


def pairs(bound: Bound) -> tuple[Pair, ...]:
    """Return the elements of an entry, or raise Inexpressible."""
    if bound.ports[0].type == "Boolean":
        return tuple(_flag(bound.entry, variable, k) for k, variable in enumerate(bound.variables))
    for port, variable in zip(bound.ports, bound.variables, strict=False):
        kinds = family(port.type), family(variable.type)
        if kinds[0] != kinds[1]:
            raise Inexpressible(f"{port.type} and {variable.type} are not connected in SSP: {variable.name}")
    if bound.conversion.matrix is None or bound.conversion.rest is None:
        raise Inexpressible("an MRP and a quaternion, or an MRP in other frames, are no linear functions of each other")
    return _linear(bound.entry, bound.conversion.matrix, bound.conversion.rest, bound.ports)


def quaternion_pairs(bound: Bound) -> tuple[Pair, ...]:
    """Return the elements of an attitude's entry if its port were a scalar-last quaternion, or raise Inexpressible."""
    if bound.entry.attitude != "quaternion":
        raise Inexpressible("the FMU's attitude is no quaternion")
    conversion = convert(bound.entry, 4, 4, [1.0] * 4, [0.0] * 4)
    assert conversion.matrix is not None
    assert conversion.rest is not None
    return _linear(bound.entry, conversion.matrix, conversion.rest, ())


def _linear(
    entry: AdapterEntry, matrix: NDArray[np.float64], rest: NDArray[np.float64], ports: Sequence[Variable]
) -> tuple[Pair, ...]:
    found = []
    for k, row in enumerate(matrix):
        (positions,) = np.nonzero(np.abs(row) > _NEGLIGIBLE)
        if len(positions) != 1:
            raise Inexpressible(
                f"a rotation that mixes axes: element {k + 1} of the variable is made of {len(positions)} of the port"
            )
        position = int(positions[0])
        factor, offset = float(row[position]), float(rest[k])
        if entry.direction == "output":
            factor, offset = 1.0 / factor, -offset / factor
        if ports and family(ports[position].type) == "Integer" and not (factor.is_integer() and offset.is_integer()):
            raise Inexpressible(f"{factor:g} * {ports[position].name} + {offset:g} of an Integer is no whole number")
        found.append(Pair(port=position, variable=k, factor=factor, offset=offset))
    return tuple(found)


def _flag(entry: AdapterEntry, variable: Variable, position: int) -> Pair:
    kind = family(variable.type)
    if kind == "Real":
        raise Inexpressible(f"a flag of a Real is no transformation of SSP: {variable.name}")
    true, false = entry.true, entry.false
    if kind == "Boolean":  # any number but 0 is true in the FMU
        answers = ((False, bool(false)), (True, bool(true)))
        if entry.direction == "output":
            answers = ((False, false != 0.0), (True, false != 1.0))
        unchanged = answers == ((False, False), (True, True))
        table = None if unchanged else Table(kind="Boolean", entries=answers)
        return Pair(port=position, variable=position, table=table)
    if not (true.is_integer() and false.is_integer()):
        raise Inexpressible(f"true = {true:g} and false = {false:g} are not Integers, as {variable.name} is")
    if entry.direction == "input":
        return Pair(
            port=position, variable=position, table=Table(kind="Integer", entries=((0, int(false)), (1, int(true))))
        )
    # a value without an entry stays as it is, and then every number but 0 is true
    entries = ((int(false), 0),) if false == 0.0 else ((int(false), 0), (0, 1))
    return Pair(port=position, variable=position, table=Table(kind="Integer", entries=entries))
