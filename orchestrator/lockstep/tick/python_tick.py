"""Execute a program in Python: the reference for the tick in C, and what runs where that cannot be had."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import cycle, islice
from time import perf_counter

import numpy as np

from lockstep.tick.accounts import REST, Accounts
from lockstep.tick.bound_operations import actions, bound, segments
from lockstep.tick.operations import (
    Action,
    Block,
    Clock,
    Program,
    Times,
)
from lockstep.tick.structures import Reason

LOOK_INTERVAL = 0.1  # [s] of wall time between two looks around
_FEW = 10  # ticks between two looks: a step of one of them may take long


class PythonTick:
    """Execute a program in Python: the reference for the tick in C."""

    threads = 1

    def __init__(self, program: Program, times: Times, first: int, clock: Clock, *, measured: bool = False) -> None:
        """Bind the program; if `measured`, note where the wall time goes, which takes some 0.2 us an operation."""
        self.done = first
        self._times, self._clock, self._ending = times, clock, False
        self._charged = Charged(Accounts(program)) if measured else None
        self._phases = actions(program) if self._charged is None else actions(program, self._charged.action)
        self._due = 0.0  # on the wall clock [s]
        self._slow, self._looked = True, first  # whether ticks may be slow, and the tick of the last look
        self._in_tick = False

    def run(self, until: int, look: Action) -> None:
        """Execute ticks."""
        self._ending = False
        if self._charged is not None:
            self._charged.last = perf_counter()
        try:
            with np.errstate(over="ignore"):  # a value that overflows ends the run by name, without a warning before
                self._run(until, look)
        finally:
            if self._charged is not None:
                self._charged.to_rest()

    def _run(self, until: int, look: Action) -> None:
        clock, events, phases = perf_counter, self._clock, self._phases
        origin, length, second = self._times.origin, self._times.length, self._times.second
        self._due = self._due or clock() + LOOK_INTERVAL
        due = self._due
        first = self.done
        start = first % len(phases)
        following = islice(cycle(phases), start, None) if until > first + 1 else phases[start : start + 1]
        for tick, phase in zip(range(first, until), following, strict=False):
            self.done = tick
            events.time = time = (origin + tick * length) / second
            if self._slow:
                self._carefully(phase, time, look)
                due = self._due
            else:
                for call in phase:
                    call(time)
            self.done = tick + 1  # the tick is complete: every recorded row lies before the simulated time
            if self._ending:
                break
            if self._charged is not None:
                self._charged.to_rest()
            if clock() >= due:
                self._slow = tick - self._looked < _FEW
                self._looked = tick
                look(time)
                self._due = due = clock() + LOOK_INTERVAL

    def _carefully(self, phase: Sequence[Action], time: float, look: Action) -> None:
        """Execute a tick that may take long, and look around between its steps too."""
        self._in_tick = True
        for place, call in enumerate(phase, 1):
            call(time)
            if place < len(phase) and perf_counter() >= self._due:
                look(time)
                self._due = perf_counter() + LOOK_INTERVAL
        self._in_tick = False

    def stepper(self, last: int) -> Callable[[], int]:
        """Return a function that leaves the step to `go_on`."""
        return lambda: Reason.AT_LAST if self.done >= last else Reason.LOOK

    def go_on(self, _reason: int, look: Action) -> None:
        """Execute one tick."""
        self.run(self.done + 1, look)

    def settle(self) -> None:
        """Do nothing."""

    @property
    def in_tick(self) -> bool:
        """Whether a tick has begun and is not complete."""
        return self._in_tick

    def go_back(self, tick: int) -> None:
        """Continue at a tick."""
        self.done, self._looked, self._ending, self._in_tick = tick, tick, False, False

    def end_after_tick(self) -> None:
        """End the run when the present tick is complete."""
        self._ending = True

    def measured(self) -> float:
        """Return the wall time of the ticks, if it is measured."""
        return 0.0 if self._charged is None else sum(self._charged.spent)

    def spent(self) -> dict[str, float]:
        """Return the wall time by account, if it is measured."""
        return {} if self._charged is None else self._charged.accounts.named(self._charged.spent)

    def close(self) -> None:
        """Do nothing."""


class Charged:
    """Functions of blocks that charge the time of each operation to an account."""

    def __init__(self, accounts: Accounts) -> None:
        self.accounts, self.spent = accounts, [0.0] * len(accounts)
        self.last = 0.0  # on the wall clock: up to when all is charged [s]

    def to_rest(self) -> None:
        """Charge what has passed to the rest."""
        now = perf_counter()
        self.spent[REST] += now - self.last
        self.last = now

    def action(self, block: Block) -> Action:
        """Return one function that executes a block."""
        calls = tuple((bound(part), self.accounts.of(part)) for part in segments(block))
        clock, spent = perf_counter, self.spent

        def charged(time: float) -> None:
            for call, account in calls:
                call(time)
                now = clock()
                spent[account] += now - self.last
                self.last = now

        return charged
