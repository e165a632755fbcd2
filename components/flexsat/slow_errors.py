"""Run-time filter of an external torque and of the gyros' biases, beside the filter of the state. numpy alone.

Its design is in design/slow_errors.py: rigid attitude and rate, the torque on the body (3) [N.m], the bias of each gyro
[rad/s]. Torque and biases are held while the star tracker gives no samples. Attitudes are turned by whoever steps it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array, make_read_only

ATTITUDE, RATE, TORQUE, BIASES = slice(0, 3), slice(3, 6), slice(6, 9), 9  # of the filter's state
TORQUES = 3  # the first of the slow errors; the biases are the others


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedSlowErrors:
    """What a step uses; k = 9 + g."""

    period: float  # s
    phases: int  # steps between two samples of the star tracker
    gyro_axis: Array  # (g, 3)
    sample: Array  # (k, g + 3)
    between: Array  # (k, g)
    mobility: Array  # (3, 3): inverse inertia [1/(kg.m2)]
    late: Array  # (3, n): torque on the body, of the wheels' torques of `whole_delay` steps before
    early: Array  # (3, n): of those of a step more before
    enters: Array  # (s, 3): of the torque, in the state of the other filter, over a period
    ahead: Array  # (r, 3): of the torque, until the wheels' torque acts
    against: Array  # (n, 3): torque of the wheels against that on the body

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(slots=True, kw_only=True)
class SlowState:
    """What the filter remembers; steps work in place."""

    attitude: Array  # (4,) body from inertial
    rate: Array  # (3,) [rad/s]
    errors: Array  # (3 + g,): torque on the body [N.m], bias of each gyro [rad/s]; 0 if not estimated


def init_slow_state(gyros: int) -> SlowState:
    """Return the state at the start: at rest, nothing known."""
    return SlowState(attitude=np.array([0.0, 0.0, 0.0, 1.0]), rate=np.zeros(3), errors=np.zeros(TORQUES + gyros))


def predict(slow: PreparedSlowErrors, state: SlowState, late: Array, early: Array) -> Array:
    """Propagate the rate over a period with the torques of the wheels that acted, (n,) each [N.m].

    Returns by which rotation vector [rad] the attitude turns meanwhile.
    """
    torque = slow.late @ late + slow.early @ early + state.errors[:TORQUES]
    change = slow.period * (slow.mobility @ torque)
    turn = slow.period * (state.rate + 0.5 * change)
    state.rate += change
    return np.asarray(turn)


def correct(slow: PreparedSlowErrors, state: SlowState, gyro_rate: Array, off: Array | None, steps: int) -> Array:
    """Correct the estimate; return by which rotation vector [rad] the attitude is to be turned.

    Parameters
    ----------
    gyro_rate : (g,) measured [rad/s]
    off : (3,) [rad] rotation from the predicted attitude to the measured one; None if there is no new sample
    steps : how long ago the sample of the star tracker before was
    """
    innovation = gyro_rate - slow.gyro_axis @ state.rate - state.errors[TORQUES:]
    if off is None:
        change = slow.between @ innovation
        if steps >= slow.phases:
            change[RATE.stop :] = 0.0
    else:
        change = slow.sample @ np.concatenate([innovation, off])
    state.rate += change[RATE]
    state.errors += change[RATE.stop :]
    return np.asarray(change[ATTITUDE])
