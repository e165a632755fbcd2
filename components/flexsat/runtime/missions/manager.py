"""Run-time mission manager between controller and wheels: modes, timeline, off-loading, failed wheels. numpy alone.

One step is one period of the controller. It reads the torque that the controller demands and the encoders, and gives
the wheels their torque: the demanded one, as long as all wheels work and no thruster fires.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array, Flags, make_read_only
from .. import rotations
from . import allocation, failure_detection, mode_logic, off_loading, thrusters
from .failure_detection import DetectionState, PreparedDetection
from .mode_logic import ModeState, PreparedModes, Seen
from .off_loading import OffLoadingState, PreparedOffLoading
from .thrusters import PreparedThrusters, ThrusterState

MOVING = 1e-8  # rad/s, of the reference: 0.002 arcsec/s


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedManager:
    """Numbers that no step changes."""

    axis: Array  # (n, 3)
    wheel_inertia: Array  # (n,) [kg.m2]
    torque_limit: Array  # (n,) [N.m]
    nominal_speed: Array  # (n,) [rad/s]
    speed_band: float  # rad/s
    modes: PreparedModes
    detection: PreparedDetection
    off_loading: PreparedOffLoading
    thrusters: PreparedThrusters  # as the manager knows them, without noise
    feed_forward: float  # share of the thrusters' torque that the wheels take at once
    step: float  # s
    inverse: Array  # (3, 3), as of allocation.inverse_of_axes, of all wheels
    forget: float  # of the hidden speeds, in a step

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(frozen=True, slots=True)
class ManagerInputs:
    """What the manager reads. A shell gives views that the master writes into."""

    torque: Array  # (n,) [N.m] demanded by the controller
    speed: Array  # (n,) [rad/s], encoders
    estimate: Array  # (3,) MRP
    reference: Array  # (3,) MRP
    reference_rate: Array  # (3,) [rad/s]
    reference_torque: Array  # (n,) [N.m]
    star_tracker_valid: Array  # (), a flag


@dataclass(slots=True, kw_only=True)
class ManagerState:
    """What the manager remembers, its outputs included."""

    count: int  # steps done
    modes: ModeState
    detection: DetectionState
    off_loading: OffLoadingState
    thrusters: ThrusterState
    inverse: Array  # (3, 3), as of allocation.inverse_of_axes
    lost_axis: bool
    owed: Array  # (3,) [N.m.s] of the body that the wheels left could not take from a failed one at once
    torque: Array  # (n,) [N.m] commanded
    applied: Array  # (n,) [N.m] for the controller's model
    hidden_speed: Array  # (n,) [rad/s] that the wheels began with or gained beside `applied`; slowly forgotten
    shown_speed: Array  # (n,) [rad/s]: encoders of the next step without it
    momentum: Array  # (3,) [N.m.s] of the wheels that work, beside that of their nominal speeds
    error: float  # rad


def init(prepared: PreparedManager) -> ManagerState:
    """Return the state before the first sample: all wheels work."""
    n = len(prepared.axis)
    return ManagerState(
        count=0,
        modes=mode_logic.init(prepared.modes),
        detection=failure_detection.init(n),
        off_loading=off_loading.init(len(prepared.off_loading.shares)),
        thrusters=thrusters.init(prepared.thrusters),
        inverse=prepared.inverse.copy(),
        lost_axis=False,
        owed=np.zeros(3),
        torque=np.zeros(n),
        applied=np.zeros(n),
        hidden_speed=np.zeros(n),
        shown_speed=prepared.nominal_speed.copy(),
        momentum=np.zeros(3),
        error=0.0,
    )


def step(prepared: PreparedManager, state: ManagerState, time: float, inputs: ManagerInputs) -> None:
    """Update the state in place, from a sample of the inputs at `time` [s]; what it gives holds from then on."""
    detection, unload = state.detection, state.off_loading
    known = detection.status.copy()
    works = failure_detection.step(prepared.detection, detection, state.count == 0, state.torque, inputs.speed)
    if np.any((known != 0) == works):
        inverse = allocation.inverse_of_axes(prepared.axis, works)
        state.lost_axis = inverse is None
        state.inverse[:] = 0.0 if inverse is None else inverse

    deviation = np.where(works, inputs.speed - prepared.nominal_speed, 0.0)
    state.momentum[:] = prepared.axis.T @ (prepared.wheel_inertia * deviation)
    state.error = pointing_error(inputs.estimate, inputs.reference)
    in_mode = state.modes.mode == mode_logic.OFF_LOAD
    began = mode_logic.step(
        prepared.modes,
        state.modes,
        time,
        Seen(
            star_tracker_valid=bool(inputs.star_tracker_valid),
            error=state.error,
            moving=bool(np.linalg.norm(inputs.reference_rate) > MOVING or np.any(inputs.reference_torque)),
            speed_share=float(np.abs(deviation).max()) / prepared.speed_band,
            off_loaded=in_mode and off_loading.is_done(prepared.off_loading, unload, time, state.momentum),
            lost_axis=state.lost_axis,
        ),
    )
    if began:
        off_loading.start_unloading(prepared.off_loading, unload, time)
    if state.thrusters.count % prepared.thrusters.steps == 0:
        if state.modes.mode == mode_logic.OFF_LOAD:
            off_loading.plan(prepared.off_loading, unload, time, state.momentum)
        else:
            off_loading.stop(unload)
    if state.count == 0:  # the controller's model begins at the nominal speeds
        state.hidden_speed[:] = deviation
    _command(prepared, state, works, inputs)
    state.count += 1


def _command(prepared: PreparedManager, state: ManagerState, works: Flags, inputs: ManagerInputs) -> None:
    """Write the torque of the wheels, and the torque and speed that the controller is to know.

    The controller is shown wheels that all work and that no thruster touches: torques that give the body what the real
    ones give, less the answer to the thrusters, and the speeds that follow from these torques. What its filter knows
    is true of the attitude then, and its commands stay within the wheels that it knows.
    """
    thrust = thrusters.step(prepared.thrusters, state.thrusters, state.off_loading.command)
    outside = prepared.feed_forward * (prepared.thrusters.wrench[3:] @ thrust)
    axis, limit, given = prepared.axis, prepared.torque_limit, state.detection.given
    demanded = np.clip(inputs.torque, -limit, limit)
    torque = demanded
    if not np.all(works):
        wanted = axis.T @ np.where(works, 0.0, demanded - given) + state.owed / prepared.step
        torque = np.where(works, demanded + axis @ (state.inverse @ wanted), given)
        delivered = np.where(works, np.clip(torque, -limit, limit), 0.0)
        # what the controller demands at the same time counts too: it brakes the same motion
        left = np.clip(wanted - axis.T @ delivered, np.minimum(wanted, 0.0), np.maximum(wanted, 0.0))
        state.owed[:] = prepared.step * left if np.any(works & (delivered != torque)) else 0.0
    taken = np.where(works, axis @ (state.inverse @ outside), 0.0)
    state.torque[:] = np.where(works, np.clip(torque + taken, -limit, limit), 0.0)
    less = demanded - np.where(works, state.torque - taken, given)
    state.applied[:] = demanded - axis @ (prepared.inverse @ (axis.T @ less))
    gain = prepared.step / prepared.wheel_inertia
    state.shown_speed[:] = np.where(works, inputs.speed - state.hidden_speed, state.shown_speed) + gain * state.applied
    state.hidden_speed[:] = prepared.forget * (state.hidden_speed + gain * (state.torque - state.applied))


def pointing_error(estimate: Array, reference: Array) -> float:
    """Return the angle [rad] between two attitudes given as MRPs (3,), for small ones."""
    attitude = rotations.quaternion_from_mrp(estimate.tolist())
    base = rotations.quaternion_from_mrp(reference.tolist())
    return 4.0 * float(np.linalg.norm(rotations.relative_mrp(attitude, base)))
