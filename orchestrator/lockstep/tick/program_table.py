"""Pack blocks of operations into the structures of C. What C cannot do becomes an operation of its caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from ctypes import addressof, c_void_p
from dataclasses import dataclass, field
from time import get_clock_info
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.native_call import Move, NativeCall, native, step_apart
from lockstep.fmi.slave import SCALARS
from lockstep.tick.accounts import Accounts
from lockstep.tick.bound_operations import Segment, action, segments
from lockstep.tick.operations import (
    ALWAYS,
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
    Judge,
    Operation,
    Pace,
    Program,
    Python,
    Request,
    Requested,
    Step,
    Transfer,
)
from lockstep.tick.structures import Kind, TickOperation

_CALLS = {"values": Kind.VALUES, "arrays": Kind.ARRAYS, "step_1": Kind.STEP_1, "step_2": Kind.STEP_2,
          "step_3": Kind.STEP_3}  # fmt: skip
_RECORDS = {"Real": Kind.RECORD_REALS, "Integer": Kind.RECORD_INTEGERS, "Boolean": Kind.RECORD_INTEGERS,
            "Int64": Kind.RECORD_WIDE, "UInt64": Kind.RECORD_WIDE}  # fmt: skip
_GATHERS = {4: Kind.GATHER_4, 8: Kind.GATHER_8}  # by the bytes of a value
_SCATTERS = {4: Kind.SCATTER_4, 8: Kind.SCATTER_8}
_SHORTEST_RUN = 8  # neighbours on the average; shorter runs are copied value by value


@dataclass(slots=True, kw_only=True)
class Packed:
    """One operation of C: the values of its fields, and what Python does where C returns at it."""

    kind: Kind
    fields: dict[str, Any] = field(default_factory=dict)  # arrays stand for their addresses
    act: Action | None = None  # of a CALLER, or at a value that is not finite
    judge: Judge | None = None  # of a call
    after: Callable[[], int] | None = None  # of a CALLER: the next tick in which it acts
    records: bool = False  # a CALLER that adds a row of the recorder
    job: str = ""  # the component whose step begins or is finished
    account: int = 0
    requested: Requested | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramTable:
    """A whole program for C. It keeps all memory alive that C uses."""

    entries: list[Packed]
    operations: Any  # array of TickOperation
    order: NDArray[np.uint32]
    begins: NDArray[np.uint64]
    ends: NDArray[np.uint64]
    jobs: tuple[str, ...]  # the components whose steps threads may make, by number
    requests: tuple[Requested, ...]  # by number
    sizes: dict[int, int]  # how many operations each block has, by identity


def table_of(program: Program, accounts: Accounts) -> ProgramTable:
    """Return the table of a program; equal ticks share their part of it."""
    entries: list[Packed] = []
    jobs: dict[str, int] = {}
    requests: dict[int, tuple[int, Requested]] = {}
    numbers: dict[int, list[int]] = {}  # of the operations of each block, by identity: the program keeps them alive
    order: list[int] = []
    spans: dict[tuple[int, ...], tuple[int, int]] = {}
    places = []
    for blocks in program.ticks:
        key = tuple(map(id, blocks))
        if key not in spans:
            begin = len(order)
            for block in blocks:
                if id(block) not in numbers:
                    made = [_numbered(entry, jobs, requests) for entry in packed_block(block, accounts)]
                    numbers[id(block)] = list(range(len(entries), len(entries) + len(made)))
                    entries += made
                order += numbers[id(block)]
            spans[key] = (begin, len(order))
        places.append(spans[key])
    return ProgramTable(
        entries=entries,
        operations=_structures(entries),
        order=np.array(order or [0], np.uint32),
        begins=np.array([begin for begin, _ in places], np.uint64),
        ends=np.array([end for _, end in places], np.uint64),
        jobs=tuple(jobs),
        requests=tuple(requested for _, requested in requests.values()),
        sizes={block: len(made) for block, made in numbers.items()},
    )


def _numbered(entry: Packed, jobs: dict[str, int], requests: dict[int, tuple[int, Requested]]) -> Packed:
    """Give an entry the number of its job, or of what it requests."""
    if entry.requested is not None:
        entry.fields["part"], _ = requests.setdefault(id(entry.requested), (len(requests), entry.requested))
    if entry.job:
        entry.fields["part"] = jobs.setdefault(entry.job, len(jobs))
    return entry


def packed_block(block: Block, accounts: Accounts) -> Iterator[Packed]:
    """Yield the operations of a block; neighbours that are the caller's are one."""
    waiting: list[Operation] = []
    for part in segments(block):
        made = _segment(part)
        if made is None:
            waiting += part
            continue
        if waiting:
            yield _caller(waiting, accounts)
            waiting = []
        for packed in made:
            packed.account = accounts.of(part)
            yield packed
    if waiting:
        yield _caller(waiting, accounts)


def _caller(operations: Sequence[Operation], accounts: Accounts) -> Packed:
    records = any(isinstance(operation, Capture) for operation in operations)
    act, account = action(tuple(operations)), accounts.of(operations)
    return Packed(kind=Kind.CALLER, act=act, records=records, account=account)


def _segment(part: Segment) -> list[Packed] | None:
    """Return the operations of C for a segment, None if the caller has to do it."""
    found: list[Packed] = []
    for operation in part:
        made = _operation(operation)
        if made is None:
            return None
        found += made
    return found


def _operation(operation: Operation) -> list[Packed] | None:
    fields: dict[str, Any]
    match operation:
        case Gather():
            width = operation.buffer.dtype.itemsize
            if operation.buffer.dtype == object:
                return None
            return _gathered(operation.source, operation.index, operation.buffer, _GATHERS[width])
        case Convert():
            count = len(operation.buffer)
            fields = {"buffer": operation.buffer, "first": operation.gain, "second": operation.bias, "count": count}
            return [Packed(kind=Kind.CONVERT, fields=fields, act=operation.refuse)]
        case Finite():
            fields = {"buffer": operation.buffer, "marks": operation.reported, "count": len(operation.buffer)}
            return [Packed(kind=Kind.FINITE, fields=fields, act=operation.report)]
        case Alter():
            return [_altered(operation)]
        case Transfer() | Step():
            return _calls(operation)
        case Begin():
            return _begun(operation)
        case Finish():
            name, judge = operation.step.component, _judge_of(operation.step)
            return [] if judge is None else [Packed(kind=Kind.FINISH, job=name, judge=judge)]
        case Request() | Answer():
            return [_requested(operation)]
        case Capture():
            return _capture(operation)
        case Pace():
            if get_clock_info("perf_counter").implementation != "clock_gettime(CLOCK_MONOTONIC)":
                return None  # the clocks of Python and of C have to be the same
            fields = {"buffer": operation.numbers, "first": operation.edges, "marks": operation.counts,
                      "count": len(operation.edges)}  # fmt: skip
            return [Packed(kind=Kind.PACE, fields=fields)]
        case Python():
            if (operation.first, operation.last, operation.following) == (0, ALWAYS, None):
                return None  # joined with its neighbours
            fields = {"from_": operation.first, "until": operation.last}
            return [Packed(kind=Kind.CALLER, fields=fields, act=operation.call, after=operation.following)]
    return None


def _move_kind(move: Move) -> Kind:
    widths = (move.source.dtype.itemsize, move.buffer.dtype.itemsize)
    if widths[0] != widths[1]:
        return Kind.NARROW if move.scatter else Kind.WIDEN
    return (_SCATTERS if move.scatter else _GATHERS)[widths[0]]


def _runs(index: NDArray[np.intp]) -> list[tuple[int, int, int]] | None:
    """Return where runs of neighbours begin, where they come from, and how long they are; None where they are short."""
    edges = np.flatnonzero(np.diff(index) != 1) + 1
    if (len(edges) + 1) * _SHORTEST_RUN > len(index) and len(edges):
        return None
    begins = [0, *edges.tolist()]
    return [(k, int(index[k]), end - k) for k, end in zip(begins, [*begins[1:], len(index)], strict=True) if end > k]


def _gathered(source: NDArray[Any], index: NDArray[np.intp], buffer: NDArray[Any], kind: Kind) -> list[Packed]:
    runs = _runs(index)
    if runs is None:
        return [_moved(source, index, buffer, kind)]
    parts = [(source[place : place + count], buffer[k : k + count]) for k, place, count in runs]
    return [
        Packed(kind=Kind.COPY, fields={"source": part, "buffer": target, "count": target.nbytes})
        for part, target in parts
    ]


def _moved(source: NDArray[Any], index: NDArray[np.intp], buffer: NDArray[Any], kind: Kind) -> Packed:
    fields = {"source": source, "index": index.astype(np.int64), "buffer": buffer, "count": len(index)}
    return Packed(kind=kind, fields=fields)


def _altered(alter: Alter) -> Packed:
    fields: dict[str, Any] = {"buffer": alter.buffer, "index": alter.index.astype(np.int64), "count": len(alter.index)}
    fields |= {"from_": alter.first, "until": alter.last}
    if alter.amounts is not None:
        kind = Kind.ADD if alter.kind == "add" else Kind.MULTIPLY
        return Packed(kind=kind, fields=fields | {"first": alter.amounts})
    wide = alter.buffer.dtype.itemsize == 8
    kinds = {"hold": (Kind.HOLD_4, Kind.HOLD_8), "delay": (Kind.DELAY_4, Kind.DELAY_8)}[alter.kind]
    return Packed(kind=kinds[wide], fields=fields | {"memory": alter.values, "history": alter.history})


def _calls(operation: Transfer | Step) -> list[Packed] | None:
    """Return the calls and moves that make a bound call, if it has a description."""
    parts = native(operation.call)
    if parts is None:
        return None
    length = operation.length if isinstance(operation, Step) else 0.0
    found = []
    for part in parts:
        if isinstance(part, Move):
            found.append(_moved(part.source, part.index, part.buffer, _move_kind(part)))
            continue
        found.append(Packed(kind=_CALLS[part.kind], fields=_call(part, length), judge=_judged(part, operation.judge)))
    return found


def _begun(operation: Begin) -> list[Packed] | None:
    step = operation.step
    found, judge = step_apart(step.call), _judge_of(step)
    if found is None:
        return None
    fields = _call(found[0], step.length) | {"values": _CALLS[found[0].kind]}
    return [Packed(kind=Kind.BEGIN, fields=fields, judge=judge, job=step.component)]


def _requested(operation: Request | Answer) -> Packed:
    requested = operation.requested
    fields = {"instance": addressof(requested.connection.link), "count": requested.number, "length": requested.length}
    kind = Kind.REQUEST if isinstance(operation, Request) else Kind.ANSWER
    return Packed(kind=kind, fields=fields, act=operation.call, requested=requested)


def _judge_of(step: Step) -> Judge | None:
    """Return what judges a step in a thread; None if no thread makes it."""
    found = step_apart(step.call)
    return None if found is None else _judged(found[0], step.judge)


def _call(call: NativeCall, length: float) -> dict[str, Any]:
    fields: dict[str, Any] = {"function": call.function, "instance": call.instance, "length": length}
    if call.references is not None:
        fields |= {"references": call.references, "count": len(call.references)}
    if call.buffer is not None:
        fields |= {"buffer": call.buffer, "values": len(call.buffer)}
    return fields | ({} if call.flags is None else {"marks": call.flags})


def _judged(call: NativeCall, judge: Judge) -> Judge:
    def judged(time: float, status: int) -> None:
        call.note(status)
        judge(time, status)

    return judged


def _capture(capture: Capture) -> list[Packed] | None:
    if len(capture.index["String"]):
        return None
    found = [Packed(kind=Kind.ROW)]
    for part, scalar in enumerate(SCALARS[:-1]):
        index = capture.index[scalar].astype(np.int64)
        runs = None if _RECORDS[scalar] == Kind.RECORD_INTEGERS else _runs(index)
        if runs is not None:
            for k, place, count in runs:
                fields = {"part": part, "values": k, "source": capture.sources[scalar][place : place + count],
                          "count": count}  # fmt: skip
                found.append(Packed(kind=Kind.RECORD_COPY, fields=fields))
        elif len(index):
            fields = {"part": part, "source": capture.sources[scalar], "index": index, "count": len(index)}
            found.append(Packed(kind=_RECORDS[scalar], fields=fields))
    return found


def _structures(entries: Sequence[Packed]) -> Any:
    made = (TickOperation * max(1, len(entries)))()
    for structure, entry in zip(made, entries, strict=False):
        structure.kind, structure.account = entry.kind, entry.account
        structure.until = ALWAYS
        for name, value in entry.fields.items():
            setattr(structure, name, address(value) if isinstance(value, np.ndarray) else value)
    return made


def address(array: NDArray[Any]) -> c_void_p | int:
    """Return where an array begins in memory."""
    if not array.flags.c_contiguous:
        raise ValueError("C needs contiguous memory")
    return array.ctypes.data
