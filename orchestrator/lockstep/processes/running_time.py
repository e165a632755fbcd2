"""Measure how long something has taken, without time in which this process was stopped or the machine slept."""

from __future__ import annotations

from time import monotonic

_INTERVAL = 0.05  # [s] between two looks


class RunningTime:
    """The time of something that may take `limit` seconds: what passed between looks, each counted up to a bound.

    A process that was stopped finds hours between two looks. It is to have others before the limit is reached, by which
    time what it waits for has happened.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._longest = min(4.0 * _INTERVAL, limit / 4.0)
        self._passed = 0.0
        self._last = monotonic()

    def look(self, *, counts: bool = True) -> None:
        """Look at the clock, often; `counts` says whether the time since the last look counts."""
        now = monotonic()
        if counts:
            self._passed += min(now - self._last, self._longest)
        self._last = now

    @property
    def is_over(self) -> bool:
        """Whether the limit is reached."""
        return self._passed >= self._limit

    @property
    def next_look(self) -> float:
        """When to look next, at the latest [s]."""
        return max(0.0, min(_INTERVAL, self._longest, self._limit - self._passed))
