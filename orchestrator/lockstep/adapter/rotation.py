"""Attitudes in other conventions, exactly invertible. Everything is scalar-last quaternions in between.

`body_from_inertial` means: the rotation that takes the components of a vector in the inertial frame to those in the
body frame, as in all ports of ours. Formulas: Schaub and Junkins, Analytical Mechanics of Space Systems, chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lockstep.arrays import Array


def quaternion_from_mrp(mrp: Array) -> Array:
    """Return the scalar-last unit quaternion, (4,), of an MRP, (3,)."""
    square = float(mrp @ mrp)
    return np.array([*(2.0 * mrp), 1.0 - square]) / (1.0 + square)


def mrp_from_quaternion(quaternion: Array) -> Array:
    """Return the MRP, (3,), of the short rotation of a scalar-last unit quaternion, (4,)."""
    vector, scalar = quaternion[:3], float(quaternion[3])
    return vector / (1.0 + scalar) if scalar >= 0.0 else -vector / (1.0 - scalar)


def conjugate(quaternion: Array) -> Array:
    """Return the inverse of a unit quaternion."""
    return np.asarray(quaternion * _CONJUGATE)


_CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])


def compose(second: Array, first: Array) -> Array:
    """Return the rotation `first` followed by `second`: C(result) = C(second) C(first)."""
    vector = second[3] * first[:3] + first[3] * second[:3] - np.cross(second[:3], first[:3])
    return np.array([*vector, second[3] * first[3] - second[:3] @ first[:3]])


def quaternion_from_matrix(matrix: Array) -> Array:
    """Return the scalar-last quaternion of a direction cosine matrix, (3, 3), by its largest component (Shepperd)."""
    trace = float(np.trace(matrix))
    squares = np.array([*(1.0 + 2.0 * np.diag(matrix) - trace), 1.0 + trace])
    k = int(np.argmax(squares))
    size = math.sqrt(squares[k])
    difference = np.array(
        [matrix[1, 2] - matrix[2, 1], matrix[2, 0] - matrix[0, 2], matrix[0, 1] - matrix[1, 0]]
    )  # 4 q_i q_4
    total = matrix + matrix.T  # 4 q_i q_j off the diagonal
    column = np.empty(4)
    if k == 3:
        column[:3] = difference
    else:
        column[:3] = total[:, k]
        column[3] = difference[k]
    column[k] = squares[k]
    return 0.5 * column / size


def rotation_problem(matrix: Sequence[Sequence[float]]) -> str:
    """Return why a matrix, (3, 3), is no rotation, or nothing."""
    array = np.asarray(matrix, float)
    if not np.allclose(array @ array.T, np.eye(3), atol=1e-6):
        return "its rows must be orthogonal and of length 1"
    return "" if np.linalg.det(array) > 0.0 else "its determinant is -1: it mirrors"
