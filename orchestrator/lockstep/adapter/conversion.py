"""One entry of an adapter as arithmetic: our values to theirs, and exactly back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lockstep.adapter.rotation import mrp_from_quaternion, quaternion_from_mrp, quaternion_matrix
from lockstep.arrays import Array
from lockstep.system.adapter_file import DIRECTIONS, Entry

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
        quaternions = quaternion_matrix(
            body_frame=entry.body_frame,
            inertial_frame=entry.inertial_frame,
            inverse=entry.rotation != DIRECTIONS[0],
            scalar_first=entry.scalar == "first",
        )
        then(*_attitude(quaternions, ours, theirs))
        matrix = quaternions if (ours, theirs) == (4, 4) else None  # an MRP is no linear function of anything
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


def _attitude(quaternions: Array, ours: int, theirs: int) -> tuple[Map, Map]:
    """Return the change of frames, direction, representation and order, and its inverse."""

    def to_theirs(values: Array) -> Array:
        q = quaternions @ (values if ours == 4 else quaternion_from_mrp(values))
        return q if theirs == 4 else mrp_from_quaternion(q)

    def to_ours(values: Array) -> Array:
        q = quaternions.T @ (values if theirs == 4 else quaternion_from_mrp(values))
        return q if ours == 4 else mrp_from_quaternion(q)

    return to_theirs, to_ours
