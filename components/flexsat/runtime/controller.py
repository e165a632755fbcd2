"""Run-time LQG flight controller: periodic Kalman filter, slew reference, regulator, saturation, known delays.

numpy alone. One step is one period (5 ms): it takes the measurements that are on its inputs, and its torque holds
from then on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from . import slew_guidance as guidance
from . import wheel_jitter as jitter
from .zero_order_hold import zero_order_hold


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerMatrices:
    """The design that travels to run time. State: p, eta, w, eta', wheel speed less nominal, filter (2 k)."""

    a: Array  # (s, s), continuous [1/s in the states' units]
    b_torque: Array  # (s, n)
    b_jitter: Array  # (s, 4 n)
    c: Array  # (y, s): gyro, accelerometer, encoder, star tracker
    gain_coarse: Array  # (phases, s, y): Kalman gain with the star tracker
    gain_fine: Array  # (phases, s, y): with the fine guidance sensor
    feedback: Array  # (n, r): on the first r states, those without the filter
    reference_a: Array  # (r, r), continuous, without gyroscopic terms
    reference_b: Array  # (r, n)
    nominal_speed: Array  # (n,) [rad/s]
    wheel_axis: Array  # (n, 3)
    wheel_inertia: float  # kg.m2
    inertia: Array  # (3, 3) [kg.m2]
    modes: int
    period: float  # s, that the gains were designed for
    shaper_frequency: float  # rad/s
    shaper_damping: float
    gyros: int
    accelerometers: int
    torque_limit: float  # N.m, these four: nominal values of the parameters of the same names
    speed_band: float  # rad/s
    imbalance_force: float  # N.s2
    imbalance_torque: float  # N.m.s2


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerParameters:
    """Parameters of one run."""

    period: float  # s
    fine_sensor: bool
    feed_forward_jitter: bool
    smoothed: bool  # slew reference: smoothed instead of time-optimal
    open_loop: bool  # estimates, but commands no torque
    torque_limit: float  # N.m
    speed_band: float  # rad/s either side of nominal
    authority: float  # share of torque and speed band that the slew may use
    measurement_delay: float  # s, from sampling to the call that uses it; known, whole milliseconds up to 20 ms
    actuation_delay: float  # s, from the call to when the torque acts
    imbalance_force: float  # N.s2
    imbalance_torque: float  # N.m.s2

    def __post_init__(self) -> None:
        # named as the ports are: the messages reach those who set them
        for name, value in (("wheel.torque_limit", self.torque_limit), ("wheel.speed_band", self.speed_band)):
            if not value > 0.0:
                raise ValueError(f"{name} must be > 0, got {value!r}")
        if not 0.0 < self.authority <= 1.0:
            raise ValueError(f"slew.authority must be in (0, 1], got {self.authority!r}")
        for name, value in (("delay.measurement", self.measurement_delay), ("delay.actuation", self.actuation_delay)):
            if not 0.0 <= value <= 0.020 or abs(value * 1e3 - round(value * 1e3)) > 1e-6:
                raise ValueError(f"{name} must be whole milliseconds from 0 to 0.020 s, got {value!r}")


@dataclass(frozen=True, slots=True)
class Measurements:
    """What the sensors give."""

    gyro_rate: Array  # (g,) [rad/s]
    accelerometer: Array  # (k,) [m/s2]
    encoder_speed: Array  # (n,) [rad/s]
    encoder_angle: Array  # (n,) [rad]
    star_tracker_mrp: Array  # (3,)
    star_tracker_valid: bool | NDArray[np.bool_]  # a new sample; a shell gives a view, shape ()
    applied_torque: Array | None = None  # (n,) [N.m], commanded in the step before by whoever was in control
    applied_valid: bool | NDArray[np.bool_] = False  # applied_torque is given; else it was our own


@dataclass(slots=True)
class ControllerState:
    """Everything the controller remembers between steps."""

    estimate: Array  # (s,) at the time of the last measurement
    history: Array  # (q + 1, n): torques commanded, by us or whoever was in control, the latest first [N.m]
    jitter: Array  # (4, n): harmonic jitter expected over the coming period
    since_star_tracker: int  # steps
    count: int  # steps done
    reference: Array  # (r,)
    profile: guidance.Profile


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerOutputs:
    """Hold from the sampling time on. `estimate` and `reference` are those the torque was made from.

    `innovation` is what was measured less what was predicted, in the order of the linear model's outputs; the star
    tracker's three say something only when its sample was valid.
    """

    torque: Array  # (n,) [N.m]
    estimate: Array  # (s,)
    reference: Array  # (r,)
    reference_torque: Array  # (n,) [N.m]
    innovation: Array  # (y,)

    @classmethod
    def at_rest(cls, controller: Controller) -> ControllerOutputs:
        """Return what the outputs show before the first step: zeros."""
        torque, reference = np.zeros(controller.wheels), np.zeros(controller.controlled)
        return cls(
            torque=torque,
            estimate=np.zeros(controller.states),
            reference=reference,
            reference_torque=torque,
            innovation=controller.no_innovation,
        )


class Controller:
    """The design sampled at the period, for the known delays."""

    def __init__(self, matrices: ControllerMatrices, parameters: ControllerParameters) -> None:
        """Sample the models; raise ValueError if the matrices were designed for another period."""
        self.matrices, self.parameters = matrices, parameters
        s, n = matrices.b_torque.shape
        self.states, self.wheels, self.controlled = s, n, matrices.feedback.shape[1]
        period = parameters.period
        self.gain = matrices.gain_fine if parameters.fine_sensor else matrices.gain_coarse
        self.phases = len(self.gain)
        self.no_innovation = np.zeros(len(matrices.c))

        # a torque commanded at t acts from t + delay on, seen from the time of the measurement
        delay = parameters.measurement_delay + parameters.actuation_delay
        whole = int(np.floor(delay / period + 1e-6))
        part = max(0.0, delay - whole * period)
        if part < 1e-9:
            part = 0.0
        self.whole_delay = whole
        a, b_jitter = zero_order_hold(matrices.a, matrices.b_jitter, period)
        early, late = _split_hold(matrices.a, matrices.b_torque, period, part)
        # over one period the torques at work are history[whole] and, until `part`, history[whole + 1]
        inputs = np.zeros((s, (whole + 2) * n))
        inputs[:, whole * n : (whole + 1) * n] = late
        inputs[:, (whole + 1) * n :] = early
        self.predict = np.ascontiguousarray(np.hstack([a, inputs, b_jitter]))
        self.correct_at = max(0, int(np.ceil(parameters.measurement_delay / period - 1e-6)))

        ahead = np.eye(s, s + (whole + 2) * n)
        for k in range(whole, 0, -1):  # each whole period, with the torques then at work
            shift = np.zeros((s, (whole + 2) * n))
            shift[:, (k - 1) * n : k * n] = late
            shift[:, k * n : (k + 1) * n] = early
            ahead = a @ ahead
            ahead[:, s:] += shift
        if part > 0.0:
            a_part, b_part = zero_order_hold(matrices.a, matrices.b_torque, part)
            ahead = a_part @ ahead
            ahead[:, s : s + n] += b_part
        self.ahead = np.ascontiguousarray(ahead[: self.controlled]) if delay > 0.0 else None

        self.reference_a, self.reference_b = zero_order_hold(matrices.reference_a, matrices.reference_b, period)
        self.distribution = -np.linalg.pinv(matrices.wheel_axis.T)  # wheel torques of a body torque
        capability = np.sum(np.abs(matrices.wheel_axis), axis=0) * parameters.authority
        self.body_torque = capability * parameters.torque_limit
        self.body_momentum = capability * matrices.wheel_inertia * parameters.speed_band
        self.shaper = guidance.shaper_for_pole(matrices.shaper_frequency, matrices.shaper_damping, period)

    def plan(self, rotation: Array, start: float) -> guidance.Profile:
        """Plan the slew for a rotation vector [rad] from `start` [s], as this controller is limited.

        Raises
        ------
        ValueError
            If the shaped torque would have to begin before the run, or before the first measurement can count it.
        """
        profile = guidance.plan(rotation, start, self.matrices.inertia, self.body_torque, self.body_momentum)
        p = self.parameters
        earliest = float(self.shaper.shifts[0]) + p.measurement_delay + p.actuation_delay
        if profile.angle > 0.0 and start < earliest:
            raise ValueError(
                f"command.start_time = {start:g} s must be >= {earliest:g} s: the shaped torque begins before the slew"
            )
        return profile


def _split_hold(a: Array, b: Array, period: float, part: float) -> tuple[Array, Array]:
    """Return the input matrices over a period for an input that changes after `part`: before, after."""
    if part == 0.0:
        return np.zeros_like(b), zero_order_hold(a, b, period)[1]
    rest, late = zero_order_hold(a, b, period - part)
    return rest @ zero_order_hold(a, b, part)[1], late


def init(controller: Controller, rotation: Array, start: float) -> ControllerState:
    """Return the state at the start of a run, at rest at the nominal wheel speeds, with a slew planned."""
    n = controller.wheels
    return ControllerState(
        estimate=np.zeros(controller.states),
        history=np.zeros((controller.whole_delay + 2, n)),
        jitter=np.zeros((4, n)),
        since_star_tracker=controller.phases - 1,
        count=0,
        reference=np.zeros(controller.controlled),
        profile=controller.plan(rotation, start),
    )


def command(controller: Controller, state: ControllerState, time: float, rotation: Array, start: float) -> None:
    """Take over a new slew command; raise ValueError if the planned one has already begun."""
    old = state.profile
    if old.start == start and np.array_equal(old.axis * old.angle, rotation):
        return
    if old.angle > 0.0 and time >= old.start - controller.shaper.shifts[0]:
        raise ValueError(f"command.rotation changed at {time:.3f} s, after the slew of {old.start:.3f} s had begun")
    state.profile = controller.plan(rotation, start)


def step(
    controller: Controller, state: ControllerState, time: float, measured: Measurements
) -> tuple[ControllerState, ControllerOutputs]:
    """Correct the estimate with what was measured, and command the torque.

    Parameters
    ----------
    controller : the sampled design
    state : updated in place
    time : of this call [s]; the reference is taken when the torque will act
    measured : on the inputs now, that is, made `measurement_delay` ago

    Source: P, section 6; the delays are ours (PHYSICS section 6).
    """
    matrices, parameters = controller.matrices, controller.parameters
    history, innovation = state.history, controller.no_innovation
    if measured.applied_valid and measured.applied_torque is not None and state.count:
        history[0] = measured.applied_torque
    if state.count >= controller.correct_at:
        if state.count > controller.correct_at:
            stack = np.concatenate([state.estimate, history.ravel(), state.jitter.ravel()])
            state.estimate = controller.predict @ stack
        state.since_star_tracker = 0 if measured.star_tracker_valid else state.since_star_tracker + 1
        phase = min(state.since_star_tracker, controller.phases - 1)
        innovation = np.concatenate(
            [
                measured.gyro_rate,
                measured.accelerometer,
                measured.encoder_speed - matrices.nominal_speed,
                4.0 * measured.star_tracker_mrp,
            ]
        )
        innovation -= matrices.c @ state.estimate
        state.estimate += controller.gain[phase] @ innovation
        if parameters.feed_forward_jitter:
            jitter.harmonic(
                measured.encoder_speed,
                measured.encoder_angle,
                parameters.period,
                parameters.imbalance_force,
                parameters.imbalance_torque,
                state.jitter,
            )

    r = controller.controlled
    if controller.ahead is None:
        expected = state.estimate[:r]
    else:
        expected = controller.ahead @ np.concatenate([state.estimate, history.ravel()])
    reference, reference_torque = _refer(controller, state, time + parameters.actuation_delay)
    torque = reference_torque - matrices.feedback @ (expected - reference)
    torque = _saturate(controller, torque, expected[r - controller.wheels :])
    if parameters.open_loop:
        torque = np.zeros_like(torque)
    history[1:] = history[:-1].copy()
    history[0] = torque
    state.count += 1
    return state, ControllerOutputs(
        torque=torque,
        estimate=state.estimate.copy(),
        reference=reference,
        reference_torque=reference_torque,
        innovation=innovation,
    )


def _refer(controller: Controller, state: ControllerState, time: float) -> tuple[Array, Array]:
    """Return the reference at `time` and the feed-forward torque from then on; roll the reference forward."""
    matrices, period, profile = controller.matrices, controller.parameters.period, state.profile
    change = guidance.shaped_rate_change(profile, controller.shaper, time, period)
    momentum_axis = matrices.inertia @ profile.axis
    torque = controller.distribution @ (momentum_axis * (change / period))
    reference = state.reference
    if controller.parameters.smoothed:
        now = np.array([time])
        rate = float(profile.rate(now)[0])
        reference = np.zeros(controller.controlled)
        modes = matrices.modes
        reference[:3] = 0.25 * float(profile.rotation(now)[0]) * profile.axis
        reference[3 + modes : 6 + modes] = rate * profile.axis
        reference[6 + 2 * modes :] = controller.distribution @ (momentum_axis * rate) / matrices.wheel_inertia
    else:
        state.reference = controller.reference_a @ reference + controller.reference_b @ torque
    return reference, torque


def _saturate(controller: Controller, torque: Array, speed: Array) -> Array:
    """Limit to the motor, then to what leaves the speed band within a period (PHYSICS section 6)."""
    p, inertia = controller.parameters, controller.matrices.wheel_inertia
    scale = inertia / p.period
    limited = np.minimum(np.maximum(torque, -p.torque_limit), p.torque_limit)
    return np.minimum(np.maximum(limited, scale * (-p.speed_band - speed)), scale * (p.speed_band - speed))
