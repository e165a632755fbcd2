"""Execute operations in Python: a block becomes a tuple of bound functions, the usual sequences of operations one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import cycle, islice
from time import perf_counter
from typing import Any

import numpy as np

from lockstep.fmi.slave import SCALARS
from lockstep.tick.accounts import REST, Accounts
from lockstep.tick.operations import (
    Action,
    Alter,
    Begin,
    Block,
    Capture,
    Clock,
    Convert,
    Finish,
    Finite,
    Gather,
    Operation,
    Pace,
    Program,
    Python,
    Step,
    Times,
    Transfer,
)
from lockstep.tick.structures import Reason

LOOK_INTERVAL = 0.1  # [s] of wall time between two looks around
Segment = tuple[Operation, ...]  # of one bound function


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
        self._last = 0.0  # [s] that the last tick took at most

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
            for call in phase:
                call(time)
            self.done = tick + 1  # the tick is complete: every recorded row lies before the simulated time
            if self._ending:
                break
            if self._charged is not None:
                self._charged.to_rest()
            if clock() >= due:
                look(time)
                self._due = due = clock() + LOOK_INTERVAL

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
        """False: it looks after ticks alone."""
        return False

    def go_back(self, tick: int) -> None:
        """Continue at a tick."""
        self.done, self._ending = tick, False

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
        calls = tuple((_bound(part), self.accounts.of(part)) for part in segments(block))
        clock, spent = perf_counter, self.spent

        def charged(time: float) -> None:
            for call, account in calls:
                call(time)
                now = clock()
                spent[account] += now - self.last
                self.last = now

        return charged


def actions(program: Program, bind: Callable[[Block], Action] | None = None) -> list[tuple[Action, ...]]:
    """Return the functions of every tick of the cycle, one for each block: as `action` binds them, or another."""
    bind = bind or action
    bound: dict[int, Action] = {}  # by the identity of a block, all of which the program keeps alive
    ticks: dict[tuple[int, ...], tuple[Action, ...]] = {}
    found = []
    for blocks in program.ticks:
        key = tuple(map(id, blocks))
        if key not in ticks:
            for block in blocks:
                if id(block) not in bound:
                    bound[id(block)] = bind(block)
            ticks[key] = tuple(bound[number] for number in key)
        found.append(ticks[key])
    return found


def segments(block: Block) -> list[Segment]:
    """Divide a block where a function of it may begin: before each set, step, get and call."""
    found: list[list[Operation]] = []
    last: Operation | None = None
    for operation in block:
        match operation:
            case Convert():
                joined = isinstance(last, Gather)
            case Transfer():
                joined = isinstance(last, Gather | Convert) and last.buffer is operation.buffer
            case Finite():
                joined = isinstance(last, Transfer)
            case _:
                joined = False
        if joined:
            found[-1].append(operation)
        else:
            found.append([operation])
        last = operation
    return [tuple(part) for part in found]


def action(block: Block) -> Action:
    """Return one function that executes a block; a step that begins is made at once."""
    block = tuple(op.step if isinstance(op, Begin) else op for op in block if not isinstance(op, Finish))
    parts = segments(block)
    steps = [k for k, part in enumerate(parts) if isinstance(part[0], Step)]
    if len(steps) == 1 and len(parts) > 1:
        (place,) = steps
        step = parts[place][0]
        assert isinstance(step, Step)
        return _step(step, [_bound(part) for part in parts[:place]], [_bound(part) for part in parts[place + 1 :]])
    calls = [_bound(part) for part in parts]
    return calls[0] if len(calls) == 1 else in_turn(calls)


def in_turn(calls: Sequence[Action]) -> Action:
    """Return a function that calls several."""
    every = tuple(calls)

    def all_of_them(time: float) -> None:
        for call in every:
            call(time)

    return all_of_them


def _bound(part: Segment) -> Action:
    """Return the function of a segment."""
    match part:
        case (Python() | Alter() | Pace() as called,):
            return called.call
        case (Gather() as gather, Transfer() as transfer):
            return _set(gather, transfer)
        case (Gather() as gather, Convert() as convert, Transfer() as transfer):
            return _converted_set(gather, convert, transfer)
        case (Transfer() as transfer, Finite() as finite):
            return _checked_get(transfer, finite)
        case (Transfer() as transfer,):
            return _transfer(transfer)
        case (Capture() as capture,):
            return _capture(capture)
        case (Step() as step,):
            return _step(step, [], [])
    return in_turn([_single(operation) for operation in part])


def _single(operation: Operation) -> Action:
    match operation:
        case Gather():
            return _gather(operation)
        case Convert():
            return _convert(operation)
        case Finite():
            return _finite(operation)
    return _bound((operation,))


def _gather(gather: Gather) -> Action:
    take, index, buffer = gather.source.take, gather.index, gather.buffer

    def gathered(_time: float) -> None:
        take(index, None, buffer, "clip")  # clip: the other modes copy through a temporary

    return gathered


def _convert(convert: Convert) -> Action:
    buffer, gain, bias, refuse = convert.buffer, convert.gain, convert.bias, convert.refuse
    marks, finite, isfinite = _marks(len(buffer))

    def converted(time: float) -> None:
        np.multiply(buffer, gain, buffer)
        np.add(buffer, bias, buffer)
        isfinite(buffer, finite)
        if 0 in marks:
            refuse(time)

    return converted


def _set(gather: Gather, transfer: Transfer) -> Action:
    take, index, buffer = gather.source.take, gather.index, gather.buffer
    call, judge = transfer.call, transfer.judge

    def plain(time: float) -> None:
        take(index, None, buffer, "clip")
        status = call()
        if status:
            judge(time, status)

    return plain


def _converted_set(gather: Gather, convert: Convert, transfer: Transfer) -> Action:
    take, index, buffer = gather.source.take, gather.index, gather.buffer
    gain, bias, refuse = convert.gain, convert.bias, convert.refuse
    call, judge = transfer.call, transfer.judge
    marks, finite, isfinite = _marks(len(buffer))

    def converted(time: float) -> None:
        take(index, None, buffer, "clip")
        np.multiply(buffer, gain, buffer)
        np.add(buffer, bias, buffer)
        isfinite(buffer, finite)
        if 0 in marks:
            refuse(time)
        status = call()
        if status:
            judge(time, status)

    return converted


def _transfer(transfer: Transfer) -> Action:
    call, judge = transfer.call, transfer.judge

    def plain(time: float) -> None:
        status = call()
        if status:
            judge(time, status)

    return plain


def _finite(finite: Finite) -> Action:
    return _checked_get(None, finite)


def _checked_get(transfer: Transfer | None, check: Finite) -> Action:
    buffer, report, reported = check.buffer, check.report, check.reported
    marks, finite, isfinite = _marks(len(buffer))
    call: Callable[[], int] = (lambda: 0) if transfer is None else transfer.call
    judge = (lambda _time, _status: None) if transfer is None else transfer.judge

    def checked(time: float) -> None:
        status = call()
        if status:
            judge(time, status)
        isfinite(buffer, finite)
        if 0 in marks and not np.logical_or(finite, reported).all():
            report(time)

    return checked


def _step(step: Step, before: Sequence[Action], after: Sequence[Action]) -> Action:
    do_step, length, judge = step.call, step.length, step.judge
    if len(before) == 1 and len(after) == 1:  # the usual step, without the two loops
        first, last = before[0], after[0]

        def usual(time: float) -> None:
            first(time)
            status = do_step(time, length, 1)
            if status:
                judge(time, status)
            last(time)

        return usual
    sets, gets = tuple(before), tuple(after)

    def whole(time: float) -> None:
        for call in sets:
            call(time)
        status = do_step(time, length, 1)
        if status:
            judge(time, status)
        for call in gets:
            call(time)

    return whole


def _capture(capture: Capture) -> Action:
    row, reals, take = capture.row, capture.index["Real"], capture.sources["Real"].take
    others = [
        (k, capture.index[s], capture.sources[s].take)
        for k, s in enumerate(SCALARS)
        if s != "Real" and len(capture.index[s])
    ]

    def captured(time: float) -> None:
        parts = row(time)
        take(reals, None, parts[0], "clip")
        for k, places, take_other in others:
            parts[k][:] = take_other(places)

    return captured


def _marks(count: int) -> tuple[bytearray, Any, Any]:
    """Return marks as bytes, which are searched ten times faster than an array, the same as an array, and isfinite."""
    marks = bytearray(count)
    return marks, np.frombuffer(marks, np.bool_), np.isfinite
