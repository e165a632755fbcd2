"""Give torque about the body axes to the wheels that work, and torque of thrusters to couples of them. numpy alone."""

from __future__ import annotations

import numpy as np

from ...arrays import Array, Flags
from .thrusters import wrench_of

SPANNED = 1e-6  # determinant of the sum of axis times axis: less is a plane
PURE = 1e-9  # force over torque times 1/m, of a couple
SMALL = 1e-9  # of a share of torque, 1/m


def inverse_of_axes(axis: Array, works: Flags) -> Array | None:
    """Return (E^T E)^-1, (3, 3), of the axes (n, 3) of the wheels that work; None if they span no space.

    E (E^T E)^-1 is the pseudo-inverse of E^T: the torques of least squares that sum to a torque of the body.
    """
    left = axis * works[:, np.newaxis]
    gram = left.T @ left
    if not np.linalg.det(gram) > SPANNED:
        return None
    return np.asarray(np.linalg.inv(gram))


def thruster_shares(position: Array, direction: Array) -> Array:
    """Return the thrust of each thruster (k, 3) [N] for a torque of 1 N.m about each axis; below 0: of the other sign.

    Thrusts that push are taken and the others left out: a layout in which each thruster has an opposite one, in torque
    and force, gives the torque then, and no force.

    Raises
    ------
    ValueError
        For a layout that gives a torque about some axis only with a force or another torque.
    """
    wrench = wrench_of(position, direction)
    gram = wrench[3:] @ wrench[3:].T
    if np.linalg.det(gram) > SPANNED:
        shares = np.asarray(2.0 * wrench[3:].T @ np.linalg.inv(gram))
        shares[np.abs(shares) < SMALL] = 0.0
        pure = np.vstack([np.zeros((3, 3)), np.eye(3)])
        made = [wrench @ np.maximum(sign * shares, 0.0) - sign * pure for sign in (1.0, -1.0)]
        if np.abs(made).max() < PURE:
            return shares
    raise ValueError(
        "thruster.position and thruster.direction give no torque about each axis without a force or another torque;"
        " let each thruster have an opposite one"
    )
