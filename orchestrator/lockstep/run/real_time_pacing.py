"""Pace a run by the wall clock: no tick starts before its time, and ticks that ended too late are counted.

Simulated time t is due at origin + (t - first) / pace on the clock. Each deadline is computed from the origin, so
neither a long sleep nor a late tick shifts the later ones: a run that is late catches up without waiting.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter, sleep

from lockstep.errors import InputError
from lockstep.interrupt import Interrupt

_POLLING = 2e-4  # [s] before a deadline in which the clock is polled: a sleep ends some 0.1 ms late
_SLICE = 0.05  # [s] of sleep between two checks for Ctrl-C


class Pacer:
    """The clock of a paced run. Called with a simulated time [s], it returns when that time is due."""

    def __init__(
        self, pace: float, clock: Callable[[], float] = perf_counter, wait: Callable[[float], None] = sleep
    ) -> None:
        self.pace = pace
        self.overruns = 0  # ticks whose work was not done when the next one was due
        self.worst = 0.0  # [s] of wall time by which the work of a tick ended late
        self.worst_at = 0.0  # [s] simulated, the start of the tick after it
        self._clock, self._wait = clock, wait
        self._interrupt = Interrupt()
        self._origin = self._first = 0.0

    def begin(self, first: float, interrupt: Interrupt) -> None:
        """Start the clock: simulated time `first` is due now."""
        self._interrupt = interrupt
        self._first, self._origin = first, self._clock()

    def __call__(self, time: float) -> None:
        """Wait until this simulated time is due, or count an overrun; raise KeyboardInterrupt after Ctrl-C."""
        clock = self._clock
        due = self._origin + (time - self._first) / self.pace
        left = due - clock()
        if left < 0.0:
            if time > self._first:
                self.overruns += 1
                if -left > self.worst:
                    self.worst, self.worst_at = -left, time
            return
        while left > _POLLING:
            self._wait(min(left - _POLLING, _SLICE))
            self._interrupt.check()
            left = due - clock()
        while clock() < due:
            pass

    def summary(self) -> dict[str, object]:
        """Return the numbers for run.toml and events."""
        return {
            "factor": self.pace,
            "overruns": self.overruns,
            "worst_lateness": round(self.worst, 9),
            "worst_at": self.worst_at,
        }

    def __str__(self) -> str:
        """Describe the pacing in one line."""
        if not self.overruns:
            return f"paced at {self.pace:g} x real time, no overruns"
        many = "s" if self.overruns > 1 else ""
        worst = f"worst {1e3 * self.worst:.3g} ms late at {self.worst_at:.9g} s"
        return f"paced at {self.pace:g} x real time, {self.overruns} overrun{many}, {worst}"


def pacer_given(pace: float | str | Pacer | None) -> Pacer | None:
    """Return the pacer of a factor of real time; None, or 0: as fast as possible. Raises InputError."""
    if pace is None or isinstance(pace, Pacer):
        return pace
    try:
        factor = float(pace)
    except (TypeError, ValueError):
        factor = math.nan
    if not 0.0 <= factor < math.inf:
        raise InputError(f"pace {pace!r} must be a factor of real time > 0, for example 1.0, or 0 for no pacing")
    return Pacer(factor) if factor else None
