"""The loop of ticks: a program's ticks, and actions between two of them, such as checkpoints."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from lockstep.system.clock import Time, seconds
from lockstep.tick.operations import Action, Clock, Ticking

Pause = tuple[int, Callable[[], None]]  # after so many ticks of the whole run, what is called then


class Loop:
    """The ticks of a run, from one to another; `done` is how many of the whole run are complete."""

    def __init__(self, *, tick: Time, first: int, last: int, clock: Clock, start: Time = 0) -> None:
        """Prepare the loop of the ticks `first` to `last` (exclusive) of `tick` ns each; tick 0 begins at `start`."""
        self.tick, self.first, self.last, self.start = tick, first, last, start
        self.ended = False  # whether a component ended the run
        self._clock = clock
        self._ticking: Ticking | None = None
        self._stopped = False  # before the tick that was asked for
        self.threads = 1  # that have stepped components, up to `close`
        self.pauses: list[Pause] = []  # those to come, in the order of their ticks
        self._look: Action = lambda _: None
        self._outside = 0.0  # [s] of wall time around the ticks: checkpoints, progress
        self._spent: dict[str, float] = {}  # [s] of what has been closed
        self._executed: list[tuple[int, int]] = []  # ranges of ticks, before the present one
        self._begun = first  # the present one
        clock.time = self.time

    @property
    def done(self) -> int:
        """How many ticks of the whole run are complete."""
        return self.first if self._ticking is None else self._ticking.done

    @property
    def time(self) -> float:
        """Simulated time that is complete [s]."""
        return seconds(self.start + self.done * self.tick)

    def end_after_tick(self) -> None:
        """End the loop when the present tick is complete."""
        self.ended = True
        if self._ticking is not None:
            self._ticking.end_after_tick()

    def bind(self, ticking: Ticking, look: Action) -> None:
        """Set what executes ticks, from `done` on.

        `look` is called about ten times in a second of wall time, with the time at which the present tick began [s].
        """
        self.close()
        self._ticking, self._look = ticking, look

    def close(self) -> None:
        """End what executes ticks."""
        if self._ticking is not None:
            self._spent = self._measured()
            self._end_range()
            self.first = self._ticking.done
            self.threads = max(self.threads, self._ticking.threads)
            self._ticking.close()
            self._ticking = None

    @property
    def executed(self) -> list[tuple[int, int]]:
        """The ranges of ticks that were executed; after `go_back` they overlap."""
        return [*self._executed, (self._begun, self.done)]

    def _end_range(self) -> None:
        self._executed = self.executed
        self._begun = self.done

    @property
    def spent(self) -> dict[str, float]:
        """The wall time by account [s], see `lockstep.tick.accounts`; if it is not measured, the rest is all of it."""
        found = self._measured()
        return found | {"rest": found.get("rest", 0.0) + max(0.0, self._outside)}

    def _measured(self) -> dict[str, float]:
        """Return the wall time of ticks by account, with that of what has been closed."""
        found = dict(self._spent)
        for name, time in ({} if self._ticking is None else self._ticking.spent()).items():
            found[name] = found.get(name, 0.0) + time
        return found

    @contextmanager
    def _timed(self) -> Iterator[None]:
        """Charge what passes in this block, beside the ticks, to the rest."""
        ticking = self._ticking
        assert ticking is not None
        before, started = ticking.measured(), perf_counter()
        try:
            yield
        finally:
            self._outside += perf_counter() - started - (ticking.measured() - before)

    def go_back(self, tick: int) -> None:
        """Continue at a tick, as if no later one had been run, and none had ended the loop."""
        assert self._ticking is not None
        self._end_range()
        self._begun = tick
        self._ticking.go_back(tick)
        self.ended = False
        self._clock.time = self.time

    def stepper(self, last: int) -> Callable[[], int]:
        """Return a quick function that executes one tick, without the pauses: see `Ticking`."""
        assert self._ticking is not None
        return self._ticking.stepper(last)

    def go_on(self, reason: int) -> None:
        """Complete the tick at which the function of `stepper` returned a reason."""
        assert self._ticking is not None
        with self._timed():
            self._ticking.go_on(reason, self._look)
        self._clock.time = self.time

    def settle(self) -> None:
        """Take over what the function of `stepper` has done."""
        if self._ticking is not None:
            self._ticking.settle()
        self._clock.time = self.time

    def stop_after_tick(self) -> None:
        """Have `run_until` return when the present tick is complete."""
        assert self._ticking is not None
        self._stopped = True
        self._ticking.end_after_tick()

    @property
    def in_tick(self) -> bool:
        """Whether a tick has begun and is not complete."""
        return self._ticking is not None and self._ticking.in_tick

    def run_until(self, tick: int) -> None:
        """Run on until so many ticks of the whole run are complete; can be called again, with a later one.

        Pauses at that tick are included. It returns earlier if a component ends the run: `ended`.
        """
        ticking = self._ticking
        assert ticking is not None
        self._stopped = False
        with self._timed():
            self._run_until(ticking, tick)

    def _run_until(self, ticking: Ticking, tick: int) -> None:
        while self.pauses and self.pauses[0][0] <= tick and not (self.ended or self._stopped):
            end, act = self.pauses[0]
            ticking.run(end, self._look)
            self._clock.time = self.time
            if not (self.ended or self._stopped):
                self.pauses.pop(0)
                act()
        if not (self.ended or self._stopped):
            ticking.run(tick, self._look)
        self._clock.time = self.time
