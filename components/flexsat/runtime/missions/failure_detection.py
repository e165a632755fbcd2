"""Detect a wheel that does not follow its torque: the commanded torque against the encoder. numpy alone.

Each wheel has an observer of its speed, which integrates the commanded torque and follows the encoder slowly. A torque
d that is lost, or added by a bearing, leaves a residual of d T / J, T the observer's time constant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array, Flags, make_read_only

WORKS, OFF, SEIZED = 0, 1, 2  # of a wheel


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedDetection:
    """Numbers that no step changes."""

    enabled: bool
    wheel_inertia: Array  # (n,) [kg.m2]
    step: float  # s
    follow: float  # of the residual, in a step
    threshold: float  # rad/s
    persistence: int  # steps
    seized_speed: float  # rad/s: a wheel that has failed is seized below it

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(slots=True, kw_only=True)
class DetectionState:
    """What the detection remembers."""

    expected: Array  # (n,) [rad/s]
    before: Array  # (n,) [rad/s]: encoder at the last step
    beyond: Array  # (n,): steps in a row with a residual beyond the threshold
    status: Array  # (n,): WORKS, OFF or SEIZED
    given: Array  # (n,) [N.m]: what a wheel that does not work gives in truth
    residual: Array  # (n,) [rad/s]


def init(wheels: int) -> DetectionState:
    """Return the state before the first sample: all work."""
    return DetectionState(
        expected=np.zeros(wheels),
        before=np.zeros(wheels),
        beyond=np.zeros(wheels, np.int64),
        status=np.zeros(wheels, np.int64),
        given=np.zeros(wheels),
        residual=np.zeros(wheels),
    )


def step(prepared: PreparedDetection, state: DetectionState, first: bool, torque: Array, speed: Array) -> Flags:
    """Compare a sample of the encoders with the torque commanded since the last; return which wheels work, (n,).

    Parameters
    ----------
    first : no sample came before
    torque : (n,) [N.m] commanded over the last step
    speed : (n,) [rad/s] measured now
    """
    if first:
        state.expected[:] = state.before[:] = speed
    state.expected += prepared.step * torque / prepared.wheel_inertia
    state.residual[:] = speed - state.expected
    state.expected += prepared.follow * state.residual
    beyond = np.abs(state.residual) > prepared.threshold
    state.beyond[:] = np.where(beyond, state.beyond + 1, 0)
    if prepared.enabled:
        state.status[(state.beyond >= prepared.persistence) & (state.status == WORKS)] = OFF
    failed = state.status != WORKS
    state.status[failed] = np.where(np.abs(speed[failed]) < prepared.seized_speed, SEIZED, OFF)
    # a change of the measured speed below the threshold is noise, not a torque
    change = np.where(failed & (np.abs(speed - state.before) > prepared.threshold), speed - state.before, 0.0)
    state.given[:] = prepared.wheel_inertia * change / prepared.step
    state.before[:] = speed
    return np.asarray(~failed)
