"""The controller's filter of external torque and gyro biases, as matrices of the linear loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.runtime.prepared_controller import PreparedController
from flexsat.slow_errors import ATTITUDE, BIASES, RATE, TORQUE, PreparedSlowErrors


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowFilter:
    """Matrices of its state, (k,): attitude [rad], rate, and the torques and biases that are estimated; or k = 0."""

    a: Array  # (k, k): over a period
    late: Array  # (k, n): of the wheels' torques of `whole_delay` steps before
    early: Array  # (k, n): of those of a step more before
    gains: tuple[Array, Array]  # (k, y): at a sample of the star tracker, and at the other steps
    seen: Array  # (y, k): by the measurements
    enters: Array  # (s, k): in the state of the controller's other filter, over a period
    known: Array  # (y, k): what that filter takes off the measurements
    ahead: Array  # (r, k): in its state, until the wheels' torque acts
    against: Array  # (n, k): torque of the wheels against it


def slow_filter(prepared: PreparedController) -> SlowFilter:
    """Return the matrices of the filter that a controller has; of no states if it has none."""
    measured, states = prepared.c.shape
    n, r, gyros = prepared.wheels, prepared.controlled, prepared.gyros
    slow, size = prepared.slow, BIASES + gyros
    if slow is None:
        none = np.zeros((0, measured))
        return SlowFilter(
            a=np.zeros((0, 0)), late=np.zeros((0, n)), early=np.zeros((0, n)), gains=(none, none), seen=none.T,
            enters=np.zeros((states, 0)), known=none.T, ahead=np.zeros((r, 0)), against=np.zeros((n, 0)),
        )  # fmt: skip
    chosen = np.flatnonzero(slow.sample.any(axis=1))
    a, late, early = _motion(slow, size)
    seen, known = np.zeros((measured, size)), np.zeros((measured, size))
    known[:gyros, BIASES:] = np.eye(gyros)
    seen[:gyros] = known[:gyros]
    seen[:gyros, RATE] = slow.gyro_axis
    seen[-3:, ATTITUDE] = np.eye(3)
    sample, between = np.zeros((size, measured)), np.zeros((size, measured))
    sample[:, :gyros], sample[:, -3:] = slow.sample[:, :gyros], slow.sample[:, gyros:]
    between[:, :gyros] = slow.between
    return SlowFilter(
        a=a[np.ix_(chosen, chosen)],
        late=late[chosen],
        early=early[chosen],
        gains=(sample[chosen], between[chosen]),
        seen=seen[:, chosen],
        enters=_of_torque(slow.enters, size)[:, chosen],
        known=known[:, chosen],
        ahead=_of_torque(slow.ahead, size)[:, chosen],
        against=_of_torque(slow.against, size)[:, chosen],
    )


def _motion(slow: PreparedSlowErrors, size: int) -> tuple[Array, Array, Array]:
    """Return the transition over a period, (k, k), and the inputs of the wheels' torques, (k, n)."""
    a, torque = np.eye(size), np.zeros((size, 3))
    a[ATTITUDE, RATE] = slow.period * np.eye(3)
    torque[ATTITUDE], torque[RATE] = 0.5 * slow.period**2 * slow.mobility, slow.period * slow.mobility
    a[:, TORQUE] += torque
    return a, torque @ slow.late, torque @ slow.early


def _of_torque(matrix: Array, size: int) -> Array:
    """Return a matrix of the torques with columns of zeros for the other states."""
    whole = np.zeros((len(matrix), size))
    whole[:, TORQUE] = matrix
    return whole
