"""Run-time estimate of an external torque and of the gyros' biases beside the filter's state. numpy alone.

The design is in design/slow_errors.py. c holds the torque on the body (3) [N.m], then the bias of each gyro [rad/s]. It
changes at samples of the star tracker alone: without them it is held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from ..fixed_order import product
from .controller_parameters import ControllerMatrices, ControllerParameters
from .zero_order_hold import zero_order_hold

TORQUES = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedSlowErrors:
    """What a step uses of c, (k,)."""

    gain: Array  # (k, y): of the innovation at a sample of the star tracker
    shift: Array  # (s, k): change of the state's estimate for a change of c then
    enters: Array  # (s, 3): of the torque, over a period
    ahead: Array  # (r, 3): of the torque, to the time at which the wheels' torque acts
    against: Array  # (n, 3): torque of the wheels against that on the body

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare_slow_errors(
    matrices: ControllerMatrices, parameters: ControllerParameters, allocation: Array
) -> PreparedSlowErrors | None:
    """Return the filter that the parameters choose; None for none.

    Parameters
    ----------
    matrices, parameters : of the controller
    allocation : (n, 3) of a body torque among the wheels, as of `slew_guidance.allocation`

    Wheels against a torque on the body bend the structure where they stand on it. The regulator shall leave that
    deflection alone: its torque for the deflection is added.
    """
    chosen = choice_of(parameters)
    if chosen is None:
        return None
    gains = matrices.slow_gain_fine if parameters.fine_sensor else matrices.slow_gain_coarse
    shift = matrices.slow_shift_fine if parameters.fine_sensor else matrices.slow_shift_coarse
    delay = parameters.measurement_delay + parameters.actuation_delay
    controlled = matrices.feedback.shape[1]
    enters = zero_order_hold(matrices.a, matrices.b_body, parameters.period)[1]
    ahead = zero_order_hold(matrices.a, matrices.b_body, delay)[1] if delay > 0.0 else np.zeros_like(enters)
    modes = slice(3, 3 + matrices.modes)
    bent = product(matrices.deflection_of_torque, -allocation)
    return PreparedSlowErrors(
        gain=gains[chosen],
        shift=shift,
        enters=enters,
        ahead=np.ascontiguousarray(ahead[:controlled]),
        against=product(matrices.feedback[:, modes], bent) - allocation,
    )


def choice_of(parameters: ControllerParameters) -> int | None:
    """Return the number of the filter among those that a design has: torque, bias, both; None for none."""
    if not (parameters.estimates_torque or parameters.estimates_bias):
        return None
    return int(parameters.estimates_bias) + int(parameters.estimates_torque and parameters.estimates_bias)


def predict(slow: PreparedSlowErrors, errors: Array, estimate: Array) -> None:
    """Add what the torque does to the state over a period, in place."""
    estimate += slow.enters @ errors[:TORQUES]


def correct(slow: PreparedSlowErrors, errors: Array, estimate: Array, innovation: Array) -> None:
    """Correct c with the innovation at a sample of the star tracker, and the state by what that changes, in place."""
    change = slow.gain @ innovation
    errors += change
    estimate += slow.shift @ change
