"""Put structures together on one rigid bus: each clamped at its interface, at any angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Index
from ..fixed_order import product
from .structure import Structure


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placed:
    """A structure at its place on the bus."""

    name: str  # prefix of its nodes' names
    structure: Structure
    at: Array  # (3,) interface from the origin of the body axes [m]
    body_from_own: Array  # (3, 3) rotation matrix


def rotation_about(vector: Array) -> Array:
    """Return the matrix of a rotation by the length of a vector [rad] about its direction, (3, 3)."""
    # in extended precision: the last digit of a double's sine and cosine depends on the processor
    exact = np.asarray(vector, dtype=np.longdouble)
    angle = np.sqrt(np.sum(exact * exact))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = exact / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]], dtype=np.longdouble)
    squared = np.outer(exact / angle, exact / angle) - np.eye(3)
    matrix = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * squared
    rounded = np.asarray(matrix, dtype=np.float64)
    near = np.rint(rounded)
    return np.where(np.abs(rounded - near) < np.finfo(np.float64).eps, near, rounded) + 0.0  # right angles are exact


def turned(placed: Placed) -> Structure:
    """Return a structure in body axes from the body's origin; its modes and their frequencies are the same."""
    own, at, turn = placed.structure, placed.at, placed.body_from_own
    names = tuple(f"{placed.name}.{name}" for name in own.names)
    if not at.any() and np.array_equal(turn, np.eye(3)):
        return replace(own, names=names)
    nodes, modes = len(own.position), own.mode_count
    translation, moment = product(turn, own.translation), product(turn, own.first_moment)
    crossed = np.cross(at, translation, axis=0) if modes else translation
    own_inertia = product(product(turn, own.inertia), np.ascontiguousarray(turn.T))
    mixed = np.outer(at, moment)
    shift = 2.0 * (at @ moment) * np.eye(3) - mixed - mixed.T
    shift += own.total_mass * ((at @ at) * np.eye(3) - np.outer(at, at))

    def along(values: Array) -> Array:
        """Return the vectors of nodes and modes, (n, 3, m), in body axes."""
        flat = values.transpose(1, 0, 2).reshape(3, nodes * modes)
        return product(turn, flat).reshape(3, nodes, modes).transpose(1, 0, 2)

    return Structure(
        frequency=own.frequency,
        damping=own.damping,
        translation=translation,
        rotation=product(turn, own.rotation) + crossed,
        total_mass=own.total_mass,
        first_moment=moment + own.total_mass * at,
        inertia=own_inertia + shift,
        position=product(own.position, np.ascontiguousarray(turn.T)) + at,
        deflection=along(own.deflection),
        slope=along(own.slope),
        names=names,
        edges=own.edges,
    )


def parts_of_modes(parts: Sequence[Structure], count: int) -> Index:
    """Return which of the parts each of the modes of `combined` is one of, (m,), from 0."""
    owners = np.concatenate([np.full(part.mode_count, k) for k, part in enumerate(parts)])
    return np.asarray(owners[_lowest(parts, count)])


def _lowest(parts: Sequence[Structure], count: int) -> Index:
    """Return the lowest modes of all parts, by their places one part after the other."""
    frequency = np.concatenate([part.frequency for part in parts])
    return np.asarray(np.argsort(frequency, kind="stable")[:count])


def combined(parts: Sequence[Structure], count: int) -> Structure:
    """Return structures on one bus, in the same axes, as one with the lowest `count` modes of all of them.

    The bus is rigid, so that clamped there each vibrates by itself. Nodes stand in the order of the parts.
    """
    if len(parts) == 1 and parts[0].mode_count <= count:
        return parts[0]
    frequency = np.concatenate([part.frequency for part in parts])
    kept = _lowest(parts, count)
    starts = np.cumsum([0, *(part.mode_count for part in parts)])
    first_nodes = np.cumsum([0, *(len(part.position) for part in parts)])

    def own_modes(name: str) -> Array:
        """Return values of nodes, (n, 3, m): zero in the modes of the others."""
        blocks = np.zeros((first_nodes[-1], 3, len(frequency)))
        for k, part in enumerate(parts):
            rows, columns = slice(*first_nodes[k : k + 2]), slice(*starts[k : k + 2])
            blocks[rows, :, columns] = getattr(part, name)
        return blocks[:, :, kept]

    named = any(part.names for part in parts)
    names = [part.names or ("",) * len(part.position) for part in parts]
    return Structure(
        frequency=frequency[kept],
        damping=np.concatenate([part.damping for part in parts])[kept],
        translation=np.hstack([part.translation for part in parts])[:, kept],
        rotation=np.hstack([part.rotation for part in parts])[:, kept],
        total_mass=sum(part.total_mass for part in parts),
        first_moment=np.sum([part.first_moment for part in parts], axis=0),
        inertia=np.sum([part.inertia for part in parts], axis=0),
        position=np.concatenate([part.position for part in parts]),
        deflection=own_modes("deflection"),
        slope=own_modes("slope"),
        names=tuple(name for part in names for name in part) if named else (),
        edges=np.concatenate([part.edges + first_nodes[k] for k, part in enumerate(parts)]),
        mesh=parts[0].mesh,
    )
