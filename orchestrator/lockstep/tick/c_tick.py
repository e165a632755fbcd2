"""Execute a program in C, and in Python where that returns: calls of its own, failures, full rows, looks around."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import addressof, c_int64, c_void_p
from functools import partial
from threading import Event, Thread
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.tick.accounts import WAITING, Accounts
from lockstep.tick.compiled import load, unit_of_stamps
from lockstep.tick.operations import Action, Clock, Program, Rows, Times
from lockstep.tick.program_table import ProgramTable, address, table_of
from lockstep.tick.python_tick import LOOK_INTERVAL
from lockstep.tick.requests import Requests
from lockstep.tick.step_threads import StepThreads, ThreadLimit
from lockstep.tick.structures import PARTS, Kind, Reason, TickState


class CTick:
    """Execute a program by the library; raises NoLibrary where there is none."""

    def __init__(
        self, program: Program, times: Times, first: int, clock: Clock, rows: Rows | None, threads: ThreadLimit
    ) -> None:
        """Pack the program; `rows` is the recorder that its captures fill in."""
        library = load()
        self._run_library, self._step_library = library.tick_run, library.tick_step
        self._accounts = Accounts(program)
        self._table, self._program = table_of(program, self._accounts), program
        self._clock, self._rows = clock, rows
        self._state = state = _state(self._table, times, first)
        self._address = addressof(state)
        self._stamps: NDArray[np.uint64] = np.zeros(len(self._accounts), np.uint64)
        state.spent = address(self._stamps)
        unit_of_stamps()  # from here on the clocks are compared
        self._block: Any = None
        self._kept: list[Any] = []
        if rows is not None:
            self._use_block(rows)
        self._settled = first  # the tick to which the rows are counted in Python too
        self._watch: Watch | None = None
        self._requests = Requests(self._table.requests, state)
        self._threads: StepThreads | None = None
        if self._table.jobs:
            self._threads = StepThreads(library, self._table, program, threads, state, self._worked)

    @property
    def done(self) -> int:
        """The first tick that is not complete."""
        return int(self._state.tick)

    def _now(self) -> float:
        return float(self._state.time)

    def run(self, until: int, look: Action) -> None:
        """Execute ticks."""
        if self._watch is None:
            self._watch = Watch(self._state)
        self._state.until = until
        if self._rows is not None:
            self._use_block(self._rows)
        self._run(None, look)

    def stepper(self, last: int) -> Callable[[], int]:
        """Return a quick function that executes one tick; see `Ticking`."""
        return partial(self._step_library, c_void_p(self._address), c_int64(last))

    def go_on(self, reason: int, look: Action) -> None:
        """Complete the tick at which the function of `stepper` returned this."""
        self._run(reason, look)

    def settle(self) -> None:
        """Count the rows of the ticks that the function of `stepper` has executed."""
        state = self._state
        if self._rows is not None and state.tick != self._settled:
            self._rows.count = state.rows.count
        self._settled = state.tick

    def _run(self, reason: int | None, look: Action) -> None:
        state, rows, run, place = self._state, self._rows, self._run_library, self._address
        self._clock.follow(self._now)
        threads = self._threads
        try:
            if reason is None:
                reason = run(place)
            if reason != Reason.DONE:
                with np.errstate(over="ignore"):  # as in Python: a value that overflows ends the run by name
                    while reason != Reason.DONE:
                        self._handle(reason, look)
                        reason = run(place)
        except BaseException as error:
            self._requests.stop()
            if threads is not None:
                threads.stop(error)
            raise
        finally:
            self._clock.time = state.time
            self._clock.follow(None)
            state.stamp = 0  # what passes until the next call is not the loop's
            if rows is not None:
                rows.count = state.rows.count
            self._settled = state.tick

    def _handle(self, reason: int, look: Action) -> None:
        """Do what C returned for."""
        state = self._state
        self._clock.time = time = state.time
        if reason == Reason.LOOK:
            state.look = 0
            look(time)
            self._requests.look()
            if self._threads is not None:
                self._threads.look()
            return
        number = self._table.order[state.position]
        entry, rows = self._table.entries[number], self._rows
        if reason == Reason.ROWS_FULL:
            assert rows is not None
            rows.count = state.rows.count
            try:
                rows.next_block()
            finally:
                self._use_block(rows)
            return
        if entry.kind == Kind.FINISH:
            assert self._threads is not None
            self._threads.finish(self._table.operations[number].part, time)
        elif entry.requested is not None:
            self._requests.act(entry, self._table.operations[number].part, time)
        elif reason == Reason.STATUS:
            assert entry.judge is not None
            entry.judge(time, state.status)
        else:
            assert entry.act is not None
            if entry.records and rows is not None:
                rows.count = state.rows.count
                try:
                    entry.act(time)
                finally:
                    self._use_block(rows)
            else:
                entry.act(time)
            if entry.after is not None:
                self._table.operations[number].from_ = entry.after()
        state.position += 1

    def _use_block(self, rows: Rows) -> None:
        """Go on where the recorder is: Python may have added rows, and begun another block."""
        if rows.block is not self._block:
            self._block, self._kept = rows.block, _set_rows(self._state, rows)
        self._state.rows.count = rows.count

    def measured(self) -> float:
        """Return the wall time of the ticks."""
        return int(self._stamps.sum()) * unit_of_stamps()

    def _worked(self) -> float:
        """Return the wall time of the ticks without what they waited for real time."""
        return (int(self._stamps.sum()) - int(self._stamps[WAITING])) * unit_of_stamps()

    def spent(self) -> dict[str, float]:
        """Return the wall time by account."""
        return self._accounts.named((self._stamps * unit_of_stamps()).tolist())

    @property
    def in_tick(self) -> bool:
        """Whether a tick has begun and is not complete."""
        return bool(self._state.begun)

    def go_back(self, tick: int) -> None:
        """Continue at a tick."""
        self._state.tick, self._state.begun = tick, 0
        for number, entry in enumerate(self._table.entries):
            if entry.after is not None:  # it may act again
                self._table.operations[number].from_ = entry.fields["from_"]
        self._settled = tick
        if self._rows is not None:
            self._state.rows.count = self._rows.count

    def end_after_tick(self) -> None:
        """End the run when the present tick is complete."""
        self._state.until = self._state.tick + 1

    def close(self) -> None:
        """Stop what looks at the clock."""
        if self._watch is not None:
            self._watch.stop()
        if self._threads is not None:
            self._threads.close()

    @property
    def threads(self) -> int:
        """How many threads have stepped components, the master's included."""
        return 1 if self._threads is None else self._threads.used


class Watch:
    """Ask C to return about ten times in a second: a thread, as reading a clock at each operation would cost more."""

    def __init__(self, state: TickState) -> None:
        self._state, self._stopped = state, Event()
        self._thread = Thread(target=self._ask, name="tick-watch", daemon=True)
        self._thread.start()

    def _ask(self) -> None:
        while not self._stopped.wait(LOOK_INTERVAL):
            self._state.look = 1

    def stop(self) -> None:
        """End the thread."""
        self._stopped.set()
        self._thread.join()


def _state(table: ProgramTable, times: Times, first: int) -> TickState:
    state = TickState()
    state.operations = addressof(table.operations)
    state.order, state.begins, state.ends = (address(a) for a in (table.order, table.begins, table.ends))
    state.cycle = len(table.begins)
    state.origin, state.length, state.second = times.origin, times.length, float(times.second)
    state.tick = first
    return state


def _set_rows(state: TickState, rows: Rows) -> list[Any]:
    """Set the memory of the recorder's rows, and return it: it has to stay."""
    times, parts = rows.block.times, rows.block.parts
    state.rows.times, state.rows.size, state.rows.count = address(times), len(times), rows.count
    for number, part in enumerate(parts[:PARTS]):
        state.rows.parts[number] = part.ctypes.data
        state.rows.strides[number] = part.strides[0] // part.itemsize if part.size else 0
    return [times, *parts]
