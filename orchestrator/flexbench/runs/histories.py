"""Compute histories from recorded signals: plain arrays in SI units, one value for each recorded row."""

from __future__ import annotations

import numpy as np

from flexsat.arrays import Array
from flexsat.runtime.rotations import error_angle, error_rotation
from lockstep import Signals
from lockstep.errors import InputError
from lockstep.system.clock import SAME_TIME

from .flown_design import FlownDesign

ATTITUDE, ATTITUDE_REFERENCE = "plant.attitude.mrp", "controller.reference.mrp"
RATE, RATE_REFERENCE = "plant.rate", "controller.reference.rate"
DEFORMATION = "plant.rms_deformation"
TORQUE, TORQUE_REFERENCE = "controller.wheel.torque", "controller.reference.torque"
# the regulated state without the wheels, in its order: true value and reference
STRUCTURE = (
    ("plant.attitude.mrp", "controller.reference.mrp"),
    ("plant.modal.displacement", "controller.reference.modal.displacement"),
    ("plant.rate", "controller.reference.rate"),
    ("plant.modal.velocity", "controller.reference.modal.velocity"),
)
MODAL = ("plant.modal.displacement", "plant.modal.velocity")


def pointing_error(signals: Signals) -> Array:
    """Return the angle between attitude and reference, (rows,) [rad]."""
    return error_angle(signals[ATTITUDE], signals[ATTITUDE_REFERENCE])


def pointing_error_vector(signals: Signals) -> Array:
    """Return the rotation vector from reference to attitude, (rows, 3) [rad] in body axes."""
    return error_rotation(signals[ATTITUDE], signals[ATTITUDE_REFERENCE])


def rate_error(signals: Signals) -> Array:
    """Return the norm of body rate less reference, (rows,) [rad/s]."""
    return _norm(signals[RATE] - signals[RATE_REFERENCE])


def deformation(signals: Signals) -> Array:
    """Return the RMS deflection of the aperture, (rows,) [m]."""
    return signals[DEFORMATION]


def rotation_about_x(signals: Signals, attitude: str = ATTITUDE) -> Array:
    """Return the rotation angle about body x, (rows,) [rad], of the true attitude or of another, such as the reference.

    The twist of the rotation about x: for a turn about x alone, its angle.
    """
    mrp = signals[attitude]
    # half of it has 2 x as its sine and 1 - |mrp|^2 as its cosine, both over 1 + |mrp|^2, as the quaternion has
    return np.asarray(2.0 * np.arctan2(2.0 * mrp[:, 0], 1.0 - np.sum(mrp**2, axis=1)))


def torque_norm(signals: Signals, torque: str = TORQUE) -> Array:
    """Return the sum over the wheels of |torque|, (rows,) [N.m]: of the command, or of the feed-forward."""
    return np.asarray(np.sum(np.abs(signals[torque]), axis=1))


def torque_impulse(signals: Signals, torque: str = TORQUE) -> Array:
    """Return the time integral of `torque_norm`, (rows,) [N.m.s]; each torque holds until the next row."""
    held = torque_norm(signals, torque)[:-1] * np.diff(signals.time)
    return np.concatenate([[0.0], np.cumsum(held)])


def wheel_speed_deviation(signals: Signals, design: FlownDesign) -> Array:
    """Return inertial wheel speed about each axis, less nominal, (rows, n) [rad/s].

    Recorded is the speed relative to the mount; the mount turns with the body and with the modes.
    """
    # the plant may have ports for more: of a file they are not even read
    flexible = signals.side_by_side([f"plant.modal.velocity[{mode + 1}]" for mode in range(design.modes)])
    mount = signals["plant.rate"] @ design.wheel_axis.T + flexible @ design.wheel_axial_slope.T
    return np.asarray(signals["plant.wheel.speed"] + mount - design.nominal_speed)


def of_known_modes(signals: Signals, design: FlownDesign, name: str) -> Array:
    """Return a signal of the plant, of its modes only those that the controller is designed with."""
    if name not in MODAL:
        return signals[name]
    return signals.side_by_side([f"{name}[{mode + 1}]" for mode in design.known_modes])


def regulated_error(signals: Signals, design: FlownDesign) -> Array:
    """Return the error that the regulator drives to zero, (rows, c): its basis^T (x - x_ref).

    x - x_ref is a quarter of the rotation from reference to attitude [rad], and the differences of modal displacement
    [m sqrt(kg)], body rate [rad/s], modal velocity [m sqrt(kg)/s] and inertial wheel speed less nominal [rad/s]; of
    the modes, those that the controller is designed with.
    """
    weights = design.weights()
    parts = [of_known_modes(signals, design, true) - signals[reference] for true, reference in STRUCTURE[1:]]
    parts.insert(0, 0.25 * pointing_error_vector(signals))  # MRPs do not subtract far from zero
    parts.append(wheel_speed_deviation(signals, design) - signals["controller.reference.wheel.speed"])
    return np.asarray(np.hstack(parts) @ weights.basis)


def lqr_cost(signals: Signals, design: FlownDesign) -> tuple[Array, Array]:
    """Return the regulator's cost of each row: total and control part, (rows,) each.

    Half the quadratic forms z^T Q z + u^T R u and u^T R u of the regulated error z and of the torque less its
    feed-forward u, without the period. The published costs are plain sums of these over the samples of the controller
    (PHYSICS section 7): take the rows of `controller_rows`.
    """
    error = regulated_error(signals, design)
    torque = signals[TORQUE] - signals[TORQUE_REFERENCE]
    control = _half_form(torque, design.weights().torque_weight)
    return _half_form(error, design.weights().state_weight) + control, control


def controller_rows(signals: Signals, design: FlownDesign) -> slice:
    """Return which rows are samples of the controller.

    Raises
    ------
    InputError
        If the record period does not divide the controller's period.
    """
    period = design.period
    if not period > 0.0:
        raise InputError("LQR cost: the run's controller has no period of a regulator")
    interval = float(signals.time[1] - signals.time[0]) if len(signals.time) > 1 else period
    stride = round(period / interval)
    if stride < 1 or abs(stride * interval - period) > SAME_TIME:
        raise InputError(
            f"record period {interval:.9g} s: must divide the controller's period of {period:.9g} s, to sum its cost"
        )
    return slice(None, None, stride)


def _norm(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _half_form(vectors: Array, weight: Array) -> Array:
    return np.asarray(0.5 * np.sum((vectors @ weight) * vectors, axis=1))
