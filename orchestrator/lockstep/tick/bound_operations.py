"""Bind operations in Python: a block becomes one function, the usual sequences of operations one each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lockstep.fmi.slave import SCALARS
from lockstep.tick.operations import (
    Action,
    Alter,
    Answer,
    Begin,
    Block,
    Capture,
    Convert,
    Finish,
    Finite,
    Gather,
    Operation,
    Pace,
    Program,
    Python,
    Request,
    Step,
    Transfer,
)

Segment = tuple[Operation, ...]  # of one bound function


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
        return _step(step, [bound(part) for part in parts[:place]], [bound(part) for part in parts[place + 1 :]])
    calls = [bound(part) for part in parts]
    return calls[0] if len(calls) == 1 else in_turn(calls)


def in_turn(calls: Sequence[Action]) -> Action:
    """Return a function that calls several."""
    every = tuple(calls)

    def all_of_them(time: float) -> None:
        for call in every:
            call(time)

    return all_of_them


def bound(part: Segment) -> Action:
    """Return the function of a segment."""
    match part:
        case (Python() | Alter() | Pace() | Request() | Answer() as called,):
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
    return bound((operation,))


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

    def unconverted(time: float) -> None:
        take(index, None, buffer, "clip")
        status = call()
        if status:
            judge(time, status)

    return unconverted


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

    def unconverted(time: float) -> None:
        status = call()
        if status:
            judge(time, status)

    return unconverted


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
