"""Pace a run by the wall clock: no tick starts before its time, and ticks that ended too late are counted.

Simulated time t is due at origin + (t - first) / pace on the clock. Each deadline is computed from the origin, so
neither a long sleep nor a late tick shifts the later ones: a run that is late catches up without waiting.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from time import perf_counter, sleep

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import InputError
from lockstep.interrupt import Interrupt
from lockstep.tick.operations import Operation, Pace, Python

_POLLING = 2e-4  # [s] before a deadline in which the clock is polled: a sleep ends some 0.1 ms late
_SLICE = 0.05  # [s] of sleep between two checks for Ctrl-C
EDGES = (*(float(f"{digit}e{power}") for power in range(-6, 0) for digit in (1, 2, 5)), 1.0)  # [s] of the histogram
_BAR = 40  # letters of the longest bar
_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"))

# places in `Pacer.numbers`, which the tick in C reads and counts in too
ORIGIN, FIRST, PACE, POLLING, OVERRUNS, WORST, WORST_AT = range(7)


class Pacer:
    """The clock of a paced run. Called with a simulated time [s], it returns when that time is due."""

    def __init__(
        self, pace: float, clock: Callable[[], float] = perf_counter, wait: Callable[[float], None] = sleep
    ) -> None:
        self.numbers: NDArray[np.float64] = np.zeros(7)
        self.numbers[PACE], self.numbers[POLLING] = pace, _POLLING
        self.counts: NDArray[np.int64] = np.zeros(len(EDGES) + 1, np.int64)  # ticks, by how late they began
        self._clock, self._wait = clock, wait
        self._interrupt = Interrupt()
        self._origin = self._first = 0.0
        self.pace = pace

    @property
    def overruns(self) -> int:
        """Ticks whose work was not done when the next one was due."""
        return int(self.numbers[OVERRUNS])

    @property
    def worst(self) -> float:
        """The wall time by which the work of a tick ended late at most [s]."""
        return float(self.numbers[WORST])

    @property
    def worst_at(self) -> float:
        """The start of the tick after that [s] simulated."""
        return float(self.numbers[WORST_AT])

    def start(self, first: float, interrupt: Interrupt) -> None:
        """Start the clock: simulated time `first` is due now."""
        self._interrupt = interrupt
        self._first, self._origin = first, self._clock()
        self.numbers[FIRST], self.numbers[ORIGIN] = first, self._origin

    def __call__(self, time: float) -> None:
        """Wait until this simulated time is due, or count an overrun; raise KeyboardInterrupt after Ctrl-C."""
        clock, numbers = self._clock, self.numbers
        due = self._origin + (time - self._first) / self.pace
        now = clock()
        if now > due:
            if time > self._first:
                numbers[OVERRUNS] += 1
                if now - due > numbers[WORST]:
                    numbers[WORST], numbers[WORST_AT] = now - due, time
        else:
            while due - now > _POLLING:
                self._wait(min(due - now - _POLLING, _SLICE))
                self._interrupt.check()
                now = clock()
            while now < due:
                now = clock()
        self.counts[bisect_right(EDGES, now - due)] += 1

    def operation(self) -> Operation:
        """Return the wait before a tick as an operation of it: in C where the clock is that of C."""
        if self._clock is not perf_counter:
            return Python(call=self)
        return Pace(call=self, numbers=self.numbers, edges=np.array(EDGES), counts=self.counts)

    def summary(self) -> dict[str, object]:
        """Return the numbers for run.toml and events; `lateness_counts` has one more than there are edges [s]."""
        return {
            "factor": self.pace,
            "overruns": self.overruns,
            "worst_lateness": round(self.worst, 9),
            "worst_at": self.worst_at,
            "lateness_edges": list(EDGES),
            "lateness_counts": self.counts.tolist(),
        }

    def __str__(self) -> str:
        """Describe the pacing in one line."""
        if not self.overruns:
            return f"paced at {self.pace:g} x real time, no overruns"
        many = "s" if self.overruns > 1 else ""
        worst = f"worst {1e3 * self.worst:.3g} ms late at {self.worst_at:.9g} s"
        return f"paced at {self.pace:g} x real time, {self.overruns} overrun{many}, {worst}"

    def histogram(self) -> list[str]:
        """Return lines that show how late the ticks began, between the least and the worst; none without ticks."""
        found = np.flatnonzero(self.counts)
        if not len(found):
            return []
        most, lines = int(self.counts.max()), ["ticks by how late they began:"]
        for k in range(found[0], found[-1] + 1):
            count = int(self.counts[k])
            if k == 0:
                span = f"up to {time_text(EDGES[0])}"
            elif k == len(EDGES):
                span = f"over {time_text(EDGES[-1])}"
            else:
                span = f"{time_text(EDGES[k - 1])} to {time_text(EDGES[k])}"
            bar = "#" * math.ceil(_BAR * count / most)
            lines.append(f"{span:>18} {count:>9} {bar}".rstrip())
        return lines


def time_text(time: float) -> str:
    """Return a time [s] in the largest unit that suits it, 50 us for example."""
    size, unit = next((size, unit) for size, unit in _UNITS if time >= 0.99 * size)
    return f"{time / size:.0f} {unit}"


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
