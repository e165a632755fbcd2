"""What the controller's filter estimates of external torque and gyro biases, as matrices of the linear loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.runtime.prepared_controller import PreparedController
from flexsat.runtime.slow_errors import TORQUES


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatedErrors:
    """Matrices of c, (k,): the torques and biases that are estimated; k is 0 where none are."""

    gain: Array  # (k, y): of the innovation at a sample of the star tracker
    shift: Array  # (s, k): change of the state's estimate for a change of c
    enters: Array  # (s, k): over a period
    seen: Array  # (y, k): in the measurements
    ahead: Array  # (r, k): until the wheels' torque acts
    against: Array  # (n, k): torque of the wheels against it


def estimated_errors(prepared: PreparedController) -> EstimatedErrors:
    """Return the matrices of what a controller estimates."""
    slow, count = prepared.slow, TORQUES + prepared.gyros
    measured, states = prepared.c.shape
    if slow is None:
        return EstimatedErrors(
            gain=np.zeros((0, measured)),
            shift=np.zeros((states, 0)),
            enters=np.zeros((states, 0)),
            seen=np.zeros((measured, 0)),
            ahead=np.zeros((prepared.controlled, 0)),
            against=np.zeros((prepared.wheels, 0)),
        )
    chosen = np.flatnonzero(slow.gain.any(axis=1))
    seen = np.zeros((measured, count))
    seen[: prepared.gyros, TORQUES:] = np.eye(prepared.gyros)
    return EstimatedErrors(
        gain=slow.gain[chosen],
        shift=slow.shift[:, chosen],
        enters=_of_torques(slow.enters, count)[:, chosen],
        seen=seen[:, chosen],
        ahead=_of_torques(slow.ahead, count)[:, chosen],
        against=_of_torques(slow.against, count)[:, chosen],
    )


def _of_torques(matrix: Array, count: int) -> Array:
    """Return a matrix of the torques with columns of zeros for the biases."""
    return np.hstack([matrix, np.zeros((len(matrix), count - TORQUES))])
