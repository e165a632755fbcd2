"""One entry of an adapter as arithmetic: our values to theirs, and exactly back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lockstep.adapter.rotation import (
    compose,
    conjugate,
    mrp_from_quaternion,
    quaternion_from_matrix,
    quaternion_from_mrp,
)
from lockstep.arrays import Array
from lockstep.system.adapter_file import DIRECTIONS, Entry, Matrix

Map = Callable[[Array], Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """`to_theirs` takes (n,) of ours to (m,) of theirs, `to_ours` back; n and m differ for attitudes only.

    `matrix`, (m, n), and `rest`, (m,), say the same as matrix @ ours + rest; None where that is not linear.
    """

    to_theirs: Map
    to_ours: Map
    matrix: Array | None = None
    rest: Array | None = None


def convert(entry: Entry, ours: int, theirs: int, gain: Sequence[float], bias: Sequence[float]) -> Conversion:
    """Return the arithmetic of an entry. `gain` and `bias` turn our unit into theirs, element by element of theirs."""
    there: list[Map] = []
    back: list[Map] = []
    matrix: Array | None = np.eye(ours)

    def then(forward: Map, backward: Map) -> None:
        there.append(forward)
        back.insert(0, backward)

    if entry.attitude is not None:
        attitude = _attitude(entry, ours)
        then(*attitude)
        linear = (ours, theirs) == (4, 4)  # an MRP is no linear function of anything
        matrix = np.column_stack([attitude[0](column) for column in np.eye(4)]) if linear else None
    if entry.frame is not None:
        frame = np.array(entry.frame)
        then(lambda vector: frame @ vector, lambda vector: frame.T @ vector)
        matrix = None if matrix is None else frame @ matrix
    if entry.order is not None:
        order = np.array(entry.order) - 1
        undo = np.argsort(order)
        then(lambda vector: vector[order], lambda vector: vector[undo])
        matrix = None if matrix is None else matrix[order]
    # scale * sign * (gain x + bias) + offset, as one product and one sum
    factor = np.broadcast_to(np.array(entry.scale) * np.array(entry.sign), theirs)
    total, rest = factor * np.array(gain), factor * np.array(bias) + np.array(entry.offset)
    if np.any(total != 1.0) or np.any(rest):
        then(lambda vector: total * vector + rest, lambda vector: (vector - rest) / total)
    return Conversion(
        to_theirs=_chain(there),
        to_ours=_chain(back),
        matrix=None if matrix is None else total[:, np.newaxis] * matrix,
        rest=None if matrix is None else np.broadcast_to(rest, theirs),
    )


def flag(entry: Entry) -> Conversion:
    """Return the arithmetic of Booleans of ours, 0 or 1: their numbers for true and false; all but `false` is true."""
    true, false = entry.true, entry.false
    return Conversion(
        to_theirs=lambda values: np.where(values != 0.0, true, false),
        to_ours=lambda values: (values != false).astype(float),
    )


def _chain(maps: Sequence[Map]) -> Map:
    if len(maps) == 1:
        return maps[0]

    def chain(values: Array) -> Array:
        for each in maps:
            values = each(values)
        return values

    return chain


def _attitude(entry: Entry, ours: int) -> tuple[Map, Map]:
    """Return the change of frames, direction, representation and order, and its inverse."""
    body, inertial = _quaternion(entry.body_frame), _quaternion(entry.inertial_frame)
    inverse = entry.rotation != DIRECTIONS[0]
    first, mrp = entry.scalar == "first", entry.attitude == "mrp"

    def to_theirs(values: Array) -> Array:
        q = values if ours == 4 else quaternion_from_mrp(values)
        if inertial is not None:
            q = compose(q, conjugate(inertial))
        if body is not None:
            q = compose(body, q)
        if inverse:
            q = conjugate(q)
        if mrp:
            return mrp_from_quaternion(q)
        return np.roll(q, 1) if first else q

    def to_ours(values: Array) -> Array:
        q = quaternion_from_mrp(values) if mrp else np.roll(values, -1) if first else values
        if inverse:
            q = conjugate(q)
        if body is not None:
            q = compose(conjugate(body), q)
        if inertial is not None:
            q = compose(q, inertial)
        return q if ours == 4 else mrp_from_quaternion(q)

    return to_theirs, to_ours


def _quaternion(matrix: Matrix | None) -> Array | None:
    return None if matrix is None else quaternion_from_matrix(np.array(matrix))
