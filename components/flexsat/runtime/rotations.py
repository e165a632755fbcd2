"""Rotations: modified Rodrigues parameters, scalar-last quaternions, rotation vectors.

Every rotation here is `body_from_inertial`: it maps the components of a vector in the inertial frame to its
components in the body frame. This module alone defines attitude conventions. It uses Python floats
on purpose: they are faster than arrays for three or four numbers, and it runs at every step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Triple = tuple[float, float, float]
Quadruple = tuple[float, float, float, float]


def quaternion_from_mrp(mrp: Sequence[float]) -> Quadruple:
    """Return the scalar-last unit quaternion of an MRP.

    Source: Schaub and Junkins, Analytical Mechanics of Space Systems, eq. (3.140).
    """
    x, y, z = mrp
    square = x * x + y * y + z * z
    scale = 1.0 / (1.0 + square)
    return 2.0 * x * scale, 2.0 * y * scale, 2.0 * z * scale, (1.0 - square) * scale


def mrp_from_quaternion(quaternion: Sequence[float]) -> Triple:
    """Return the MRP of the short rotation (norm at most 1) of a scalar-last unit quaternion."""
    x, y, z, w = quaternion
    scale = 1.0 / (1.0 + w) if w >= 0.0 else -1.0 / (1.0 - w)
    return x * scale, y * scale, z * scale


def compose_quaternions(second: Sequence[float], first: Sequence[float]) -> Quadruple:
    """Return the rotation `first` followed by `second`: C(result) = C(second) C(first)."""
    x2, y2, z2, w2 = second
    x1, y1, z1, w1 = first
    return (
        w1 * x2 + w2 * x1 - (y2 * z1 - z2 * y1),
        w1 * y2 + w2 * y1 - (z2 * x1 - x2 * z1),
        w1 * z2 + w2 * z1 - (x2 * y1 - y2 * x1),
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
    )


def quaternion_from_rotation_vector(rotation: Sequence[float]) -> Quadruple:
    """Return the scalar-last quaternion of a rotation vector [rad]."""
    x, y, z = rotation
    angle = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * angle
    # sin(x)/x loses nothing to its series below 1e-4: the next term is under 1e-17
    scale = math.sin(half) / angle if angle > 1e-4 else 0.5 - angle * angle / 48.0
    return x * scale, y * scale, z * scale, math.cos(half)


def rotation_vector(quaternion: Sequence[float]) -> Triple:
    """Return the rotation vector [rad] of the short rotation of a scalar-last unit quaternion."""
    x, y, z, w = quaternion
    sine = math.sqrt(x * x + y * y + z * z)
    if sine == 0.0:
        return 0.0, 0.0, 0.0
    scale = 2.0 * math.atan2(sine, abs(w)) / sine
    scale = scale if w >= 0.0 else -scale
    return x * scale, y * scale, z * scale


def relative_quaternion(quaternion: Sequence[float], base: Sequence[float]) -> Quadruple:
    """Return the rotation from the attitude `base` to another, in body axes: C(result) = C(quaternion) C(base)^T."""
    x, y, z, w = base
    return compose_quaternions(quaternion, (-x, -y, -z, w))


def relative_mrp(quaternion: Sequence[float], base: Sequence[float]) -> Triple:
    """Return the MRP of the short rotation from the attitude `base` to another, in body axes."""
    return mrp_from_quaternion(relative_quaternion(quaternion, base))


def rotate_quaternion(quaternion: Sequence[float], rotation: Sequence[float]) -> Quadruple:
    """Turn an attitude further by a rotation vector [rad] in body axes; the result has norm 1."""
    x, y, z, w = compose_quaternions(quaternion_from_rotation_vector(rotation), quaternion)
    scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return x * scale, y * scale, z * scale, w * scale


def rotate_mrp(mrp: Sequence[float], rotation: Sequence[float]) -> Triple:
    """Turn the attitude `mrp` further by a rotation vector [rad] in body axes; switch to the shadow set beyond 1."""
    return mrp_from_quaternion(compose_quaternions(quaternion_from_rotation_vector(rotation), quaternion_from_mrp(mrp)))


def matrix_from_mrp(mrp: Sequence[float]) -> Vector:
    """Return the direction cosine matrix C, (3, 3), body from inertial."""
    x, y, z, w = quaternion_from_mrp(mrp)
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z],
        ]
    )


def error_angle(mrp: Vector, reference: Vector) -> Vector:
    """Return the angle [rad], (n,), between two attitude histories (n, 3) given as MRPs."""
    sine = np.linalg.norm(_error_quaternion(mrp, reference), axis=1)
    return np.asarray(2.0 * np.arcsin(np.minimum(sine, 1.0)))


def error_rotation(mrp: Vector, reference: Vector) -> Vector:
    """Return the rotation vector [rad], (n, 3) in body axes, from the reference to the attitude, both (n, 3) MRPs.

    Its norm is `error_angle`; it is meant for errors far below half a turn.
    """
    vector = _error_quaternion(mrp, reference)
    sine = np.minimum(np.linalg.norm(vector, axis=1, keepdims=True), 1.0)
    # angle over sine of half of it: 2 where the angle is nothing
    scale = np.divide(2.0 * np.arcsin(sine), sine, out=np.full_like(sine, 2.0), where=sine > 0.0)
    return np.asarray(vector * scale)


def _error_quaternion(mrp: Vector, reference: Vector) -> Vector:
    """Return the vector part of the quaternion from reference to attitude, (n, 3), of the short rotation.

    Accurate for small errors.
    """
    a2 = np.sum(mrp**2, axis=1, keepdims=True)
    b2 = np.sum(reference**2, axis=1, keepdims=True)
    # vector part of q_ref^-1 q, times (1 + a2)(1 + b2)
    vector = 2.0 * (1.0 - b2) * mrp - 2.0 * (1.0 - a2) * reference + 4.0 * np.cross(mrp, reference)
    scalar = (1.0 - a2) * (1.0 - b2) + 4.0 * np.sum(mrp * reference, axis=1, keepdims=True)
    return np.asarray(np.where(scalar < 0.0, -vector, vector) / ((1.0 + a2) * (1.0 + b2)))


def skew(vector: Sequence[float]) -> Vector:
    """Return [a x], (3, 3), so that [a x] b = a x b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
