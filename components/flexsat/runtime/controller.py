"""Run-time LQG flight controller: periodic Kalman filter, slew reference, regulator, saturation, known delays.

numpy alone. One step is one period (5 ms): it reads the measurements on its inputs, and its torque holds from then on.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .. import slow_errors
from ..allocation import null_torque
from ..arrays import Array
from . import rotations, slew_motion
from . import wheel_jitter as jitter
from .named_state import NOT_SAVED
from .prepared_controller import PreparedController, check_start, plan_motion, prepare
from .slew_commands import after_first, command, first_turns, proceed, reference_attitude, start_from
from .slew_guidance import share_of

__all__ = [
    "ControllerOutputs",
    "ControllerState",
    "Measurements",
    "PreparedController",
    "command",
    "init",
    "is_due",
    "prepare",
    "step",
]

ZERO_ATTITUDE = np.array([0.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Measurements:
    """Inputs of a step: what the sensors give. A shell gives views that the master writes into."""

    gyro_rate: Array  # (g,) [rad/s]
    accelerometer: Array  # (k,) [m/s2]
    encoder_speed: Array  # (n,) [rad/s]
    encoder_angle: Array  # (n,) [rad]
    star_tracker_mrp: Array  # (3,)
    star_tracker_valid: bool | NDArray[np.bool_]  # a new sample; a shell gives a view, shape ()
    applied_torque: Array | None = None  # (n,) [N.m], commanded in the step before by the controller in control
    applied_valid: bool | NDArray[np.bool_] = False  # applied_torque is given; else it was this controller's


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerOutputs:
    """Hold from the sampling time on. Buffers that the next step overwrites.

    `estimate` and `reference` are those the torque was made from. `innovation` is what was measured less what was
    predicted, in the order of the linear model's outputs; the star tracker's three are meaningful only when its sample
    was valid.
    """

    torque: Array  # (n,) [N.m]
    estimate: Array  # (s,)
    reference: Array  # (r,)
    reference_torque: Array  # (n,) [N.m]
    innovation: Array  # (y,)
    slow_errors: Array  # (3 + g,): estimated torque on the body [N.m], and bias of each gyro [rad/s]


@dataclass(slots=True, kw_only=True)
class ControllerState:
    """What the controller remembers between steps, and the outputs that a step writes; `step` works in place.

    The linear models know small rotations only. The estimated attitude is `attitude`, turned further by four times the
    first three of `estimate`, which each step moves into it. The reference attitude is `origin`, turned by four times
    the first three of `reference` (slew_commands.reference_attitude). With linear attitudes both stay in the linear
    state.
    """

    estimate: Array  # (s,) at the time of the last measurement
    attitude: Array  # (4,) body from inertial
    captured: bool  # the star tracker has given an attitude
    history: Array  # (q + 2, n): torques commanded, by this or the controller in control, the latest first [N.m]
    jitter: Array  # (4, n): harmonic jitter expected over the coming period
    since_star_tracker: int  # steps
    count: int  # steps done
    held: int  # calls since the last step, itself included, where there are several calls to a period
    reference: Array  # (r,)
    origin: Array  # (4,) attitude from which the profile turns, body from inertial
    profile: slew_motion.Motion
    turns: Array  # (LEGS, 3) [rad]: the turns of the present slew after the profile
    turns_ended: int  # of the present slew
    following: slew_motion.Motion  # the slew after it: its first turn
    following_turns: Array  # (LEGS, 3) [rad]: its other turns
    base: Array  # (4,) attitude from which the command of the profile counts
    following_base: Array  # (4,) the same, of the slew after it
    braking: bool  # the profile was braked for a new command
    commanded_rotation: Array  # (3,) [rad], of the last command
    commanded_start: float  # s
    slow: slow_errors.SlowState
    outputs: ControllerOutputs = field(metadata=NOT_SAVED)


def init(prepared: PreparedController, rotation: Array, start: float) -> ControllerState:
    """Return the state at the start of a run, at rest at the nominal wheel speeds, with a slew planned.

    Raises
    ------
    ValueError
        If the shaped torque would have to begin before the run, or before the first measurement can count it.
        Whether the slew begins or ends within a keep-out cone is seen once the attitude is known (start_from).
    """
    s, n, r = prepared.states, prepared.wheels, prepared.controlled
    turns = first_turns(rotation)
    profile = plan_motion(prepared, turns[0], start)
    check_start(prepared, profile.angle, start)
    return ControllerState(
        estimate=np.zeros(s),
        attitude=ZERO_ATTITUDE.copy(),
        captured=False,
        history=np.zeros((prepared.whole_delay + 2, n)),
        jitter=np.zeros((4, n)),
        since_star_tracker=prepared.phases - 1,
        count=0,
        held=0,
        reference=np.zeros(r),
        origin=ZERO_ATTITUDE.copy(),
        profile=profile,
        turns=after_first(turns),
        turns_ended=0,
        following=slew_motion.still(prepared.knots),
        following_turns=np.zeros_like(turns),
        base=ZERO_ATTITUDE.copy(),
        following_base=ZERO_ATTITUDE.copy(),
        braking=False,
        commanded_rotation=np.array(rotation, np.float64),
        commanded_start=float(start),
        slow=slow_errors.init_slow_state(prepared.gyros),
        outputs=ControllerOutputs(
            torque=np.zeros(n),
            estimate=np.zeros(s),
            reference=np.zeros(r),
            reference_torque=np.zeros(n),
            innovation=np.zeros(len(prepared.c)),
            slow_errors=np.zeros(slow_errors.TORQUES + prepared.gyros),
        ),
    )


def is_due(state: ControllerState, calls: int) -> bool:
    """Count a call, `calls` of them to a period; return whether a step is due in it."""
    due = state.held == 0
    state.held = (state.held + 1) % calls
    return due


def step(
    prepared: PreparedController, state: ControllerState, time: float, measured: Measurements
) -> ControllerOutputs:
    """Correct the estimate with what was measured, and command the torque.

    Parameters
    ----------
    prepared : the sampled design
    state : updated in place
    time : of this call [s]; the reference is taken when the torque will act
    measured : on the inputs now, that is, sampled `measurement_delay` ago

    Source: P, section 6; the delays are an extension (PHYSICS section 6).
    """
    history, outputs = state.history, state.outputs
    if measured.applied_valid and measured.applied_torque is not None and state.count:
        history[0] = measured.applied_torque
    if state.count >= prepared.first_measurement:
        _correct(prepared, state, time, measured)
    else:
        outputs.innovation[:] = 0.0

    proceed(prepared, state, time)
    r = prepared.controlled
    expected = state.estimate[:r]
    if prepared.delayed:
        expected = prepared.ahead @ np.concatenate([state.estimate, history.ravel()])
        if prepared.slow is not None:
            expected += prepared.slow.ahead @ state.slow.errors[: slow_errors.TORQUES]
    attitude = _refer(prepared, state, time + prepared.actuation_delay)
    error = expected - outputs.reference
    outputs.estimate[:] = state.estimate
    if not prepared.linear_attitude:
        estimated = _turned(state.attitude, state.estimate)
        outputs.estimate[:3] = rotations.mrp_from_quaternion(estimated)
        if prepared.delayed:
            estimated = _turned(state.attitude, expected)
        error[:3] = rotations.relative_mrp(estimated, attitude)
    torque = outputs.reference_torque - prepared.feedback @ error
    if prepared.cancels_jitter and state.count >= prepared.first_measurement:
        torque += prepared.jitter_torque @ _jitter_ahead(prepared, measured)
    if prepared.slow is not None:
        torque += prepared.slow.against @ state.slow.errors[: slow_errors.TORQUES]
        outputs.slow_errors[:] = state.slow.errors
    outputs.torque[:] = _saturate(prepared, torque, expected[r - prepared.wheels :])
    if prepared.open_loop:
        outputs.torque[:] = 0.0
    history[1:] = history[:-1].copy()
    history[0] = outputs.torque
    state.count += 1
    return outputs


def _correct(prepared: PreparedController, state: ControllerState, time: float, measured: Measurements) -> None:
    """Predict the estimate to the time of the measurement and correct it; predict the jitter of the next period."""
    if state.count > prepared.first_measurement:
        stack = np.concatenate([state.estimate, state.history.ravel(), state.jitter.ravel()])
        prepared.predict.dot(stack, out=state.estimate)
        if prepared.slow is not None:
            whole = prepared.whole_delay
            state.estimate += prepared.slow.enters @ state.slow.errors[: slow_errors.TORQUES]
            own = state.slow
            turn = slow_errors.predict(prepared.slow, own, state.history[whole], state.history[whole + 1])
            own.attitude[:] = rotations.rotate_quaternion(own.attitude.tolist(), turn.tolist())
    if prepared.slow is not None:
        _correct_slow_errors(prepared.slow, state, measured)
    state.since_star_tracker = 0 if measured.star_tracker_valid else state.since_star_tracker + 1
    phase = min(state.since_star_tracker, prepared.phases - 1)
    innovation = state.outputs.innovation
    np.concatenate(
        [
            measured.gyro_rate,
            measured.accelerometer,
            measured.encoder_speed - prepared.nominal_speed,
            4.0 * measured.star_tracker_mrp,
        ],
        out=innovation,
    )
    innovation -= prepared.c @ state.estimate
    if prepared.slow is not None:
        innovation[: prepared.gyros] -= state.slow.errors[slow_errors.TORQUES :]
    if not prepared.linear_attitude:
        innovation[-3:] = _attitude_innovation(prepared, state, time, measured)
    state.estimate += prepared.gain[phase] @ innovation
    if prepared.feed_forward_jitter:
        jitter.harmonic(
            measured.encoder_speed,
            measured.encoder_angle,
            prepared.period,
            prepared.imbalance_force,
            prepared.imbalance_torque,
            state.jitter,
        )


def _correct_slow_errors(slow: slow_errors.PreparedSlowErrors, state: ControllerState, measured: Measurements) -> None:
    """Correct torque and biases, before the step's sample of the star tracker is counted.

    A sample after an outage, and the first, is the attitude from then on: by how much the prediction is off is due to
    more than the errors that are estimated.
    """
    own = state.slow
    steps = state.since_star_tracker + 1 if state.captured else slow.phases + 1
    off = None
    if measured.star_tracker_valid:
        seen = rotations.quaternion_from_mrp(measured.star_tracker_mrp.tolist())
        if steps > slow.phases:
            own.attitude[:] = seen
            return
        off = 4.0 * np.array(rotations.relative_mrp(seen, own.attitude.tolist()))
    turn = slow_errors.correct(slow, own, measured.gyro_rate, off, steps)
    own.attitude[:] = rotations.rotate_quaternion(own.attitude.tolist(), turn.tolist())


def _attitude_innovation(
    prepared: PreparedController, state: ControllerState, time: float, measured: Measurements
) -> Array:
    """Return the small rotation [rad] from the predicted to the measured attitude; the prediction moves to `attitude`.

    A first measurement that is far from it is the attitude at which the run begins: the estimate is set to it, and
    before a slew has begun the reference too.
    """
    state.attitude[:] = _turned(state.attitude, state.estimate)
    state.estimate[:3] = 0.0
    if not measured.star_tracker_valid:
        return np.zeros(3)
    seen = rotations.quaternion_from_mrp(measured.star_tracker_mrp.tolist())
    off = 4.0 * np.array(rotations.relative_mrp(seen, state.attitude.tolist()))
    first, state.captured = not state.captured, True
    if first and float(off @ off) > prepared.capture_angle**2:
        state.attitude[:] = seen
        start_from(prepared, state, time, seen)
        off[:] = 0.0
    elif first:
        x, y, z, w = state.origin.tolist()
        start_from(prepared, state, time, (x, y, z, w))
    return off


def _turned(attitude: Array, linear: Array) -> rotations.Quadruple:
    """Turn an attitude by the small rotation in a state of the linear model: four times its first three."""
    return rotations.rotate_quaternion(attitude.tolist(), [4.0 * part for part in linear[:3].tolist()])


def _jitter_ahead(prepared: PreparedController, measured: Measurements) -> Array:
    """Return the harmonic jitter, (4 n,), while the torque of this step will act."""
    ahead = prepared.measurement_delay + prepared.actuation_delay
    return jitter.harmonic(
        measured.encoder_speed,
        measured.encoder_angle + ahead * measured.encoder_speed,
        prepared.period,
        prepared.imbalance_force,
        prepared.imbalance_torque,
        np.empty((4, prepared.wheels)),
    ).ravel()


def _refer(prepared: PreparedController, state: ControllerState, time: float) -> rotations.Quadruple:
    """Write the reference at `time` and the feed-forward torque from then on; propagate the reference by a period.

    Returns the reference attitude, body from inertial.
    """
    period, profile, outputs = prepared.period, state.profile, state.outputs
    change = slew_motion.shaped_rate_change(profile, prepared.shaper, time, period)
    wheels, momentum_axis, torque = prepared.slew_wheels, prepared.inertia @ profile.axis, outputs.reference_torque
    torque[:] = share_of(wheels, profile.allocation, momentum_axis * (change / period))
    reference = outputs.reference
    if prepared.smoothed:
        now = np.array([time])
        rate = float(profile.rate(now)[0])
        modes = prepared.modes
        reference[:] = 0.0
        reference[:3] = 0.25 * float(profile.rotation(now)[0]) * profile.axis
        reference[3 + modes : 6 + modes] = rate * profile.axis
        reference[6 + 2 * modes :] = share_of(wheels, profile.allocation, momentum_axis * rate) / prepared.wheel_inertia
    else:
        reference[:] = state.reference
        state.reference[:] = prepared.reference_a @ reference + prepared.reference_b @ torque
        if prepared.gyroscopic and profile.angle > 0.0 and time < profile.end + float(prepared.shaper.shifts[0]):
            _follow_momentum(prepared, state, reference, torque)
    attitude = reference_attitude(state.origin, profile.axis, reference[:3])
    if prepared.linear_attitude:
        reference[:3] += rotations.mrp_from_quaternion(state.origin.tolist())
    else:
        reference[:3] = rotations.mrp_from_quaternion(attitude)
    return attitude


def _follow_momentum(prepared: PreparedController, state: ControllerState, reference: Array, torque: Array) -> None:
    """Add the torque that keeps a turning body from being turned by its momentum, and what it does to the wheels.

    Without it the wheels' momentum would stay in the body, while that of the whole stays in inertial space. The
    reference moves as if there were no gyroscopic terms: this torque takes their place, but for the wheels' speeds.
    It ends with the shaped torque; what the structure still swings then is left to the regulator.
    """
    m = prepared.modes
    rate, speed = reference[3 + m : 6 + m], reference[6 + 2 * m :]
    wheels = prepared.slew_wheels
    momentum = prepared.inertia @ rate + (prepared.wheel_inertia * (prepared.nominal_speed + speed)) @ wheels.axes
    added = share_of(wheels, state.profile.allocation, np.cross(rate, momentum))
    torque += added
    state.reference[6 + 2 * m :] += prepared.period * added / prepared.wheel_inertia


def _saturate(prepared: PreparedController, torque: Array, speed: Array) -> Array:
    """Limit to the motor, then to what leaves the speed band within a period (PHYSICS section 6).

    The null motion of the wheels has what these limits leave.
    """
    limit, band = prepared.torque_limit, prepared.speed_band
    scale = prepared.wheel_inertia / prepared.period
    limited = np.minimum(np.maximum(torque, -limit), limit)
    slowest, fastest = scale * (-band - speed), scale * (band - speed)
    limited = np.minimum(np.maximum(limited, slowest), fastest)
    if prepared.null_motion is None:
        return limited
    least, most = np.maximum(slowest, -limit) - limited, np.minimum(fastest, limit) - limited
    return limited + null_torque(prepared.null_motion, prepared.wheel_inertia * speed, least, most)
