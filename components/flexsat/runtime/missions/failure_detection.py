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
    braking_time: float  # s, in which a change of the speed of a failed wheel is taken for its torque

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(slots=True, kw_only=True)
class DetectionState:
    """What the detection remembers."""

    expected: Array  # (n,) [rad/s]
    answered: Array  # (n,) [rad/s]: speed of a failed wheel whose change the others have been given
    beyond: Array  # (n,): steps in a row with a residual beyond the threshold
    status: Array  # (n,): WORKS, OFF or SEIZED
    given: Array  # (n,) [N.m]: what a wheel that does not work gives in truth
    residual: Array  # (n,) [rad/s]


def init(wheels: int) -> DetectionState:
    """Return the state before the first sample: all work."""
    return DetectionState(
        expected=np.zeros(wheels),
        answered=np.zeros(wheels),
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
        state.expected[:] = speed
    state.expected += prepared.step * torque / prepared.wheel_inertia
    state.residual[:] = speed - state.expected
    works = state.status == WORKS
    state.answered[works] = state.expected[works]  # what a wheel has lost until it is found to have failed counts
    state.expected += prepared.follow * state.residual
    beyond = np.abs(state.residual) > prepared.threshold
    state.beyond[:] = np.where(beyond, state.beyond + 1, 0)
    if prepared.enabled:
        state.status[(state.beyond >= prepared.persistence) & works] = OFF
    failed = state.status != WORKS
    state.status[failed] = np.where(np.abs(speed[failed]) < prepared.seized_speed, SEIZED, OFF)
    # the momentum that it loses is given to the others, smoothed; less than the threshold is noise
    change = np.where(failed & (np.abs(speed - state.answered) > prepared.threshold), speed - state.answered, 0.0)
    state.given[:] = prepared.wheel_inertia * change / prepared.braking_time
    state.answered += prepared.step / prepared.braking_time * change
    return np.asarray(~failed)
