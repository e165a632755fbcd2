"""Find from when to when something holds in the rows of a run, which come block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep.results.monitor import Found
from lockstep.system.clock import SAME_TIME

HOLD = 1.0  # s that it must be over before an episode ends: what comes back sooner belongs to it

Details = dict[str, object]
_NONE: Details = {}


@dataclass(slots=True, kw_only=True)
class Episodes:
    """The episodes of one kind in a run: events of their beginnings and ends, and what they come to."""

    event: str
    fixed: Details = field(default_factory=dict)  # details of every event
    count: int = 0
    first: float | None = None  # s, beginning of the first episode
    begin: float | None = None  # s, of the episode that is open
    over: float | None = None  # s, since when it does not hold, in an open episode
    holding: bool = False  # in the last row
    seconds: float = 0.0  # s, of closed episodes
    wheels: set[int] = field(default_factory=set)  # counted from 1, that took part in the open episode

    def feed(
        self,
        time: Array,
        active: NDArray[np.bool_],
        begins: Array | None = None,
        ends: Array | None = None,
        wheels: NDArray[np.bool_] | None = None,
        details: Callable[[int], Details] = lambda _: _NONE,
    ) -> Iterator[Found]:
        """Yield the events of some rows.

        Parameters
        ----------
        time, active : (rows,) [s], and whether it holds there
        begins, ends : (rows,) [s] when it began, or ended, if it did in this row; None: at the time of the row
        wheels : (rows, n) which wheels take part
        details : of a beginning, by its row
        """
        begins, ends = time if begins is None else begins, time if ends is None else ends
        states = np.concatenate([[self.holding], active])
        edges = [int(k) for k in np.flatnonzero(states[1:] != states[:-1])]
        last = 0
        for k in [*edges, len(time)]:
            if self.holding and wheels is not None:
                self.wheels |= _numbers(np.any(wheels[last:k], axis=0))
            if k == len(time):
                break
            self.holding, last = bool(active[k]), k
            if not self.holding:
                self.over = float(ends[k])
                continue
            begin = float(begins[k])
            yield from self._close_if_over(begin)
            self.over = None
            if self.begin is None:
                self.begin, self.count = begin, self.count + 1
                self.first = begin if self.first is None else self.first
                now = {} if wheels is None else {"wheels": sorted(_numbers(wheels[k]))}
                yield Found(time=begin, event=self.event, details={"state": "begin", **self.fixed, **now, **details(k)})
        if len(time):
            yield from self._close_if_over(float(time[-1]))

    def end(self) -> Iterator[Found]:
        """Yield the end of an episode that is over when no more rows come; one that goes on has none."""
        yield from self._close_if_over(np.inf)

    def total(self, last: float) -> float:
        """Return how long all episodes have lasted until the last row's time [s]."""
        return self.seconds + (0.0 if self.begin is None else (last if self.over is None else self.over) - self.begin)

    def _close_if_over(self, now: float) -> Iterator[Found]:
        if self.begin is None or self.over is None or now - self.over < HOLD:
            return
        begin, end = self.begin, self.over
        took = {"wheels": sorted(self.wheels)} if self.wheels else {}
        self.seconds += end - begin
        self.begin = self.over = None
        self.wheels = set()
        yield Found(time=end, event=self.event, details={"state": "end", "since": begin, **self.fixed, **took})


def _numbers(flags: object) -> set[int]:
    return {int(k) + 1 for k in np.flatnonzero(np.asarray(flags))}


class Slices:
    """Cut rows into slices of equal duration from the first row on, however the rows are divided into blocks."""

    def __init__(self, duration: float, keep: int) -> None:
        """Prepare slices of so many seconds; with each come the `keep` - 1 slices before it."""
        self.duration, self._keep = duration, keep
        self._start: float | None = None  # s, of the first slice
        self._done = 0  # slices
        self._time = np.empty(0)
        self._values: Array | None = None

    def feed(self, time: Array, values: Array) -> Iterator[tuple[float, list[Array]]]:
        """Yield the end [s] of each slice that is complete, and the rows of it and those before, oldest first."""
        if self._start is None:
            self._start = float(time[0]) if len(time) else None
        self._time = np.concatenate([self._time, time])
        self._values = values.copy() if self._values is None else np.concatenate([self._values, values])
        if self._start is None:
            return
        while len(self._time) and self._time[-1] >= self._edge(self._done + 1):
            self._done += 1
            edges = [self._edge(k) for k in range(max(0, self._done - self._keep), self._done + 1)]
            places = np.searchsorted(self._time, edges)
            rows = [self._values[a:b] for a, b in pairwise(places)]
            yield edges[-1] + SAME_TIME, rows
            oldest = np.searchsorted(self._time, self._edge(max(0, self._done + 1 - self._keep)))
            self._time, self._values = self._time[oldest:], self._values[oldest:]

    def _edge(self, number: int) -> float:
        """Return the time before which a slice ends, less what times of rows are rounded by."""
        assert self._start is not None
        return self._start + number * self.duration - SAME_TIME
