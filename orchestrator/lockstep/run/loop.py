"""The loop of ticks: the actions of each tick, actions between two ticks, and a look around now and then."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import cycle, islice
from math import lcm
from time import perf_counter
from typing import Protocol

import numpy as np

from lockstep.system.clock import Time, seconds

Action = Callable[[float], None]  # called with the simulated time [s]
Pause = tuple[int, Callable[[], None]]  # after so many ticks of the whole run, what is called then

_LOOK_INTERVAL = 0.1  # [s] of wall time between two looks around


class Clock(Protocol):
    """What others read the present simulated time from."""

    time: float  # [s]


class Loop:
    """The ticks of a run, from one to another; `done` is how many of the whole run are complete."""

    def __init__(self, *, tick: Time, first: int, last: int, clock: Clock, start: Time = 0) -> None:
        """Prepare the loop of the ticks `first` to `last` (exclusive) of `tick` ns each; tick 0 begins at `start`."""
        self.tick, self.first, self.last, self.start = tick, first, last, start
        self.done = first
        self._clock = clock
        self._ending = False
        clock.time = self.time

    @property
    def time(self) -> float:
        """Simulated time that is complete [s]."""
        return seconds(self.start + self.done * self.tick)

    def end_after_tick(self) -> None:
        """End the loop when the present tick is complete."""
        self._ending = True

    def go_back(self, tick: int) -> None:
        """Continue at a tick, as if no later one had been run, and none had ended the loop."""
        self.done, self._ending = tick, False
        self._clock.time = self.time

    def run(self, phases: Sequence[tuple[Action, ...]], pauses: Iterable[Pause], look: Action) -> None:
        """Run all ticks.

        Parameters
        ----------
        phases : actions of each tick of a cycle, in order; the cycle begins at tick 0 of the whole run
        pauses : in the order of their ticks: when to stop between two ticks, or after the last one, for an action
        look : called at most ten times in a second of wall time, after a tick, with the time at which that began [s]
        """
        due = perf_counter() + _LOOK_INTERVAL
        first = self.first
        with np.errstate(over="ignore"):  # a value that overflows ends the run by name, without a warning before
            for end, act in [*pauses, (self.last, None)]:
                due = self._ticks(phases, range(first, end), due, look)
                if self._ending:
                    self._clock.time = self.time
                    return
                self.done = first = end
                self._clock.time = self.time
                if act is not None:
                    act()

    def _ticks(self, phases: Sequence[tuple[Action, ...]], ticks: range, due: float, look: Action) -> float:
        """Run these ticks; return when the next look is due, on the wall clock."""
        events, clock = self._clock, perf_counter
        parts = lcm(self.tick.denominator, self.start.denominator)  # of a nanosecond, in which all times are whole
        length, origin = int(self.tick * parts), int(self.start * parts)
        second = 1e9 if parts == 1 else parts * 10**9
        for tick, phase in zip(ticks, islice(cycle(phases), ticks.start % len(phases), None), strict=False):
            self.done = tick
            events.time = time = (origin + tick * length) / second  # the nearest double, never a sum of steps
            for action in phase:
                action(time)
            if self._ending:
                self.done = tick + 1
                break
            if clock() >= due:
                self.done = tick + 1  # the tick is complete: every recorded row lies before the simulated time
                look(time)
                due = clock() + _LOOK_INTERVAL
        return due
