"""Find the slews of a run in its recorded reference, whatever commanded them and however they were planned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.runtime.rotations import error_angle
from lockstep import Signals

from . import histories

COASTING = 0.2  # of the largest rate beside it: a mean rate above it is a coast, below it an oscillation at rest
MOVING = 0.01  # of the largest rate, where no feed-forward torque shows when a slew begins and ends
REST = 1e-9  # rad/s: below it a reference stands still, 0.2 milliarcseconds a second
PAUSE = 1.0  # s: a shorter rest inside a slew is a part of it


@dataclass(frozen=True, slots=True, kw_only=True)
class Slew:
    """A stretch of a run in which the reference moves [s]. Without an end, the run ended before the slew.

    A reference that jumps is a slew without a length.
    """

    start: float
    end: float | None


def slews_of(signals: Signals) -> tuple[Slew, ...]:
    """Return the slews of a run, in their order; none where no reference was recorded, or it stands still.

    A slew lasts from its first feed-forward torque to its last one, the coast between them included; what the
    reference of a flexible structure oscillates afterwards is no slew. Without torque, the reference rate shows it.
    """
    time = signals.time
    if histories.ATTITUDE_REFERENCE not in signals or len(time) < 2:
        return ()
    attitude = signals[histories.ATTITUDE_REFERENCE]
    rates = 4.0 * np.linalg.norm(np.diff(attitude, axis=0), axis=1) / np.diff(time)
    rate = np.append(rates, rates[-1])
    if histories.RATE_REFERENCE in signals:
        recorded = np.linalg.norm(signals[histories.RATE_REFERENCE], axis=1)
        if not recorded.any():
            return _jumps(time, attitude)
        rate = recorded
    if not rate.max() > REST:
        return ()
    if histories.TORQUE_REFERENCE in signals:
        torque = np.any(signals[histories.TORQUE_REFERENCE] != 0.0, axis=1)
        if torque.any():
            return _of_torque(time, attitude, rate, torque)
        if rate[0] > REST:  # begins in a slew's coast, or in what oscillates after it
            coasts = _coasts(time, attitude, 0, len(time) - 1, float(rate.max()))
            return (Slew(start=float(time[0]), end=None),) if coasts else ()
    return _as_slews(time, _stretches(time, rate > max(MOVING * float(rate.max()), REST)))


def _jumps(time: Array, attitude: Array) -> tuple[Slew, ...]:
    changed = np.flatnonzero(np.any(np.diff(attitude, axis=0) != 0.0, axis=1)) + 1
    return tuple(Slew(start=float(time[row]), end=float(time[row])) for row in changed)


def _of_torque(time: Array, attitude: Array, rate: Array, torque: NDArray[np.bool_]) -> tuple[Slew, ...]:
    """Return the slews of which the feed-forward torque shows begin and end: pulses joined by their coasts."""
    pulses = _stretches(time, torque)
    joined = [list(pulses[0])]
    for first, after in pulses[1:]:
        beside = float(max(rate[slice(*joined[-1])].max(), rate[first:after].max()))
        if _coasts(time, attitude, joined[-1][1], first, beside):
            joined[-1][1] = after
        else:
            joined.append([first, after])
    last = len(time) - 1
    if _coasts(time, attitude, 0, joined[0][0], float(rate[slice(*joined[0])].max())):
        joined[0][0] = 0
    if _coasts(time, attitude, joined[-1][1], last, float(rate[slice(*joined[-1])].max())):
        joined[-1][1] = last + 1
    return _as_slews(time, joined)


def _coasts(time: Array, attitude: Array, first: int, last: int, beside: float) -> bool:
    """Return whether the reference turns on between two rows, at a mean rate worth mentioning."""
    if last <= first:
        return False
    turned = float(error_angle(attitude[last : last + 1], attitude[first : first + 1])[0])
    return turned > COASTING * beside * float(time[last] - time[first])


def _stretches(time: Array, moving: NDArray[np.bool_]) -> list[list[int]]:
    """Return the first row of each stretch and the first one after it; a short rest joins two stretches."""
    edges = np.diff(np.concatenate([[0], moving.astype(int), [0]]))
    found: list[list[int]] = []
    for first, after in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        if found and time[first] - time[found[-1][1]] < PAUSE:
            found[-1][1] = int(after)
        else:
            found.append([int(first), int(after)])
    return found


def _as_slews(time: Array, stretches: list[list[int]]) -> tuple[Slew, ...]:
    rows = len(time)
    return tuple(
        Slew(start=float(time[first]), end=float(time[after]) if after < rows else None) for first, after in stretches
    )
