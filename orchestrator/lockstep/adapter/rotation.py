"""Convert attitudes between conventions, exactly invertible, by SciPy's rotations.

Everything passes through scalar-last quaternions, body from inertial: the direction cosine matrix C of such a rotation
takes the components of a vector in the inertial frame to those in the body frame, as in all interface ports. SciPy's
matrix of the same quaternion is the transpose of C, so that its products stand in the other order.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from lockstep.arrays import Array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Matrix = Sequence[Sequence[float]]


@cache
def _rotations() -> type[Rotation]:
    from scipy.spatial.transform import Rotation  # here only: it takes longer to import than a short run takes

    return Rotation


def quaternion_from_mrp(mrp: Array) -> Array:
    """Return the scalar-last unit quaternion, (4,), of an MRP, (3,)."""
    return np.asarray(_rotations().from_mrp(mrp).as_quat())


def mrp_from_quaternion(quaternion: Array) -> Array:
    """Return the MRP, (3,), of the short rotation of a scalar-last quaternion, (4,).

    Four zeros, which FMUs give before they have an attitude, are no rotation; what is not a number stays so.
    """
    square = float(quaternion @ quaternion)
    if not square > 0.0:
        return np.full(3, square)
    return np.asarray(_rotations().from_quat(quaternion).as_mrp())


def quaternion_matrix(
    *, body_frame: Matrix | None, inertial_frame: Matrix | None, inverse: bool, scalar_first: bool
) -> Array:
    """Return the matrix, (4, 4), from quaternions of the interface port to those of another convention.

    A change of frames or of direction is linear in the quaternion; the matrix is orthogonal.

    Parameters
    ----------
    body_frame, inertial_frame : (3, 3)
        Direction cosine matrices from the port's axes to the others; None if they are the same.
    inverse : whether the others are inertial from body
    scalar_first : whether the scalar is the first of the others' elements
    """
    rotations = _rotations()
    found = rotations.from_quat(np.eye(4))
    if inertial_frame is not None:
        found = rotations.from_matrix(np.array(inertial_frame)) * found
    if body_frame is not None:
        found = found * rotations.from_matrix(np.array(body_frame).T)
    if inverse:
        found = found.inv()
    return np.asarray(found.as_quat(scalar_first=scalar_first)).T


def rotation_problem(matrix: Matrix) -> str:
    """Return why a matrix, (3, 3), is no rotation, or nothing."""
    array = np.asarray(matrix, float)
    if not np.allclose(array @ array.T, np.eye(3), atol=1e-6):
        return "its rows must be orthogonal and of length 1"
    return "" if np.linalg.det(array) > 0.0 else "its determinant is -1: it mirrors"
