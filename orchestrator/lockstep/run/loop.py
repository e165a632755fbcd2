"""The loop of ticks: a program's ticks, and actions between two of them, such as checkpoints."""

from __future__ import annotations

from collections.abc import Callable

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
            self.first = self._ticking.done
            self.threads = max(self.threads, self._ticking.threads)
            self._ticking.close()
            self._ticking = None

    def go_back(self, tick: int) -> None:
        """Continue at a tick, as if no later one had been run, and none had ended the loop."""
        assert self._ticking is not None
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
