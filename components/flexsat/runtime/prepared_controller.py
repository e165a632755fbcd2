"""Prepare the controller for one run: its design sampled at the period, for the known delays. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..allocation import NullMotion, null_motion
from ..arrays import Array, make_read_only
from ..fixed_order import inverse, product
from ..slow_errors import PreparedSlowErrors
from . import slew_guidance as guidance
from . import slew_motion, slew_optimum
from .controller_parameters import ControllerMatrices, ControllerParameters
from .keep_out import KeepOut, plan_legs
from .zero_order_hold import zero_order_hold

BRAKED = 4  # knots more than those of a profile: where it is braked, and where it stops; and two to spare
LEAST_REMAINING = 1.01  # of the angle of braking: below it the programme has no room


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedController:
    """Arrays and numbers that no step changes; states of several runs may share them."""

    period: float  # s
    states: int
    wheels: int
    controlled: int  # the first states, without those of the filter
    modes: int
    gyros: int
    phases: int  # of the gain: periods between two samples of the star tracker
    whole_delay: int  # whole periods of both delays together
    first_measurement: int  # step that uses the first one
    delayed: bool
    smoothed: bool
    knots: int  # of a planned motion
    optimal: bool  # slews are planned by the quadratic programme
    replans: bool  # a command during a slew replaces it
    linear_attitude: bool
    capture_angle: float  # rad
    open_loop: bool
    feed_forward_jitter: bool
    measurement_delay: float  # s
    actuation_delay: float  # s
    torque_limit: Array  # (n,) [N.m]
    speed_band: Array  # (n,) [rad/s]
    imbalance_force: Array  # (n,) [N.s2/rad2]
    imbalance_torque: Array  # (n,) [N.m.s2/rad2]
    wheel_inertia: Array  # (n,) [kg.m2]
    inertia: Array  # (3, 3) [kg.m2]
    nominal_speed: Array  # (n,) [rad/s]
    c: Array  # (y, s)
    gain: Array  # (phases, s, y)
    feedback: Array  # (n, r)
    jitter_torque: Array  # (n, 4 n): torque against the harmonic jitter
    cancels_jitter: bool
    predict: Array  # (s, s + (q + 2) n + 4 n): over a period, from estimate, torque history and jitter
    ahead: Array  # (r, s + (q + 2) n): to the time at which the torque acts, from estimate and torque history
    reference_a: Array  # (r, r)
    reference_b: Array  # (r, n)
    gyroscopic: bool  # of the feed-forward of slews
    slew_wheels: guidance.Wheels  # what each wheel may give to a slew
    shaper: guidance.Shaper
    keep_out: KeepOut
    null_motion: NullMotion | None  # None: the regulator alone moves wheels against each other
    slow: PreparedSlowErrors | None  # None: no torque on the body and no gyro bias is estimated

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare(matrices: ControllerMatrices, parameters: ControllerParameters) -> PreparedController:
    """Sample the models of a design for the delays of a run."""
    s, n = matrices.b_torque.shape
    controlled = matrices.feedback.shape[1]
    period = parameters.period
    gain = matrices.gain_fine if parameters.fine_sensor else matrices.gain_coarse

    # a torque commanded at t acts from t + delay on, seen from the time of the measurement
    delay = parameters.measurement_delay + parameters.actuation_delay
    whole = int(np.floor(delay / period + 1e-6))
    part = max(0.0, delay - whole * period)
    if part < 1e-9:
        part = 0.0
    a, b_jitter = zero_order_hold(matrices.a, matrices.b_jitter, period)
    early, late = _split_hold(matrices.a, matrices.b_torque, period, part)
    # over one period the torques at work are history[whole] and, until `part`, history[whole + 1]
    inputs = np.zeros((s, (whole + 2) * n))
    inputs[:, whole * n : (whole + 1) * n] = late
    inputs[:, (whole + 1) * n :] = early

    ahead = np.eye(s, s + (whole + 2) * n)
    for k in range(whole, 0, -1):  # each whole period, with the torques then at work
        shift = np.zeros((s, (whole + 2) * n))
        shift[:, (k - 1) * n : k * n] = late
        shift[:, k * n : (k + 1) * n] = early
        ahead = product(a, ahead)
        ahead[:, s:] += shift
    if part > 0.0:
        a_part, b_part = zero_order_hold(matrices.a, matrices.b_torque, part)
        ahead = product(a_part, ahead)
        ahead[:, s : s + n] += b_part

    reference_a, reference_b = zero_order_hold(matrices.reference_a, matrices.reference_b, period)
    torque_limit = parameters.torque_limit * (np.ones(n) * parameters.torque_factor)
    speed_band = parameters.speed_band * (np.ones(n) * parameters.band_factor)
    slew_wheels = guidance.wheels_for(
        matrices.wheel_axis,
        parameters.authority * torque_limit,
        parameters.authority * matrices.wheel_inertia * speed_band,
        matrices.wheel_inertia * (np.ones(n) * parameters.speed_offset),
        parameters.least_peak,
    )
    return PreparedController(
        period=period,
        states=s,
        wheels=n,
        controlled=controlled,
        modes=matrices.modes,
        gyros=matrices.gyros,
        phases=len(gain),
        whole_delay=whole,
        first_measurement=max(0, int(np.ceil(parameters.measurement_delay / period - 1e-6))),
        delayed=delay > 0.0,
        smoothed=parameters.smoothed or parameters.guidance == "smoothed",
        knots=BRAKED + (2 * (slew_optimum.STEPS + 1) if parameters.guidance == "qp" else 4),
        optimal=parameters.guidance == "qp",
        replans=parameters.during_slew == "replan",
        linear_attitude=parameters.linear_attitude,
        capture_angle=parameters.capture_angle,
        open_loop=parameters.open_loop,
        feed_forward_jitter=parameters.feed_forward_jitter,
        measurement_delay=parameters.measurement_delay,
        actuation_delay=parameters.actuation_delay,
        torque_limit=torque_limit,
        speed_band=speed_band,
        imbalance_force=np.ones(n) * parameters.imbalance_force,
        imbalance_torque=np.ones(n) * parameters.imbalance_torque,
        wheel_inertia=matrices.wheel_inertia,
        inertia=matrices.inertia,
        nominal_speed=matrices.nominal_speed,
        c=matrices.c,
        gain=gain,
        feedback=_feedback(matrices, parameters),
        jitter_torque=matrices.jitter_torque,
        cancels_jitter=parameters.feed_forward_jitter and bool(matrices.jitter_torque.any()),
        predict=np.ascontiguousarray(np.hstack([a, inputs, b_jitter])),
        ahead=np.ascontiguousarray(ahead[:controlled]),
        reference_a=reference_a,
        reference_b=reference_b,
        gyroscopic=parameters.gyroscopic,
        slew_wheels=slew_wheels,
        shaper=guidance.shaper_for_pole(matrices.shaper_frequency, matrices.shaper_damping, period),
        keep_out=parameters.keep_out,
        null_motion=None
        if parameters.null_rate == 0.0
        else null_motion(
            matrices.wheel_axis, matrices.wheel_inertia * speed_band, torque_limit > 0.0, parameters.null_rate
        ),
        slow=_slow_errors(matrices, parameters, slew_wheels.allocations[0], part),
    )


def _feedback(matrices: ControllerMatrices, parameters: ControllerParameters) -> Array:
    """Return the gain, (n, r): it sees wheel speeds where they give no momentum alone, which null motion replaces."""
    if parameters.null_rate == 0.0:
        return matrices.feedback
    feedback = matrices.feedback.copy()
    feedback[:, 6 + 2 * matrices.modes :] = 0.0
    return feedback


def choice_of(parameters: ControllerParameters) -> int | None:
    """Return which filter of slow errors the parameters choose: 0 of the torque, 1 of biases, 2 of both; or None."""
    if not (parameters.estimates_torque or parameters.estimates_bias):
        return None
    return int(parameters.estimates_bias) + int(parameters.estimates_torque and parameters.estimates_bias)


def _slow_errors(
    matrices: ControllerMatrices, parameters: ControllerParameters, allocation: Array, part: float
) -> PreparedSlowErrors | None:
    """Return the filter of slow errors that the parameters choose; None for none.

    Parameters
    ----------
    allocation : (n, 3) of a body torque among the wheels, as of `slew_guidance.allocation`
    part : of the period, at whose end a new torque begins to act [s]

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


def _split_hold(a: Array, b: Array, period: float, part: float) -> tuple[Array, Array]:
    """Return the input matrices over a period for an input that changes after `part`: before, after."""
    if part == 0.0:
        return np.zeros_like(b), zero_order_hold(a, b, period)[1]
    rest, late = zero_order_hold(a, b, period - part)
    return product(rest, zero_order_hold(a, b, part)[1]), late


def plan_slew(prepared: PreparedController, rotation: Array, start: float) -> guidance.Profile:
    """Plan the slew for a rotation vector [rad] from `start` [s], within the limits of this controller.

    Raises
    ------
    ValueError
        If the shaped torque would have to begin before the run, or before the first measurement can count it.
    """
    profile, _ = _profile(prepared, rotation, start)
    check_start(prepared, profile.angle, start)
    return profile


def _profile(prepared: PreparedController, rotation: Array, start: float) -> tuple[guidance.Profile, int]:
    """Return the quickest profile of a rotation vector [rad], and which allocation of the torque it needs."""
    axis, angle = guidance.axis_of(rotation)
    accelerations, rates = guidance.limits_about(prepared.slew_wheels, (prepared.inertia @ axis)[:, np.newaxis])
    times = guidance.durations(np.full(accelerations.shape, angle), accelerations, rates)
    chosen = int(np.argmin(times[:, 0]))
    return guidance.trapezium(axis, angle, start, float(accelerations[chosen, 0]), float(rates[chosen, 0])), chosen


def check_start(prepared: PreparedController, angle: float, start: float) -> None:
    """Refuse a slew that cannot begin as commanded at the start of a run; a slew of no angle is none.

    Raises
    ------
    ValueError
        If the shaped torque would have to begin before the run, or before the first measurement can count it.
    """
    earliest = float(prepared.shaper.shifts[0]) + prepared.measurement_delay + prepared.actuation_delay
    if angle > 0.0 and start < earliest:
        raise ValueError(
            f"command.start_time = {start:g} s must be >= {earliest:g} s: the shaped torque begins before the slew"
        )


def plan_motion(prepared: PreparedController, rotation: Array, start: float) -> slew_motion.Motion:
    """Plan the motion for a rotation vector [rad] from `start` [s] on, from rest; raise ValueError if there is none."""
    profile, allocation = _profile(prepared, rotation, start)
    if profile.angle == 0.0:
        return slew_motion.still(prepared.knots, start)
    sampling = prepared.knots, prepared.period, prepared.actuation_delay
    if not prepared.optimal:
        return slew_motion.from_profile(profile, *sampling, allocation)
    times = slew_optimum.time_grid(profile.end - start, profile.ramp)
    acceleration, rate = limits_of(prepared, profile.axis, allocation)
    rates = slew_optimum.optimal_rates(profile.angle, acceleration, rate, times)
    return slew_motion.from_knots(profile, start + times, rates, *sampling, allocation)


def limits_of(prepared: PreparedController, axis: Array, allocation: int) -> tuple[float, float]:
    """Return the greatest acceleration [rad/s2] and rate [rad/s] of a slew about an axis."""
    limits = guidance.limits_about(prepared.slew_wheels, (prepared.inertia @ axis)[:, np.newaxis])
    return float(limits[0][allocation, 0]), float(limits[1][allocation, 0])


def wheel_momentum(prepared: PreparedController, motion: slew_motion.Motion) -> Array:
    """Return the momentum (n,) [N.m.s] that each wheel gains for each rad/s of a motion's rate."""
    return guidance.share_of(prepared.slew_wheels, motion.allocation, prepared.inertia @ motion.axis)


def plan_turns(prepared: PreparedController, attitude: Array, rotation: Array) -> Array:
    """Return the turns, (LEGS, 3) [rad], of a slew from an attitude (4,): one, or several round the keep-out cones.

    Raises
    ------
    ValueError
        If the slew begins or ends within a cone, or no chain of turns leads round the cones.
    """
    return plan_legs(prepared.keep_out, attitude, rotation, lambda turns: durations_of(prepared, turns))


def durations_of(prepared: PreparedController, turns: Array) -> Array:
    """Return how long turns by rotation vectors (m, 3) [rad] take [s], with the pause after each; 0 for no turn."""
    angles = np.linalg.norm(turns, axis=1)
    axes = turns / np.where(angles > 0.0, angles, 1.0)[:, np.newaxis]
    axes[angles == 0.0, 0] = 1.0
    accelerations, rates = guidance.limits_about(prepared.slew_wheels, prepared.inertia @ axes.T)
    times = guidance.durations(np.broadcast_to(angles, accelerations.shape), accelerations, rates).min(axis=0)
    return np.asarray((times + (slew_optimum.TAIL if prepared.optimal else 0.0) + pause(prepared)) * (angles > 0.0))


def pause(prepared: PreparedController) -> float:
    """Return the shortest time between two slews [s]: for the shaped torque of both."""
    return 2.0 * float(prepared.shaper.shifts[0]) + prepared.period


def braked(prepared: PreparedController, motion: slew_motion.Motion, time: float) -> slew_motion.Motion:
    """Return a motion in flight braked from a sample at `time` [s] on."""
    deceleration, _ = limits_of(prepared, motion.axis, motion.allocation)
    sampling = prepared.period, prepared.actuation_delay
    return slew_motion.stopped(motion, time, deceleration, *sampling, _memory(prepared))


def turned_on(
    prepared: PreparedController, motion: slew_motion.Motion, time: float, angle: float
) -> slew_motion.Motion | None:
    """Return a motion in flight that turns on to another angle [rad], by the programme from the rate at `time` [s].

    None if it cannot: the angle lies behind, or before the end of braking, or the programme has no optimum.
    """
    at = np.array([time])
    rate, remaining = float(motion.rate(at)[0]), angle - float(motion.rotation(at)[0])
    acceleration, most = limits_of(prepared, motion.axis, motion.allocation)
    if remaining <= 0.0 or remaining * acceleration < LEAST_REMAINING * 0.5 * rate**2:
        return None
    duration = guidance.remaining_duration(remaining, acceleration, most, rate)
    since = slew_optimum.time_grid(duration, most / acceleration)
    try:
        rates = slew_optimum.optimal_rates(remaining, acceleration, most, since, rate)
    except ValueError:
        return None
    sampling = prepared.period, prepared.actuation_delay
    return slew_motion.continued(motion, time, since, rates, angle, *sampling, _memory(prepared))


def _memory(prepared: PreparedController) -> float:
    """Return how long a motion that was changed is still needed as it was [s]: for all taps of the shaper."""
    return 2.0 * float(prepared.shaper.shifts[0]) + 3.0 * prepared.period
