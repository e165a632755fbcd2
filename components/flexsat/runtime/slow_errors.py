"""Run-time filter of an external torque and of the gyros' biases, beside the filter of the state. numpy alone.

Its design is in design/slow_errors.py: rigid attitude and rate, the torque on the body (3) [N.m], the bias of each gyro
[rad/s]. Torque and biases are held while the star tracker gives no samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from ..fixed_order import inverse, product
from . import rotations
from .controller_parameters import ControllerMatrices, ControllerParameters
from .zero_order_hold import zero_order_hold

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


def prepare_slow_errors(
    matrices: ControllerMatrices, parameters: ControllerParameters, allocation: Array, part: float
) -> PreparedSlowErrors | None:
    """Return the filter that the parameters choose; None for none.

    Parameters
    ----------
    matrices, parameters : of the controller
    allocation : (n, 3) of a body torque among the wheels, as of `slew_guidance.allocation`
    part : of the period at whose end a new torque begins to act [s]

    Wheels against a torque on the body bend the structure where they stand on it. The regulator shall leave that
    deflection alone: its torque for the deflection is added.
    """
    chosen = choice_of(parameters)
    if chosen is None:
        return None
    fine, period = parameters.fine_sensor, parameters.period
    delay = parameters.measurement_delay + parameters.actuation_delay
    enters = zero_order_hold(matrices.a, matrices.b_body, period)[1]
    ahead = zero_order_hold(matrices.a, matrices.b_body, delay)[1] if delay > 0.0 else np.zeros_like(enters)
    bent = product(matrices.deflection_of_torque, allocation)
    modes = slice(3, 3 + matrices.modes)
    return PreparedSlowErrors(
        period=period,
        phases=len(matrices.gain_fine if fine else matrices.gain_coarse),
        gyro_axis=matrices.gyro_axis,
        sample=(matrices.slow_sample_fine if fine else matrices.slow_sample_coarse)[chosen],
        between=(matrices.slow_between_fine if fine else matrices.slow_between_coarse)[chosen],
        mobility=inverse(matrices.inertia),
        late=np.ascontiguousarray((part / period - 1.0) * matrices.wheel_axis.T),
        early=np.ascontiguousarray(-part / period * matrices.wheel_axis.T),
        enters=enters,
        ahead=np.ascontiguousarray(ahead[: matrices.feedback.shape[1]]),
        against=-product(matrices.feedback[:, modes], bent) - allocation,
    )


def choice_of(parameters: ControllerParameters) -> int | None:
    """Return the number of the filter among those that a design has: torque, biases, both; None for none."""
    if not (parameters.estimates_torque or parameters.estimates_bias):
        return None
    return int(parameters.estimates_bias) + int(parameters.estimates_torque and parameters.estimates_bias)


def init_slow_state(gyros: int) -> SlowState:
    """Return the state at the start: at rest, nothing known."""
    return SlowState(attitude=np.array([0.0, 0.0, 0.0, 1.0]), rate=np.zeros(3), errors=np.zeros(TORQUES + gyros))


def predict(slow: PreparedSlowErrors, state: SlowState, late: Array, early: Array) -> None:
    """Propagate attitude and rate over a period with the torques of the wheels that acted, (n,) each [N.m]."""
    torque = slow.late @ late + slow.early @ early + state.errors[:TORQUES]
    change = slow.period * (slow.mobility @ torque)
    turn = slow.period * (state.rate + 0.5 * change)
    state.rate += change
    state.attitude[:] = rotations.rotate_quaternion(state.attitude.tolist(), turn.tolist())


def correct(
    slow: PreparedSlowErrors, state: SlowState, gyro_rate: Array, seen: rotations.Quadruple | None, steps: int
) -> None:
    """Correct the estimate with measured rates, (g,) [rad/s], and attitude; None if there is no new one.

    `steps` is how long ago the sample of the star tracker before was. One after an outage, and the first, is the
    attitude from then on: by how much the prediction is off is due to more than the errors that are estimated.
    """
    innovation = gyro_rate - slow.gyro_axis @ state.rate - state.errors[TORQUES:]
    if seen is None:
        change = slow.between @ innovation
        if steps >= slow.phases:
            change[RATE.stop :] = 0.0
    elif steps > slow.phases:
        state.attitude[:] = seen
        return
    else:
        off = rotations.relative_mrp(seen, state.attitude.tolist())
        change = slow.sample @ np.concatenate([innovation, [4.0 * part for part in off]])
    state.attitude[:] = rotations.rotate_quaternion(state.attitude.tolist(), change[ATTITUDE].tolist())
    state.rate += change[RATE]
    state.errors += change[RATE.stop :]
