"""Compute the values of one adapter entry: from interface ports to FMU variables, and exactly back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lockstep.adapter.rotation import mrp_from_quaternion, quaternion_from_mrp, quaternion_matrix
from lockstep.arrays import Array
from lockstep.system.adapter_file import DIRECTIONS, AdapterEntry

Map = Callable[[Array], Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class EntryConversion:
    """Map n port values to m FMU values by `to_fmu`, and back by `to_port`; n and m differ for attitudes only.

    The FMU's values are also matrix @ ports + rest, with shapes (m, n) and (m,); both are None if it is not linear.
    """

    to_fmu: Map
    to_port: Map
    matrix: Array | None = None
    rest: Array | None = None


def convert(
    entry: AdapterEntry, ports: int, variables: int, gain: Sequence[float], bias: Sequence[float]
) -> EntryConversion:
    """Return the arithmetic of an entry between numbers of ports and of FMU variables.

    `gain` and `bias`, one for each FMU variable, take the unit of the port to that of the variable.
    """
    there: list[Map] = []
    back: list[Map] = []
    matrix: Array | None = np.eye(ports)

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
        then(*_attitude(quaternions, ports, variables))
        matrix = _linear(quaternions, ports, variables)
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
    factor = np.broadcast_to(np.array(entry.scale) * np.array(entry.sign), variables)
    total, rest = factor * np.array(gain), factor * np.array(bias) + np.array(entry.offset)
    if np.any(total != 1.0) or np.any(rest):
        then(lambda vector: total * vector + rest, lambda vector: (vector - rest) / total)
    return EntryConversion(
        to_fmu=_chain(there),
        to_port=_chain(back),
        matrix=None if matrix is None else total[:, np.newaxis] * matrix,
        rest=None if matrix is None else np.broadcast_to(rest, variables),
    )


def flag(entry: AdapterEntry) -> EntryConversion:
    """Return the arithmetic of Boolean ports, 0 or 1: the FMU's numbers for true and false; all but `false` is true."""
    true, false = entry.true, entry.false
    return EntryConversion(
        to_fmu=lambda values: np.where(values != 0.0, true, false),
        to_port=lambda values: (values != false).astype(float),
    )


def _chain(maps: Sequence[Map]) -> Map:
    if len(maps) == 1:
        return maps[0]

    def chain(values: Array) -> Array:
        for each in maps:
            values = each(values)
        return values

    return chain


def _linear(quaternions: Array, ports: int, variables: int) -> Array | None:
    """Return the matrix between attitudes of two conventions; None where they are no linear functions of each other.

    A quaternion is of a quaternion. An MRP is of an MRP where the scalar stays: the same frames, the other direction,
    or one rotation of both frames. MRPs of the short rotation, as all ports have them, stay that.
    """
    if (ports, variables) == (4, 4):
        return quaternions
    sign = quaternions[3, 3]  # q and -q are one rotation
    if (ports, variables) != (3, 3) or not np.allclose(np.abs(quaternions[3]), [0.0, 0.0, 0.0, 1.0], atol=1e-15):
        return None
    return np.asarray(sign * quaternions[:3, :3])


def _attitude(quaternions: Array, ports: int, variables: int) -> tuple[Map, Map]:
    """Return the change of frames, direction, representation and order, and its inverse."""

    def to_fmu(values: Array) -> Array:
        q = quaternions @ (values if ports == 4 else quaternion_from_mrp(values))
        return q if variables == 4 else mrp_from_quaternion(q)

    def to_port(values: Array) -> Array:
        q = quaternions.T @ (values if variables == 4 else quaternion_from_mrp(values))
        return q if ports == 4 else mrp_from_quaternion(q)

    return to_fmu, to_port
