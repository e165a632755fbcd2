"""Accept slew commands during a run: plan from the attitude that is there, queue, refuse or replan. numpy alone.

A command is a rotation to turn by and a start time. It counts from the attitude at which the slews before it end, that
is, the present reference attitude once they have. A command is new if it differs from the last one, element by element,
and a rotation of zero commands no slew: it takes back a slew that has not begun, and leaves the one in flight. A slew
leads its start time by the shaper's spacing and the known delays; a start time that has passed means at once. A slew
is one turn, or a chain of turns round the keep-out cones, each planned when the one before has ended.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ..arrays import Array
from . import rotations, slew_motion
from .keep_out import LEGS, is_clear
from .prepared_controller import (
    PreparedController,
    braked,
    durations_of,
    pause,
    plan_motion,
    plan_turns,
    turned_on,
)
from .slew_motion import Motion

NO_TURN = 1e-12  # rad: rounding of attitudes


class Commanded(Protocol):
    """What a controller's state holds of its commands."""

    profile: Motion  # planned, in flight or, with `following` still, ended: the turn of the present slew
    turns: Array  # (LEGS, 3) [rad]: the turns of the present slew after it; zero: none
    turns_ended: int  # of the present slew
    following: Motion  # the first turn of the slew after it
    following_turns: Array  # (LEGS, 3) [rad]: the other ones
    origin: Array  # (4,) attitude from which the profile turns, body from inertial
    base: Array  # (4,) attitude from which the command of the profile counts
    following_base: Array  # (4,) the same, of the slew after it
    braking: bool  # the profile was braked for a new command
    captured: bool  # the star tracker has given an attitude
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
        For a new command that would have to begin during a slew in flight, unless those are to be replanned; or that
        begins or ends within a keep-out cone.
    """
    if state.commanded_start == start and np.array_equal(state.commanded_rotation, rotation):
        return
    any_turn = bool(np.any(rotation))
    proceed(prepared, state, time)
    if not _in_flight(prepared, state, time):
        # one that has ended stays as it is until the next begins: the shaped torque has no more to do
        flown = _ended(prepared, state.profile, time)
        if any_turn or not flown:
            _begin_command(prepared, state, _rest(state) if flown else state.origin, rotation, start, time)
            state.base[:] = state.origin
    elif not any_turn:
        _forget_following(prepared, state)
    elif start >= _clear(prepared, state) and not state.braking:
        end = _final_attitude(state)
        turns = _turns(prepared, state, end, rotation)
        state.following = plan_motion(prepared, turns[0], start)
        state.following_turns[:], state.following_base[:] = after_first(turns), end
    elif prepared.replans:
        _replan(prepared, state, time, rotation, start)
    else:
        began, clear = state.profile.start, _clear(prepared, state)
        raise ValueError(
            f"command.rotation changed at {time:.3f} s, after the slew of {began:.3f} s had begun: command the next"
            f" slew to begin at {clear:.3f} s or later, or set command.during_slew to 'replan'"
        )
    state.commanded_rotation[:] = rotation
    state.commanded_start = start


def proceed(prepared: PreparedController, state: Commanded, time: float) -> None:
    """Begin with the turn, or the slew, that follows once the one in flight has ended."""
    for _ in range(2 * LEGS):
        if state.profile.angle == 0.0 or not _ended(prepared, state.profile, time):
            break
        if np.any(state.turns[0]):
            # a braked slew waits for the start time of the command that braked it
            earliest = state.commanded_start if state.braking else 0.0
            motion = plan_motion(prepared, state.turns[0], max(state.profile.end + pause(prepared), earliest))
            ended = state.turns_ended + 1
            _begin(state, motion, after_first(state.turns), ended=True)
            state.turns_ended = ended
        elif state.following.angle > 0.0:
            following, state.following = state.following, slew_motion.still(prepared.knots)
            _begin(state, following, state.following_turns, ended=True)
            state.following_turns[:], state.base[:] = 0.0, state.following_base
        else:
            break
    if prepared.keep_out.active and not state.captured and _in_flight(prepared, state, time):
        raise ValueError(
            f"keep_out: the slew of {state.profile.start:.3f} s begins before the star tracker has given an attitude;"
            " command it to begin later"
        )


def start_from(prepared: PreparedController, state: Commanded, time: float, attitude: rotations.Quadruple) -> None:
    """Count slews from this attitude, unless one has begun: where the spacecraft is when a run begins.

    Raises
    ------
    ValueError
        If the slew that is planned then begins or ends within a keep-out cone.
    """
    state.captured = True
    if state.profile.angle == 0.0 or not (state.turns_ended or _begun(prepared, state.profile, time)):
        state.origin[:] = state.base[:] = state.following_base[:] = attitude
        if prepared.keep_out.active and state.profile.angle > 0.0:
            _begin_command(prepared, state, state.origin, state.commanded_rotation, state.profile.start, time)


def first_turns(rotation: Array) -> Array:
    """Return the turns, (LEGS, 3) [rad], of a slew from an attitude that is not known yet: `start_from` checks them."""
    turns = np.zeros((LEGS, 3))
    turns[0] = rotation
    return turns


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
        return attitude[0], attitude[1], attitude[2], attitude[3]
    (a, b, c), (x, y, z) = axis.tolist(), quarter.tolist()
    about = 4.0 * (a * x + b * y + c * z) * axis  # in this order, so that its bits are the same on every processor
    turned = rotations.rotate_quaternion(attitude, about.tolist())
    return rotations.rotate_quaternion(turned, (4.0 * quarter - about).tolist())


def planned_motions(prepared: PreparedController, state: Commanded) -> list[Motion]:
    """Return the turns that are planned as things stand, in their order: the present one, and all that follow."""
    motions = [state.profile] if state.profile.angle > 0.0 else []
    earliest = state.commanded_start if state.braking else 0.0
    chains = [state.turns]
    if state.following.angle > 0.0:
        chains.append(state.following_turns)
    for number, turns in enumerate(chains):
        if number:
            motions.append(state.following)
        for turn in turns[np.any(turns, axis=1)]:
            motions.append(plan_motion(prepared, turn, max(motions[-1].end + pause(prepared), earliest)))
    return motions


def _turns(prepared: PreparedController, state: Commanded, attitude: Array, rotation: Array) -> Array:
    known = state.captured or not prepared.keep_out.active
    return plan_turns(prepared, attitude, rotation) if known else first_turns(rotation)


def after_first(turns: Array) -> Array:
    """Return the turns (LEGS, 3) of a slew without its first."""
    return np.vstack([turns[1:], np.zeros((1, 3))])


def _forget_following(prepared: PreparedController, state: Commanded) -> None:
    state.following = slew_motion.still(prepared.knots)
    state.following_turns[:] = 0.0
    if state.braking:
        state.turns[:] = 0.0


def _in_flight(prepared: PreparedController, state: Commanded, time: float) -> bool:
    profile = state.profile
    begun = state.turns_ended > 0 or _begun(prepared, profile, time)
    return profile.angle > 0.0 and begun and not _ended(prepared, profile, time)


def _begun(prepared: PreparedController, motion: Motion, time: float) -> bool:
    return time + prepared.actuation_delay >= motion.start - float(prepared.shaper.shifts[0])


def _ended(prepared: PreparedController, motion: Motion, time: float) -> bool:
    """Return whether no slew is planned, or the shaped torque of the one that was has ended."""
    return motion.angle == 0.0 or time + prepared.actuation_delay >= motion.end + float(prepared.shaper.shifts[0])


def _clear(prepared: PreparedController, state: Commanded) -> float:
    """Return the first start time of a slew after the present one [s]."""
    return state.profile.end + pause(prepared) + float(durations_of(prepared, state.turns).sum())


def _end_attitude(state: Commanded) -> rotations.Quadruple:
    """Return the attitude at which the present turn ends."""
    turn = (state.profile.angle * state.profile.axis).tolist()
    return rotations.rotate_quaternion(state.origin.tolist(), turn)


def _rest(state: Commanded) -> Array:
    return np.array(_end_attitude(state))


def _final_attitude(state: Commanded) -> Array:
    """Return the attitude at which the present slew ends."""
    attitude = _end_attitude(state)
    for turn in state.turns.tolist():
        attitude = rotations.rotate_quaternion(attitude, turn)
    return np.array(attitude)


def _begin_command(
    prepared: PreparedController, state: Commanded, attitude: Array, rotation: Array, start: float, time: float
) -> None:
    """Plan a slew from an attitude at rest, in place of the present one."""
    turns = _turns(prepared, state, attitude, rotation)
    motion = plan_motion(prepared, turns[0], max(start, time + lead(prepared)))
    _begin(state, motion, after_first(turns), ended=_ended(prepared, state.profile, time))


def _begin(state: Commanded, motion: Motion, turns: Array, *, ended: bool) -> None:
    """Count the motion from the end of the one before, if that was flown, else from where that would have begun."""
    if ended and state.profile.angle > 0.0:
        state.origin[:] = _end_attitude(state)
        state.reference[:3] -= 0.25 * state.profile.angle * state.profile.axis
    state.turns[:] = turns
    state.profile, state.braking, state.turns_ended = motion, False, 0


def _replan(prepared: PreparedController, state: Commanded, time: float, rotation: Array, start: float) -> None:
    """Turn to where the command leads from the attitude at which the slew in flight began.

    The turn in flight is braked, or with the quadratic programme goes on to where the turns after it are shortest, if
    the command is then reached earlier.
    """
    spacing = float(prepared.shaper.shifts[0])
    target = rotations.rotate_quaternion(state.base.tolist(), rotation.tolist())
    if not _begun(prepared, state.profile, time):  # at rest between two turns
        ended = state.turns_ended
        _begin_command(prepared, state, state.origin, _turn_between(state.origin.tolist(), target), start, time)
        state.turns_ended = ended
        _forget_following(prepared, state)
        return
    earliest = time + prepared.actuation_delay + spacing + prepared.period  # no tap of the shaper has seen it
    axis, origin = state.profile.axis, state.origin.tolist()

    def rest_of(motion: Motion) -> Array:
        attitude = rotations.rotate_quaternion(origin, (motion.angle * axis).tolist())
        return _turns(prepared, state, np.array(attitude), _turn_between(attitude, target))

    motion = braked(prepared, state.profile, earliest)
    turns, onwards = rest_of(motion), False
    if prepared.optimal and start <= earliest:
        x, y, z, w = rotations.relative_quaternion(target, origin)
        about = float(np.mod(2.0 * math.atan2(float(axis @ [x, y, z]), w), 2.0 * math.pi))  # rad
        onward = turned_on(prepared, state.profile, earliest, about)
        if onward is not None and is_clear(prepared.keep_out, state.origin[np.newaxis], about * axis[np.newaxis])[0]:
            others = rest_of(onward)
            ends = [one.end + durations_of(prepared, then).sum() for one, then in ((motion, turns), (onward, others))]
            if onwards := bool(ends[1] < ends[0]):
                motion, turns = onward, others
    _forget_following(prepared, state)
    state.profile, state.turns[:] = motion, turns
    state.braking = not onwards


def _turn_between(attitude: rotations.Quadruple, target: rotations.Quadruple) -> Array:
    """Return the short rotation vector [rad] from an attitude to another; zero for one that is rounding."""
    turn = np.array(rotations.rotation_vector(rotations.relative_quaternion(target, attitude)))
    return turn if math.hypot(*turn.tolist()) > NO_TURN else np.zeros(3)
