"""Modes of a mission as a state machine, and the timeline that it carries out. numpy alone.

    acquisition  no attitude from the star tracker yet, or not for the time of an outage
    slew         a slew was commanded, or the reference still moves
    settle       the reference rests; the pointing error has yet to be within the band for the dwell
    fine         it has been
    off-load     thrusters bring the wheels back while the attitude is held
    safe         the attitude is held, nothing else is done until the timeline resumes

A command of the timeline is carried out at its time or, if something else is under way, as soon as that has ended. The
command `safe` waits for nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array, Index, make_read_only

ACQUISITION, SLEW, SETTLE, FINE, OFF_LOAD, SAFE = range(6)
MODES = ("acquisition", "slew", "settle", "fine", "off-load", "safe")  # by number
NOTHING, DO_SLEW, DO_OFF_LOAD, DO_SAFE, DO_RESUME = range(5)
ACTIONS = ("none", "slew", "off-load", "safe", "resume")  # of a command, by number
LEFT = 3.0  # bands: a pointing error beyond ends the mode fine
EARLY = 1e-9  # s: rounding of times
START_LIMIT = 20.0  # s after its start time: a slew that has not begun by then is given up


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedModes:
    """Numbers that no step changes."""

    time: Array  # (c,) [s], of the commands, rising
    action: Index  # (c,)
    rotation: Array  # (c, 3) [rad]
    lead: float  # s, from a command to the start time of its slew
    band: float  # rad
    dwell: int  # steps
    outage: int  # steps without a sample of the star tracker
    safe_outage: int  # steps without one that end in safe
    start_limit: int  # steps in which a slew must have begun
    automatic: float  # share of the speed band that begins an off-loading; 0: none

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What the modes follow from."""

    star_tracker_valid: bool
    error: float  # rad, of the estimated pointing
    moving: bool  # the reference
    speed_share: float  # of the band, of the wheel that is farthest from its nominal speed
    off_loaded: bool  # the present off-loading is done
    lost_axis: bool  # the wheels give no torque about some axis


@dataclass(slots=True, kw_only=True)
class ModeState:
    """What the state machine remembers."""

    mode: int
    steps: int  # in the mode
    settled: int  # steps in a row within the band, in this mode
    since_star_tracker: int  # steps
    next: int  # command of the timeline
    moved: bool  # the present slew has begun
    rotation: Array  # (3,) [rad] commanded
    start: float  # s


def init(prepared: PreparedModes) -> ModeState:
    """Return the state at the start: no attitude yet."""
    return ModeState(
        mode=ACQUISITION,
        steps=0,
        settled=0,
        since_star_tracker=prepared.outage + 1,
        next=0,
        moved=False,
        rotation=np.zeros(3),
        start=0.0,
    )


def is_out(prepared: PreparedModes, state: ModeState) -> bool:
    """Return whether the star tracker gives nothing."""
    return state.since_star_tracker > prepared.outage


def step(prepared: PreparedModes, state: ModeState, time: float, seen: Seen) -> bool:
    """Change the mode, and carry out what is due; return whether an off-loading begins now."""
    state.since_star_tracker = 0 if seen.star_tracker_valid else state.since_star_tracker + 1
    state.settled = state.settled + 1 if seen.error < prepared.band else 0
    state.steps += 1
    mode = _followed(prepared, state, seen)
    began = mode == OFF_LOAD and state.mode != OFF_LOAD
    action = _due(prepared, state, time)
    if action == DO_SAFE or (mode == SAFE and action != DO_RESUME):
        mode = SAFE if action != NOTHING else mode
        state.next += action != NOTHING
    elif action == DO_RESUME:
        mode = ACQUISITION if mode == SAFE else mode
        state.next += 1
    elif action != NOTHING and mode in (SETTLE, FINE) and state.mode == mode and state.steps > prepared.dwell:
        if action == DO_SLEW:
            state.rotation[:] = prepared.rotation[state.next]
            state.start, state.moved, mode = time + prepared.lead, False, SLEW
        else:
            mode, began = OFF_LOAD, True
        state.next += 1
    if mode == SAFE:
        state.rotation[:], began = 0.0, False
    if mode != state.mode:
        state.mode, state.steps, state.settled = mode, 0, 0
    return began


def _followed(prepared: PreparedModes, state: ModeState, seen: Seen) -> int:
    """Return the mode that follows from what is seen, the timeline aside."""
    mode, out = state.mode, is_out(prepared, state)
    # before the first sample there is nothing to lose
    waited = state.since_star_tracker > prepared.safe_outage + prepared.outage + 1
    if mode == SAFE or seen.lost_axis or waited:
        return SAFE
    if mode == SLEW:
        state.moved = state.moved or seen.moving
        over = state.moved and not seen.moving
        return SETTLE if over or (not state.moved and state.steps > prepared.start_limit) else SLEW
    if mode == OFF_LOAD:
        return SETTLE if seen.off_loaded else OFF_LOAD
    if out:
        return ACQUISITION
    if mode == ACQUISITION:
        return SETTLE
    if prepared.automatic > 0.0 and seen.speed_share > prepared.automatic and state.steps > prepared.dwell:
        return OFF_LOAD
    if mode == SETTLE:
        return FINE if state.settled >= prepared.dwell else SETTLE
    return SETTLE if seen.error > LEFT * prepared.band else FINE


def _due(prepared: PreparedModes, state: ModeState, time: float) -> int:
    """Return the action of the command whose time has come."""
    if state.next >= len(prepared.time) or prepared.action[state.next] == NOTHING:
        return NOTHING
    return int(prepared.action[state.next]) if time >= prepared.time[state.next] - EARLY else NOTHING
