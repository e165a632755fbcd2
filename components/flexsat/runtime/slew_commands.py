"""Accept slew commands during a run: plan from the attitude that is there, queue, refuse or replan. numpy alone.

A command is a rotation to turn by and a start time. It counts from the attitude at which the slews before it end, that
is, the present reference attitude once they have. A command is new if it differs from the last one, element by element,
and a rotation of zero commands no slew: it takes back a slew that has not begun, and leaves the one in flight. A slew
leads its start time by the shaper's spacing and the known delays; a start time that has passed means at once.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ..arrays import Array
from . import rotations, slew_motion
from .prepared_controller import PreparedController, capability_of, plan_motion
from .slew_motion import Motion


class Commanded(Protocol):
    """What a controller's state holds of its commands."""

    profile: Motion  # planned, in flight or, with `following` still, ended
    following: Motion  # the slew after it
    origin: Array  # (4,) attitude from which the profile turns, body from inertial
    base: Array  # (4,) attitude from which the command of the profile counts
    following_base: Array  # (4,) the same, of the slew after it
    braking: bool  # the profile was braked for a new command
    commanded_rotation: Array  # (3,) [rad], of the last command
    commanded_start: float  # s
    reference: Array  # (r,) its first three: a quarter of the rotation since the origin


def lead(prepared: PreparedController) -> float:
    """Return how long before its start time a slew must be known [s]: for its shaped torque, and both delays."""
    return float(prepared.shaper.shifts[0]) + prepared.measurement_delay + prepared.actuation_delay


def command(prepared: PreparedController, state: Commanded, time: float, rotation: Array, start: float) -> None:
    """Accept a command, new or not.

    Raises
    ------
    ValueError
        For a new command that would have to begin during a slew in flight, unless those are to be replanned.
    """
    if state.commanded_start == start and np.array_equal(state.commanded_rotation, rotation):
        return
    turns = bool(np.any(rotation))
    proceed(prepared, state, time)
    if not _in_flight(prepared, state, time):
        # one that has ended stays as it is until the next begins: the shaped torque has no more to do
        if turns or not _ended(prepared, state.profile, time):
            motion = plan_motion(prepared, rotation, max(start, time + lead(prepared)))
            _begin(state, motion, ended=_ended(prepared, state.profile, time))
            state.base[:] = state.origin
    elif not turns:
        state.following = slew_motion.still(prepared.knots)
    elif start >= _clear(prepared, state.profile) and not state.braking:
        state.following = plan_motion(prepared, rotation, start)
        state.following_base[:] = _end_attitude(state)
    elif prepared.replans:
        _replan(prepared, state, time, rotation, start)
    else:
        began, clear = state.profile.start, _clear(prepared, state.profile)
        raise ValueError(
            f"command.rotation changed at {time:.3f} s, after the slew of {began:.3f} s had begun: command the next"
            f" slew to begin at {clear:.3f} s or later, or set command.during_slew to 'replan'"
        )
    state.commanded_rotation[:] = rotation
    state.commanded_start = start


def proceed(prepared: PreparedController, state: Commanded, time: float) -> None:
    """Begin with the slew that follows once the one in flight has ended."""
    if state.following.angle > 0.0 and _ended(prepared, state.profile, time):
        following, state.following = state.following, slew_motion.still(prepared.knots)
        _begin(state, following, ended=True)
        state.base[:] = state.following_base


def start_from(prepared: PreparedController, state: Commanded, time: float, attitude: rotations.Quadruple) -> None:
    """Count slews from this attitude, unless one has begun: where the spacecraft is when a run begins."""
    if state.profile.angle == 0.0 or not _begun(prepared, state.profile, time):
        state.origin[:] = state.base[:] = state.following_base[:] = attitude


def reference_attitude(origin: Array, axis: Array, quarter: Array) -> rotations.Quadruple:
    """Return the reference attitude: from the origin about the axis, then what the modes turn the body across it.

    Parameters
    ----------
    origin : (4,) where the slew began
    axis : (3,) of the slew
    quarter : (3,) a quarter of the rotation since, from the linear model: about the axis it may be large
    """
    attitude = origin.tolist()
    if not quarter.any():
        x, y, z, w = attitude
        return x, y, z, w
    about = 4.0 * float(axis @ quarter) * axis
    turned = rotations.rotate_quaternion(attitude, about.tolist())
    return rotations.rotate_quaternion(turned, (4.0 * quarter - about).tolist())


def _in_flight(prepared: PreparedController, state: Commanded, time: float) -> bool:
    profile = state.profile
    return profile.angle > 0.0 and _begun(prepared, profile, time) and not _ended(prepared, profile, time)


def _begun(prepared: PreparedController, motion: Motion, time: float) -> bool:
    return time + prepared.actuation_delay >= motion.start - float(prepared.shaper.shifts[0])


def _ended(prepared: PreparedController, motion: Motion, time: float) -> bool:
    """Return whether no slew is planned, or the shaped torque of the one that was has ended."""
    return motion.angle == 0.0 or time + prepared.actuation_delay >= motion.end + float(prepared.shaper.shifts[0])


def _clear(prepared: PreparedController, motion: Motion) -> float:
    """Return the first start time of a slew after this one [s]."""
    return motion.end + 2.0 * float(prepared.shaper.shifts[0]) + prepared.period


def _end_attitude(state: Commanded) -> rotations.Quadruple:
    """Return the attitude at which the slew ends."""
    turn = (state.profile.angle * state.profile.axis).tolist()
    return rotations.rotate_quaternion(state.origin.tolist(), turn)


def _begin(state: Commanded, motion: Motion, *, ended: bool) -> None:
    """Count the motion from the end of the one before, if that was flown, else from where that would have begun."""
    if ended and state.profile.angle > 0.0:
        state.origin[:] = _end_attitude(state)
        state.reference[:3] -= 0.25 * state.profile.angle * state.profile.axis
    state.profile, state.braking = motion, False


def _replan(prepared: PreparedController, state: Commanded, time: float, rotation: Array, start: float) -> None:
    """Brake the slew in flight, then turn to where the command leads from the attitude at which that slew began."""
    spacing = float(prepared.shaper.shifts[0])
    earliest = time + prepared.actuation_delay + spacing + prepared.period  # no tap of the shaper has seen it
    deceleration, _ = capability_of(prepared, state.profile.axis)
    state.profile = slew_motion.stopped(
        state.profile, earliest, deceleration, prepared.period, prepared.actuation_delay
    )
    target = rotations.rotate_quaternion(state.base.tolist(), rotation.tolist())
    turn = np.array(rotations.rotation_vector(rotations.relative_quaternion(target, _end_attitude(state))))
    state.following = slew_motion.still(prepared.knots)
    if math.hypot(*turn.tolist()) > 0.0:
        state.following = plan_motion(prepared, turn, max(start, _clear(prepared, state.profile)))
    state.following_base[:] = state.base
    state.braking = True
