"""Join steps of FMUs that share a process into batches: one message for all that follow each other in a tick."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from lockstep.errors import EndOfSimulation, RunError
from lockstep.faults.inject import Faults
from lockstep.fmi.slave import DTYPES, SCALARS, Buffer, Scalar, Slave, regular_end
from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import Task
from lockstep.plan.transfer import SetValue, linear
from lockstep.processes.connection import Connection
from lockstep.processes.remote_batch import BatchedStep, Inputs, Outputs, RemoteBatch
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.run.input_signals import InputSignals
from lockstep.system.clock import seconds
from lockstep.tick.operations import Answer, Block, Request, StartedStep

MOST_JOINED = 20_000  # steps in all batches, which take time and memory to bind: a cycle may have as many ticks

CheckFinite = Callable[[str, Sequence[int], Buffer, float], None]  # component, references, values, time when true [s]
Sets = Mapping[Scalar, Sequence[SetValue]]  # by type
End = Callable[[EndOfSimulation], None]
Bound = Block | StartedStep


class Batches:
    """The process that FMUs share, the bus in its memory, and the batches of the phases."""

    def __init__(self, connection: Connection, slaves: Mapping[str, Slave]) -> None:
        self._connection = connection
        self._slaves = {
            name: slave
            for name, slave in slaves.items()
            if isinstance(slave, RemoteSlave) and slave.connection is connection  # without adapter and shadow
        }
        self._bus: dict[Scalar, Buffer] = {}
        self._places: dict[Scalar, tuple[int, int]] = {}
        self._described: dict[tuple[object, ...], BatchedStep] = {}
        self._members: frozenset[str] = frozenset()
        self._count = 0  # of the steps that are joined
        self._made: dict[tuple[int, ...], StartedStep] = {}  # by the steps that are joined
        self._check_finite: CheckFinite
        self._refuse_overflow: CheckFinite
        self._end: End

    def bus(self, scalar: Scalar, size: int) -> Buffer:
        """Return memory for the values of a type on the bus, which the worker sees too unless they are texts."""
        if scalar == "String":
            return np.zeros(size, DTYPES[scalar])
        try:
            offset, array = self._connection.array(scalar, max(1, size))
        except MemoryError as error:
            raise RunError(f"{', '.join(self._slaves)}: {error}") from None
        self._bus[scalar], self._places[scalar] = array, (offset, max(1, size))
        array[:] = 0
        return array[:size]

    def report_to(self, check_finite: CheckFinite, refuse_overflow: CheckFinite, end: End) -> None:
        """Set what judges outputs and converted inputs that are not finite, and what takes a component's end."""
        self._check_finite, self._refuse_overflow, self._end = check_finite, refuse_overflow, end

    def members(self, layout: Layout, faults: Faults | None, inputs: InputSignals) -> frozenset[str]:
        """Return the components whose steps can be joined.

        Not those with faults or inputs from files, which the master sets; nor texts, tables and changes of type, which
        it converts.
        """
        kept = {name for name in self._slaves if inputs.feed(name) or (faults is not None and faults.act_on(name))}
        self._members = frozenset(name for name in self._slaves if name not in kept and is_plain(layout, name))
        return self._members

    def described(
        self, layout: Layout, task: Task, tick: int, key: tuple[object, ...], sets: Callable[[], Sets]
    ) -> BatchedStep:
        """Return what a step does that can be joined; `key` is equal for those of a component that do the same."""
        links = layout.renewed(task, tick)
        fresh = [link.producer for link, version in links if version >= layout.schedule.task(link.producer).begun(tick)]
        key = (*key, *fresh)
        if key not in self._described:
            length = seconds(task.period * layout.schedule.tick)
            fetched = [(scalar, *layout.fetched(task.name, scalar, task.begun(tick))) for scalar in SCALARS]
            self._described[key] = BatchedStep(
                name=task.name,
                length=length,
                end=length if task.continuous else 0.0,
                inputs=tuple(_inputs(scalar, entries) for scalar, entries in sets().items()),
                outputs=tuple(Outputs(scalar=s, start=start, references=tuple(r)) for s, start, r in fetched if r),
                fresh=frozenset(fresh),
                read=frozenset(link.producer for link, _ in links),
            )
        return self._described[key]

    def joined(self, steps: Iterable[tuple[Task, Bound | BatchedStep]]) -> Iterator[tuple[tuple[Task, ...], Bound]]:
        """Yield the steps of one tick, those that follow each other joined."""
        waiting: list[tuple[Task, BatchedStep]] = []
        for task, step in steps:
            if isinstance(step, BatchedStep):
                waiting.append((task, step))
                continue
            yield from self._batch(waiting)
            waiting = []
            yield (task,), step
        yield from self._batch(waiting)

    def _batch(self, waiting: Sequence[tuple[Task, BatchedStep]]) -> Iterator[tuple[tuple[Task, ...], Bound]]:
        if len(waiting) > 1 and tuple(id(step) for _, step in waiting) not in self._made:
            self._count += len(waiting)
            if self._count > MOST_JOINED:
                for each in waiting:
                    yield from self._batch([each])
                return
        if not waiting:
            return
        tasks, steps = tuple(task for task, _ in waiting), [step for _, step in waiting]
        key = tuple(map(id, steps))
        if not self._made:
            for name in self._members:
                self._slaves[name].flush()  # what waits for its next step
        if key not in self._made:
            parts = [(self._slaves[step.name], step) for step in steps]
            batch = RemoteBatch(self._connection, self._places, parts, self)
            read = frozenset[str]().union(*(step.read for step in steps))
            joined = " + ".join(task.name for task in tasks)
            begin = Request(requested=batch, call=batch.start_step, component=joined)
            finish = Answer(requested=batch, call=partial(_complete, batch), component=joined)
            self._made[key] = StartedStep(begin=(begin,), finish=(finish,), reads=read)
        yield tasks, self._made[key]

    def step_failed(self, step: BatchedStep, outcome: str, time: float, *, ended: bool) -> None:
        """Raise RunError, unless the FMU asked for the end with a complete step."""
        end = regular_end(outcome, step.name, time, step.length) if ended else None
        if end is not None:
            self._end(end)
            return
        message = self._slaves[step.name].last_messages()
        raise RunError(f"{step.name}: {outcome} at {time:.9g} s" + (f": {message}" if message else ""))

    def not_finite(self, step: BatchedStep, outputs: Outputs, time: float) -> None:
        """Judge outputs of a step."""
        if outputs.scalar == "Real":
            values = self._bus["Real"][outputs.start : outputs.start + len(outputs.references)]
            if not np.isfinite(values).all():
                self._check_finite(step.name, outputs.references, values, time + step.end)

    def overflow(self, step: BatchedStep, inputs: Inputs, time: float) -> None:
        """Refuse converted inputs of a step that are not finite."""
        if inputs.gain is None or inputs.bias is None:
            return
        values = self._bus["Real"][np.array(inputs.positions, np.intp)]
        found = np.array(inputs.gain) * values + np.array(inputs.bias)
        if not np.isfinite(found).all():
            self._refuse_overflow(step.name, inputs.references, found, time)


def _complete(batch: RemoteBatch, _time: float) -> None:
    batch.complete()


def is_plain(layout: Layout, name: str) -> bool:
    """Return whether values reach and leave a component unchanged, or as gain * value + bias."""
    groups = (layout.used[name], layout.recorded.get(name, ()), layout.held.get(name, ()))
    if any(scalar == "String" for group in groups for scalar, _ in group):
        return False
    targets = [(link.target_scalar or link.scalar, link.ways) for link in layout.feeding[name]]
    return all(
        target != "String" and (all(way.is_identity(target) for way in ways) or linear(ways, target))
        for target, ways in targets
    )


def _inputs(scalar: Scalar, entries: Sequence[SetValue]) -> Inputs:
    """Describe a set of a component whose steps can be joined."""
    found = Inputs(
        scalar=scalar,
        references=tuple(entry.target for entry in entries),
        positions=tuple(entry.position for entry in entries),
    )
    if all(entry.way.is_identity(scalar) for entry in entries):
        return found
    gain, bias = (tuple(getattr(entry.way, part) for entry in entries) for part in ("gain", "bias"))
    return replace(found, gain=gain, bias=bias)
