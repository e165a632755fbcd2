"""Run-time LQG flight controller: periodic Kalman filter, slew reference, regulator, saturation, known delays.

numpy alone. One step is one period (5 ms): it reads the measurements on its inputs, and its torque holds from then on.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from . import slew_guidance as guidance
from . import wheel_jitter as jitter
from .named_state import NOT_SAVED
from .prepared_controller import PreparedController, plan_slew, prepare

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


@dataclass(slots=True, kw_only=True)
class ControllerState:
    """What the controller remembers between steps, and the outputs that a step writes; `step` works in place."""

    estimate: Array  # (s,) at the time of the last measurement
    history: Array  # (q + 2, n): torques commanded, by this or the controller in control, the latest first [N.m]
    jitter: Array  # (4, n): harmonic jitter expected over the coming period
    since_star_tracker: int  # steps
    count: int  # steps done
    held: int  # calls since the last step, itself included, where there are several calls to a period
    reference: Array  # (r,)
    profile: guidance.Profile
    outputs: ControllerOutputs = field(metadata=NOT_SAVED)


def init(prepared: PreparedController, rotation: Array, start: float) -> ControllerState:
    """Return the state at the start of a run, at rest at the nominal wheel speeds, with a slew planned."""
    s, n, r = prepared.states, prepared.wheels, prepared.controlled
    return ControllerState(
        estimate=np.zeros(s),
        history=np.zeros((prepared.whole_delay + 2, n)),
        jitter=np.zeros((4, n)),
        since_star_tracker=prepared.phases - 1,
        count=0,
        held=0,
        reference=np.zeros(r),
        profile=plan_slew(prepared, rotation, start),
        outputs=ControllerOutputs(
            torque=np.zeros(n),
            estimate=np.zeros(s),
            reference=np.zeros(r),
            reference_torque=np.zeros(n),
            innovation=np.zeros(len(prepared.c)),
        ),
    )


def command(prepared: PreparedController, state: ControllerState, time: float, rotation: Array, start: float) -> None:
    """Accept a new slew command; raise ValueError if the planned slew has already begun."""
    old = state.profile
    if old.start == start and np.array_equal(old.axis * old.angle, rotation):
        return
    if old.angle > 0.0 and time >= old.start - prepared.shaper.shifts[0]:
        raise ValueError(f"command.rotation changed at {time:.3f} s, after the slew of {old.start:.3f} s had begun")
    state.profile = plan_slew(prepared, rotation, start)


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
        _correct(prepared, state, measured)
    else:
        outputs.innovation[:] = 0.0

    r = prepared.controlled
    expected = state.estimate[:r]
    if prepared.delayed:
        expected = prepared.ahead @ np.concatenate([state.estimate, history.ravel()])
    _refer(prepared, state, time + prepared.actuation_delay)
    torque = outputs.reference_torque - prepared.feedback @ (expected - outputs.reference)
    if prepared.cancels_jitter and state.count >= prepared.first_measurement:
        torque += prepared.jitter_torque @ _jitter_ahead(prepared, measured)
    outputs.torque[:] = _saturate(prepared, torque, expected[r - prepared.wheels :])
    if prepared.open_loop:
        outputs.torque[:] = 0.0
    outputs.estimate[:] = state.estimate
    history[1:] = history[:-1].copy()
    history[0] = outputs.torque
    state.count += 1
    return outputs


def _correct(prepared: PreparedController, state: ControllerState, measured: Measurements) -> None:
    """Predict the estimate to the time of the measurement and correct it; predict the jitter of the next period."""
    if state.count > prepared.first_measurement:
        stack = np.concatenate([state.estimate, state.history.ravel(), state.jitter.ravel()])
        np.matmul(prepared.predict, stack, out=state.estimate)
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


def _refer(prepared: PreparedController, state: ControllerState, time: float) -> None:
    """Write the reference at `time` and the feed-forward torque from then on; propagate the reference by a period."""
    period, profile, outputs = prepared.period, state.profile, state.outputs
    change = guidance.shaped_rate_change(profile, prepared.shaper, time, period)
    momentum_axis = prepared.inertia @ profile.axis
    torque = np.matmul(prepared.distribution, momentum_axis * (change / period), out=outputs.reference_torque)
    reference = outputs.reference
    if prepared.smoothed:
        now = np.array([time])
        rate = float(profile.rate(now)[0])
        modes = prepared.modes
        reference[:] = 0.0
        reference[:3] = 0.25 * float(profile.rotation(now)[0]) * profile.axis
        reference[3 + modes : 6 + modes] = rate * profile.axis
        reference[6 + 2 * modes :] = prepared.distribution @ (momentum_axis * rate) / prepared.wheel_inertia
    else:
        reference[:] = state.reference
        state.reference[:] = prepared.reference_a @ reference + prepared.reference_b @ torque


def _saturate(prepared: PreparedController, torque: Array, speed: Array) -> Array:
    """Limit to the motor, then to what leaves the speed band within a period (PHYSICS section 6)."""
    limit, band = prepared.torque_limit, prepared.speed_band
    scale = prepared.wheel_inertia / prepared.period
    limited = np.minimum(np.maximum(torque, -limit), limit)
    return np.minimum(np.maximum(limited, scale * (-band - speed)), scale * (band - speed))
