"""Keep every recorded row of a run's histories in windows around its interesting seconds, beside the reduced record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep.system.clock import SAME_TIME

from .history_data import FLOAT, History, encode, time_base

BEFORE, AFTER = 0.5, 1.5  # s of a window, about an event: some periods of the modes that a slew excites
LAST = 2.0  # s at the end of the run, where errors have settled
MOST_WINDOWS = 6
SHOWN = {"slew": "slew begins", "end": "slew ends"}  # window by text of a mark


@dataclass(frozen=True, slots=True, kw_only=True)
class FullRate:
    """A window of a run in which every row is kept."""

    name: str
    begin: float  # s
    end: float  # s

    def rows(self, time: Array) -> NDArray[np.intp]:
        """Return the recorded rows in the window."""
        return np.flatnonzero((time >= self.begin - SAME_TIME) & (time <= self.end + SAME_TIME))


def windows_about(marks: Sequence[Mapping[str, Any]], time: Array) -> list[FullRate]:
    """Return windows about begin and end of slews, faults and other events, and at the end; without overlaps.

    Of more than MOST_WINDOWS, those of slews and faults come first.
    """
    first, last = float(time[0]), float(time[-1])
    wanted = [
        FullRate(
            name=SHOWN.get(mark["text"], mark["text"]) if mark["kind"] == "slew" else str(mark["text"]),
            begin=max(first, mark["time"] - BEFORE),
            end=min(last, mark["time"] + AFTER),
        )
        for mark in sorted(marks, key=lambda mark: mark["kind"] not in ("slew", "fault"))
        if first <= mark["time"] <= last
    ]
    ending = FullRate(name="end of the run", begin=max(first, last - LAST), end=last)
    taken: list[FullRate] = []
    for one in [ending, *wanted]:
        if len(taken) < MOST_WINDOWS and all(one.end < other.begin or one.begin > other.end for other in taken):
            taken.append(one)
    return sorted(taken, key=lambda one: one.begin)


def full_rate_data(
    time: Array, histories: Sequence[History], windows: Sequence[FullRate], budget: int
) -> dict[str, Any]:
    """Return the rows in the windows, of as many histories as `budget` bytes have room for, in their order.

    Each history has its samples of all windows one after another, as base64; one that is constant needs none.
    """
    rows = [window.rows(time) for window in windows]
    every = np.concatenate(rows) if rows else np.array([], dtype=np.intp)
    room = budget // (FLOAT * len(every)) if len(every) else 0
    changing = [one for one in histories if len(one.values) and one.values.min() != one.values.max()]
    return {
        "windows": [
            {
                "name": window.name,
                "begin": float(time[inside[0]]),  # of rows: a view of just the window shows every one
                "end": float(time[inside[-1]]),
                "time": time_base(time[inside], 1),
            }
            for window, inside in zip(windows, rows, strict=True)
            if len(inside) > 1
        ]
        if room
        else [],
        "data": {one.name: encode(one.values[every].astype(np.float32)) for one in changing[:room]},
    }
