"""Bring wheels back to their nominal speeds with thrusters, while the wheels hold the attitude. numpy alone.

The momentum of the wheels beside that of their nominal speeds, h, goes to the outside: the thrusters give a torque T
with the integral -h, and the wheels give the same torque to the body with the other sign, so that the attitude stays.
T is the optimum of the quadratic programme

    minimise  sum |T_k|^2   such that   sum T_k P = -h,   |T_k| <= T_max,

over the periods of P s that are left: the constant -h / (time left), cut to what the thrusters give. It is solved
anew in each period with the h that the encoders show. Pulses are fired once what is owed reaches the minimum impulse.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array, make_read_only
from .thrusters import WHOLE

LEAST_LEFT = 0.1  # of its duration: the shortest time that is taken for left
GIVEN_UP = 2.0  # of its duration: then an off-loading ends, whether the wheels are back or not


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedOffLoading:
    """Numbers that no step changes."""

    shares: Array  # (k, 3) [1/m], as of allocation.thruster_shares
    most_share: Array  # (3,) [1/m]: of any thruster
    least_share: Array  # (3,) [1/m]: of any thruster that takes part
    most_thrust: float  # N
    minimum_impulse: float  # N.s
    period: float  # s
    duration: float  # s
    last: float  # s: the shortest time that is taken for left
    tolerance: float  # N.m.s about each axis

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(slots=True, kw_only=True)
class OffLoadingState:
    """What off-loading remembers."""

    until: float  # s
    owed: Array  # (3,) [N.m.s]: wanted of the thrusters and not yet fired
    command: Array  # (k,) [N]: of the present period


def init(thrusters: int) -> OffLoadingState:
    """Return the state before any off-loading."""
    return OffLoadingState(until=0.0, owed=np.zeros(3), command=np.zeros(thrusters))


def start_unloading(prepared: PreparedOffLoading, state: OffLoadingState, time: float) -> None:
    """Begin an off-loading at `time` [s]."""
    state.until = time + prepared.duration
    state.owed[:] = 0.0


def is_done(prepared: PreparedOffLoading, state: OffLoadingState, time: float, momentum: Array) -> bool:
    """Return whether the wheels are back, or GIVEN_UP times the duration is over."""
    back = bool(np.abs(momentum).max() < prepared.tolerance)
    return (back and time >= state.until) or time >= state.until + (GIVEN_UP - 1.0) * prepared.duration


def plan(prepared: PreparedOffLoading, state: OffLoadingState, time: float, momentum: Array) -> None:
    """Write the thrusts (k,) of the period that begins at `time` [s], for a momentum (3,) [N.m.s] of the wheels."""
    left = max(state.until - time, prepared.last)
    most = prepared.most_thrust / prepared.most_share  # N.m about each axis
    torque = np.clip(-momentum / left, -most, most)
    state.owed += prepared.period * torque
    fires = np.abs(state.owed) * prepared.least_share >= WHOLE * prepared.minimum_impulse
    fired = np.where(fires, np.clip(state.owed, -most * prepared.period, most * prepared.period), 0.0)
    state.owed -= fired
    thrust = np.maximum(prepared.shares * fired, 0.0).sum(axis=1) / prepared.period
    state.command[:] = np.minimum(thrust, prepared.most_thrust)


def stop(state: OffLoadingState) -> None:
    """Close the thrusters."""
    state.command[:] = 0.0
