"""The threads of a program: which steps run in them, judged now and then, and what happens when a run fails."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from ctypes import CDLL
from dataclasses import dataclass

from lockstep.errors import InputError
from lockstep.fmi.native_call import step_apart
from lockstep.interrupt import PATIENCE
from lockstep.operating_system import available_cores
from lockstep.tick.bound_operations import action
from lockstep.tick.operations import Begin, Block, Finish, Program, Step
from lockstep.tick.program_table import ProgramTable
from lockstep.tick.structures import TickState
from lockstep.tick.thread_choice import ThreadChoice
from lockstep.tick.threads import Jobs

MOST = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class ThreadLimit:
    """How many threads may step components, the master's included; 1: all steps in turn."""

    count: int
    always: bool  # in threads from the first tick on, however short the steps are
    cores: frozenset[int]

    @property
    def several(self) -> bool:
        """Whether steps may be made beside each other."""
        return self.count > 1


def threads_given(threads: int | str | None) -> ThreadLimit:
    """Return the limit of a number, or of `auto`: as many as there are cores, where it makes the run quicker."""
    cores = available_cores()
    if threads is None or threads == "auto":
        return ThreadLimit(count=len(cores), always=False, cores=frozenset(cores))
    try:
        count = int(threads)
    except (TypeError, ValueError):
        count = -1
    if not 0 <= count <= MOST or isinstance(threads, float | bool):
        raise InputError(f"threads {threads!r}: must be auto, or a whole number from 0 to {MOST}; 0 and 1: in turn")
    return ThreadLimit(count=max(1, count), always=True, cores=frozenset(cores))


class StepThreads:
    """The jobs of a packed program, and the threads that make some of them."""

    def __init__(
        self,
        library: CDLL,
        table: ProgramTable,
        program: Program,
        limit: ThreadLimit,
        state: TickState,
        worked: Callable[[], float],
    ) -> None:
        """Set the jobs in the state of the tick; threads are started where they are chosen.

        `worked` returns for how long the ticks have worked [s], waiting for real time excepted.
        """
        self._worked = worked
        self._table, self._program, self._limit, self._state = table, program, limit, state
        judges = {entry.job: entry.judge for entry in table.entries if entry.job and entry.judge}
        steps = {op.step.component: op.step for block in _blocks(program) for op in block if isinstance(op, Begin)}
        aparts = {name: found[1] for name, step in steps.items() if (found := step_apart(step.call))}
        self._jobs = Jobs(
            library, table.jobs, {name: (aparts[name], judges[name]) for name in table.jobs}, (table, program)
        )
        width, beside = _side_by_side(program, table.jobs)
        self._count = limit.count if limit.always else min(limit.count, width)
        self._choice = ThreadChoice(beside if self._count > 1 else frozenset(), int(state.tick), always=limit.always)
        self._in_order = False  # whether the error that ends the run is the first in the order of the schedule
        self.used = 1  # threads that have stepped components, the master's included
        state.jobs = self._jobs.address
        self._set(self._choice.chosen)

    def _set(self, chosen: frozenset[int]) -> None:
        if chosen and self._jobs.start(self._count, self._limit.cores):
            self._state.pool = self._jobs.pool
            self._jobs.choose(chosen)
            self.used = self._count
        elif chosen and self._limit.always:
            raise InputError(f"threads {self._count}: this system does not start them; choose threads 1")
        else:
            self._jobs.choose(frozenset())

    def look(self) -> None:
        """Judge which steps are worth a thread."""
        before = self._choice.chosen
        chosen = self._choice.look(self._worked(), self._state.tick, self._jobs.means())
        if chosen != before:
            self._set(chosen)

    def finish(self, number: int, time: float) -> None:
        """Report what a step that is complete logged, and judge its status; first of those that come before it."""
        try:
            self._finish_earlier(time, with_values=self._jobs.failed(number))
            self._jobs.finish(number, time)
        except BaseException:
            self._in_order = True
            raise

    def _finish_earlier(self, time: float, *, with_values: bool) -> None:
        """Report and judge the steps under way of components before that at which the tick stopped."""
        for name, rest in self._begun_before():
            number = self._table.jobs.index(name)
            self._jobs.complete(number)
            self._jobs.finish(number, time)
            if with_values:
                action(rest)(time)

    def stop(self, error: BaseException) -> None:
        """Wait for the steps under way after an error, or raise what comes before that in the order of the schedule."""
        try:
            if isinstance(error, Exception) and self._state.begun and not self._in_order:
                self._finish_earlier(self._state.time, with_values=True)
        finally:
            self._jobs.settle(math.inf if isinstance(error, Exception) else PATIENCE)

    def _begun_before(self) -> list[tuple[str, Block]]:
        """Return the steps under way of components before that at which the tick stopped, and what follows them."""
        table, state = self._table, self._state
        phase = state.tick % len(table.begins)
        place, begun, blocks = int(table.begins[phase]), list[str](), self._program.ticks[phase]
        for block in blocks:
            place += table.sizes[id(block)]
            first = block[0] if block else None
            if place > state.position:
                if isinstance(first, Finish) and first.step.component in begun:
                    del begun[begun.index(first.step.component) :]
                break
            if isinstance(first, Finish) and first.step.component in begun:
                begun.remove(first.step.component)
            begun += [op.step.component for op in block if isinstance(op, Begin) and op.step.component in table.jobs]
        ends = {op.step.component: block[1:] for block in blocks for op in block[:1] if isinstance(op, Finish)}
        return [(name, ends[name]) for name in begun]

    def close(self) -> None:
        """End the threads."""
        self._state.pool = None
        self._jobs.close()


def _blocks(program: Program) -> list[Block]:
    return list({id(block): block for blocks in program.ticks for block in blocks}.values())


def _side_by_side(program: Program, names: Sequence[str]) -> tuple[int, frozenset[int]]:
    """Return how many steps can run side by side, and the jobs during which another step can run."""
    found: set[str] = set()
    width = 1
    for blocks in {tuple(map(id, blocks)): blocks for blocks in program.ticks}.values():
        open_: set[str] = set()
        for block in blocks:
            for operation in block:
                if isinstance(operation, Finish):
                    open_.discard(operation.step.component)
                elif isinstance(operation, Begin | Step):
                    found |= open_
                    width = max(width, len(open_) + 1)
                    if isinstance(operation, Begin):
                        open_.add(operation.step.component)
                        if len(open_) > 1:
                            found |= open_
    return width, frozenset(number for number, name in enumerate(names) if name in found)
