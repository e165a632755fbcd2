"""Keep a body axis outside cones about inertial directions: check a turn, and find a chain of turns round them.

A turn about an axis fixed in the body is checked in closed form. Where the commanded one would enter a cone, the
quickest chain of up to LEGS turns is chosen, at rest between two of them, through attitudes whose body axis stands on
rings round the cones. One cone can always be passed: turn about its direction, then along the meridian, then about the
body axis. A slew coasts most of the time, so that a stop costs little. numpy alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only

LEGS = 5  # most turns in a chain
CONES = ("first", "second")
AZIMUTHS = 16  # attitudes on a ring
RINGS = (1.03, 1.2)  # tangent of a ring's angle over that of the cone: turns between neighbours on it stay outside
EDGE = 1e-12  # of a cosine: rounding at the edge of a cone


@dataclass(frozen=True, slots=True, kw_only=True)
class KeepOut:
    """Cones that a body axis may not enter. A cone of half-angle 0 is none."""

    axis: Array  # (3,) in the body, unit vector
    directions: Array  # (2, 3) inertial, unit vectors
    half_angles: Array  # (2,) [rad]

    def __post_init__(self) -> None:
        make_read_only(self)

    @property
    def active(self) -> bool:
        """Whether there is a cone."""
        return bool(self.half_angles.any())


def keep_out(axis: Array, directions: Array, half_angles: Array) -> KeepOut:
    """Return the cones, with unit vectors.

    Raises
    ------
    ValueError
        For a half-angle outside [0, pi), or a cone without a direction.
    """
    for name, direction, half_angle in zip(CONES, directions, half_angles, strict=True):
        if not 0.0 <= half_angle < math.pi:
            raise ValueError(f"keep_out.{name}.half_angle must be in [0, pi), got {float(half_angle)!r}")
        if half_angle > 0.0 and not np.any(direction):
            raise ValueError(f"keep_out.{name}.direction must not be zero where its half_angle is > 0")
    if not np.any(axis):
        raise ValueError("keep_out.axis must not be zero")
    return KeepOut(axis=_unit(axis), directions=_unit(directions), half_angles=np.array(half_angles, np.float64))


def plan_legs(cones: KeepOut, attitude: Array, rotation: Array, duration: Callable[[Array], Array]) -> Array:
    """Return the rotation vectors (LEGS, 3) [rad] to turn by one after the other; zeros where there are fewer.

    Parameters
    ----------
    cones : to stay outside of
    attitude : (4,) where the slew begins, body from inertial
    rotation : (3,) [rad] to turn by
    duration : how long turns by rotation vectors (m, 3) last (m,) [s]

    Raises
    ------
    ValueError
        If the slew begins or ends within a cone, or no chain leads round the cones.
    """
    legs = np.zeros((LEGS, 3))
    legs[0] = rotation
    if not cones.active or not np.any(rotation):
        return legs
    start, turn = np.asarray(attitude).reshape(1, 4), np.asarray(rotation).reshape(1, 3)
    end = _turned(start, turn)
    for word, at in (("begins", start), ("ends", end)):
        _refuse_inside(cones, word, at)
    if is_clear(cones, start, turn)[0]:
        return legs
    nodes = np.vstack([start, end, _waypoints(cones, start, end)])
    count = len(nodes)
    turns = _relative(nodes[np.newaxis], nodes[:, np.newaxis]).reshape(-1, 3)  # from each to each
    cost = np.where(is_clear(cones, np.repeat(nodes, count, axis=0), turns), duration(turns), np.inf)
    path = _quickest(cost.reshape(count, count))
    if not path:
        raise ValueError(
            f"keep_out: no chain of {LEGS} turns leads round the cones; command intermediate attitudes, or set"
            " keep_out.first.half_angle or keep_out.second.half_angle lower"
        )
    legs[:] = 0.0
    legs[: len(path) - 1] = turns.reshape(count, count, 3)[path[:-1], path[1:]]
    return legs


def is_clear(cones: KeepOut, attitudes: Array, rotations: Array) -> Array:
    """Return whether turns from attitudes (m, 4) by rotation vectors (m, 3) [rad] stay outside all cones, (m,)."""
    angle = np.linalg.norm(rotations, axis=1)
    about = rotations / np.where(angle > 0.0, angle, 1.0)[:, np.newaxis]
    along = about @ cones.axis
    clear = np.ones(len(angle), bool)
    for direction, half_angle in zip(cones.directions, cones.half_angles, strict=True):
        if half_angle > 0.0:
            # cosine of the angle to the direction after turning by x: c0 + c1 cos x + c2 sin x
            seen = _in_body(attitudes, direction)
            c0 = along * np.einsum("ij,ij->i", about, seen)
            c1 = seen @ cones.axis - c0
            c2 = -(np.cross(about, seen) @ cones.axis)
            nearest = np.mod(np.arctan2(c2, c1), 2.0 * math.pi)
            ends = np.maximum(c1, c1 * np.cos(angle) + c2 * np.sin(angle))
            most = c0 + np.where(nearest < angle, np.hypot(c1, c2), ends)
            clear &= most <= math.cos(half_angle) + EDGE
    return clear


def _refuse_inside(cones: KeepOut, word: str, attitude: Array) -> None:
    for name, direction, half_angle in zip(CONES, cones.directions, cones.half_angles, strict=True):
        cosine = float(_in_body(attitude, direction)[0] @ cones.axis)
        if half_angle > 0.0 and cosine > math.cos(half_angle) + EDGE:
            raise ValueError(
                f"command.rotation: the slew {word} with keep_out.axis at"
                f" {math.degrees(math.acos(min(1.0, cosine))):.6g} deg from keep_out.{name}.direction, within"
                f" keep_out.{name}.half_angle = {math.degrees(half_angle):.6g} deg; command another attitude, or set"
                " that angle lower"
            )


def _waypoints(cones: KeepOut, start: Array, end: Array) -> Array:
    """Return attitudes (m, 4) through which a chain may lead: swung from the start, and from the end."""
    from_start, to_end = _pointing(cones, start)[0], _pointing(cones, end)[0]
    found = []
    azimuth = 2.0 * math.pi * np.arange(AZIMUTHS) / AZIMUTHS
    for direction, half_angle in zip(cones.directions, cones.half_angles, strict=True):
        if half_angle == 0.0:
            continue
        # azimuths count from the start's, so that the result turns with the scene
        east = _across(direction, from_start)
        north = np.cross(east, direction)
        circle = np.cos(azimuth)[:, np.newaxis] * north + np.sin(azimuth)[:, np.newaxis] * east
        for factor in RINGS:
            wider = factor if half_angle < 0.5 * math.pi else 1.0 / factor
            ring = math.atan2(wider * math.sin(half_angle), math.cos(half_angle))
            pointing = math.cos(ring) * direction + math.sin(ring) * circle
            found += [_swung(cones, start, pointing), _swung(cones, end, pointing)]
        # about the direction to the meridian of the end, and along it
        turn = math.atan2(float(to_end @ east), float(to_end @ north))
        beside = _turned(start, -turn * _in_body(start, direction))
        found += [beside, _swung(cones, beside, to_end[np.newaxis])]
    return np.vstack(found)


def _quickest(cost: Array) -> list[int]:
    """Return the nodes of the quickest path from node 0 to node 1 in at most LEGS steps; none if there is none."""
    total, before = cost[0], np.zeros((LEGS, len(cost)), np.intp)
    for leg in range(1, LEGS):
        through = total[:, np.newaxis] + cost
        best = np.argmin(through, axis=0)
        shorter = through[best, np.arange(len(cost))] < total
        before[leg] = np.where(shorter, best, -1)  # -1: reached as quickly in fewer
        total = np.where(shorter, through[best, np.arange(len(cost))], total)
    if not np.isfinite(total[1]):
        return []
    path, node = [1], 1
    for leg in range(LEGS - 1, 0, -1):
        if before[leg, node] >= 0:
            node = int(before[leg, node])
            path.append(node)
    return [*([] if node == 0 else [0]), *reversed(path)]


def _pointing(cones: KeepOut, attitudes: Array) -> Array:
    """Return where the body axis points, (m, 3) inertial."""
    return _in_body(attitudes * np.array([-1.0, -1.0, -1.0, 1.0]), cones.axis)


def _swung(cones: KeepOut, attitude: Array, pointing: Array) -> Array:
    """Return the attitudes (m, 4) of an attitude (1, 4) turned the short way until the body axis points so (m, 3)."""
    seen = _in_body(np.repeat(attitude, len(pointing), axis=0), pointing)
    across = np.cross(np.broadcast_to(cones.axis, seen.shape), seen)
    sine, cosine = np.linalg.norm(across, axis=1), seen @ cones.axis
    spare = _across(cones.axis, cones.axis)  # for half a turn any axis across will do
    axis = np.where(sine[:, np.newaxis] > 0.0, across / np.where(sine > 0.0, sine, 1.0)[:, np.newaxis], spare)
    return _turned(np.repeat(attitude, len(pointing), axis=0), np.arctan2(sine, cosine)[:, np.newaxis] * axis)


def _across(one: Array, other: Array) -> Array:
    """Return a unit vector normal to two, or to the first if they are parallel."""
    normal = np.cross(one, other)
    if float(normal @ normal) < 1e-12:
        normal = np.cross(one, np.eye(3)[int(np.argmin(np.abs(one)))])
    return _unit(normal)


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _in_body(attitudes: Array, vectors: Array) -> Array:
    """Return inertial vectors (3,) or (m, 3) in the body axes of attitudes (m, 4)."""
    q, w = attitudes[:, :3], attitudes[:, 3:]
    twice = 2.0 * np.cross(np.broadcast_to(vectors, q.shape), q)
    return np.asarray(vectors + w * twice + np.cross(twice, q))


def _turned(attitudes: Array, rotations: Array) -> Array:
    """Return attitudes (m, 4) turned further by rotation vectors (m, 3) [rad] in body axes."""
    half = 0.5 * np.linalg.norm(rotations, axis=1, keepdims=True)
    q = np.hstack([0.5 * np.sinc(half / math.pi) * rotations, np.cos(half)])
    return _unit(_composed(q, attitudes))


def _relative(attitudes: Array, bases: Array) -> Array:
    """Return the short rotation vectors (..., 3) [rad] from bases to attitudes (..., 4), in body axes."""
    q = _composed(attitudes, bases * np.array([-1.0, -1.0, -1.0, 1.0]))
    q = np.where(q[..., 3:] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    return np.asarray(q[..., :3] * (2.0 * np.arctan2(sine, q[..., 3:]) / np.where(sine > 0.0, sine, 1.0)))


def _composed(second: Array, first: Array) -> Array:
    """Return the rotations `first` followed by `second`, (..., 4): C(result) = C(second) C(first)."""
    a, b = second[..., :3], first[..., :3]
    vector = second[..., 3:] * b + first[..., 3:] * a - np.cross(a, b)
    scalar = second[..., 3:] * first[..., 3:] - np.sum(a * b, axis=-1, keepdims=True)
    return np.concatenate([vector, scalar], axis=-1)
