"""Turn a memory plan into a program: for each tick of the cycle the blocks of operations that it consists of.

No scalar is handled alone in a tick: each step is one gather from the bus, one set, one doStep and one get.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import EndOfSimulation, RunError
from lockstep.faults.inject import Faults
from lockstep.fmi.native_call import step_apart
from lockstep.fmi.slave import DTYPES, SCALARS, WARNING, Buffer, Scalar, Slave, regular_end
from lockstep.plan.bus_layout import Layout, by_scalar
from lockstep.plan.schedule import Task
from lockstep.plan.transfer import SetValue, converter
from lockstep.plan.wiring import Link
from lockstep.processes.remote_batch import BatchedStep
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.run.batched_steps import Batches, is_plain
from lockstep.run.input_signals import InputSignals
from lockstep.run.not_finite import AddEvent, Names, NotFinite
from lockstep.run.overlapped_steps import Overlapping, alone, interleaved
from lockstep.run.requested_steps import requested_step
from lockstep.run.step_operations import Gets, StepOperations
from lockstep.system.clock import seconds
from lockstep.tick.operations import Begin, Block, Capture, Finish, NextRow, Program, Python, StartedStep, Step

Bound = Block | StartedStep


class Exchange:
    """The bus, and the calls of all slaves bound to it."""

    def __init__(
        self,
        layout: Layout,
        slaves: Mapping[str, Slave],
        names: Names,
        faults: Faults | None = None,
        inputs: InputSignals | None = None,
        add_event: AddEvent = lambda *_, **__: None,
        batches: Batches | None = None,
        threads: bool = False,
    ) -> None:
        """Bind nothing yet.

        `batches` joins steps of FMUs that share a process, where there are some. `threads`: steps that threads may make
        are begun and finished apart from each other.
        """
        self._threads = threads
        self._requested = frozenset(
            name
            for name in slaves
            if is_plain(layout, name)
            and not (inputs is not None and inputs.feed(name))
            and not (faults is not None and faults.act_on(name))
        )
        self._layout, self._faults, self._inputs = layout, faults, inputs or InputSignals((), 0.0)
        self.not_finite = NotFinite(layout.used, names, add_event)
        self._slaves, self._names = slaves, names
        self._start = seconds(layout.schedule.start)
        make: Callable[[Scalar, int], Buffer] = batches.bus if batches else lambda s, size: np.zeros(size, DTYPES[s])
        self._bus: dict[Scalar, Buffer] = {s: make(s, layout.bus_size(s)) for s in SCALARS}
        self.operations = StepOperations(slaves, self._bus, names, faults, self._inputs, self.check, self._check_finite)
        self._batches, self._joined = batches, frozenset[str]()
        if batches is not None:
            self._joined = batches.members(layout, faults, self._inputs)
            batches.report_to(self._check_finite, self.operations.refuse_overflow, self._end)
        self._steps: dict[object, Bound] = {}  # equal steps are one object
        self._captures: dict[object, Block] = {}
        self._initial: dict[tuple[str, Scalar], dict[int, Any]] = {}
        self.end: EndOfSimulation | None = None  # the first that a component asked for
        self.on_end: Callable[[], None] = lambda: None  # called when a complete step asks for the end

    def program(self, row: NextRow, look: Callable[[], None] = lambda: None) -> Program:
        """Return the operations of every tick of the cycle, in order; `look` is called before each is bound."""
        self._captures.clear()  # they are bound to the row of a recorder
        first: tuple[Block, ...] = ()
        if self._faults is not None:
            first = ((self._faults.at_tick,),)
        return Program(ticks=[(*first, *self._tick(tick, row, look)) for tick in range(self._layout.cycle)])

    def _tick(self, tick: int, row: NextRow, look: Callable[[], None]) -> Iterator[Block]:
        look()
        layout, tasks = self._layout, self._layout.schedule.tasks
        yield from self.in_order(tick, [(t, self.step(t, tick)) for t in tasks if t.steps_at(tick)])
        if layout.records_at(tick):
            yield self.capture(tick, row)

    def in_order(self, tick: int, steps: Iterable[tuple[Task, Bound | BatchedStep]]) -> Iterator[Block]:
        """Yield the blocks of steps in one tick."""
        joined = alone if self._batches is None else self._batches.joined
        return interleaved(self._layout, tick, joined(steps))

    @property
    def layout(self) -> Layout:
        """The memory plan."""
        return self._layout

    @property
    def faults(self) -> Faults | None:
        """The faults injected in the run."""
        return self._faults

    def finish(self) -> None:
        """Write the events of faults that end with the run."""
        if self._faults is not None:
            self._faults.finish()

    @property
    def bus(self) -> Mapping[Scalar, Buffer]:
        """All fetched outputs, by type, laid out as `Layout` says."""
        return self._bus

    def fetch_initial(self, name: str, newest: int = 0) -> None:
        """Fetch a component's initial outputs, for its readers' first inputs and for all slots up to a version."""
        self.fetch_present(name)
        for scalar in SCALARS:
            for version in range(newest + 1 - self._layout.rings[name], newest + 1):
                start, references = self._layout.fetched(name, scalar, version)
                if references:
                    self._bus[scalar][start : start + len(references)] = self.present(name, scalar, references)

    def present(self, name: str, scalar: Scalar, references: list[int]) -> Buffer:
        """Return the present outputs of a component."""
        buffer: Buffer = np.zeros(len(references), DTYPES[scalar])
        self.check(name, f"Get{scalar}", self._start, self._get(name, scalar, references, buffer)())
        if scalar == "Real" and not np.isfinite(buffer).all():
            self._check_finite(name, references, buffer, self._inputs.start_time)
        return buffer

    def fetch_present(self, name: str) -> None:
        """Fetch a component's present outputs, which `set_initial` then sets at their readers."""
        for scalar in SCALARS:
            sources = sorted(reference for kind, reference in self._layout.transferred[name] if kind == scalar)
            if sources:
                values = self.present(name, scalar, sources)
                self._initial[name, scalar] = dict(zip(sources, values.tolist(), strict=True))

    def set_initial(self, name: str) -> None:
        """Set the inputs whose producers' initial outputs have been fetched, and those of files."""
        for put in self._inputs.on_step(name, self._slaves[name], self.check):
            put(self._inputs.start_time)
        for scalar in SCALARS:
            entries: dict[int, Any] = {}
            for link in self._layout.feeding[name]:
                known = self._initial.get((link.producer, link.scalar))
                if (link.target_scalar or link.scalar) == scalar and known is not None:
                    values: NDArray[Any] = np.array([known[source] for source in link.sources], DTYPES[link.scalar])
                    convert = converter(scalar, link.ways, self.operations.labels(name, scalar, link.targets))
                    found = convert(values)
                    if scalar == "Real" and not np.isfinite(found).all():
                        self.operations.refuse_overflow(name, link.targets, found, self._start)
                    entries |= dict(zip(link.targets, found.tolist(), strict=True))
            if entries:
                targets = sorted(entries)
                buffer: Buffer = np.array([entries[target] for target in targets], DTYPES[scalar])
                call = self._slaves[name].setter(scalar, np.array(targets, np.uint32), buffer)
                self.check(name, f"Set{scalar}", self._start, call())

    def check(self, name: str, call: str, time: float, status: int, step: float = 0.0) -> None:
        """Raise RunError, with the slave's log, if a call failed; its name is without the prefix of FMI. Times in s.

        A step that asked for a regular end raises EndOfSimulation if it is not complete; else `on_end` is called.
        """
        if status <= WARNING:
            return
        slave = self._slaves[name]
        slave.failed(status)
        outcome, message = slave.outcome(call, status), slave.last_messages()
        end = regular_end(outcome, name, time, step) if call == "DoStep" else None
        if end is not None:
            self._end(end)
            return
        raise RunError(f"{name}: {outcome} at {time:.9g} s" + (f": {message}" if message else ""))

    def _end(self, end: EndOfSimulation) -> None:
        self.end = self.end or end
        if not end.complete:
            raise end
        self.on_end()

    def _get(self, name: str, scalar: Scalar, references: list[int], buffer: Buffer) -> Callable[[], int]:
        return self._slaves[name].getter(scalar, np.array(references, np.uint32), buffer)

    def step(self, task: Task, tick: int, advances: bool = True) -> Bound | BatchedStep:
        """Return a step of a component, or, where it does not advance, its sets and gets alone."""
        layout, version = self._layout, task.begun(tick)
        renewed = layout.renewed(task, tick)
        key = (
            task.name,
            advances,
            *((id(link), layout.place_of(link.producer, link.scalar, newest)) for link, newest in renewed),
            *(layout.place_of(task.name, scalar, version) for scalar in SCALARS),
        )
        if advances and self._batches is not None and task.name in self._joined:
            return self._batches.described(layout, task, tick, key, partial(self._sets, renewed))
        if key not in self._steps:
            fetched = {scalar: layout.fetched(task.name, scalar, version) for scalar in SCALARS}
            gets = {scalar: (start, references) for scalar, (start, references) in fetched.items() if references}
            self._steps[key] = self._bind(task, self._sets(renewed), gets, advances)
        return self._steps[key]

    def _sets(self, renewed: Iterable[tuple[Link, int]]) -> dict[Scalar, list[SetValue]]:
        """Return what to set of each type, the targets in ascending order."""
        sets: dict[Scalar, list[SetValue]] = {}
        for link, version in renewed:
            positions = self._layout.positions(link.producer, link.scalar, link.sources, version)
            entries = sets.setdefault(link.target_scalar or link.scalar, [])
            entries += map(SetValue, link.targets, positions, link.ways)
        return {scalar: sorted(entries, key=lambda entry: entry.target) for scalar, entries in sets.items()}

    def _bind(self, task: Task, sets: Mapping[Scalar, list[SetValue]], gets: Gets, advances: bool = True) -> Bound:
        """Return one doStep with the sets before it and the gets after it; if it does not advance, these alone."""
        name, slave = task.name, self._slaves[task.name]
        length = seconds(task.period * self._layout.schedule.tick)
        end = length if task.continuous else 0.0  # from the step's start to where its outputs are true
        if advances and name in self._requested and isinstance(slave, RemoteSlave):
            return requested_step(self.operations, slave, sets, gets, length, end, self._end)
        before, after = self.operations.before(name, sets), self.operations.after(name, gets, end)
        if not advances:
            return (*before, *after)
        judge = self.operations.judge(name, "DoStep", length)
        step = Step(component=name, call=slave.do_step, length=length, judge=judge)
        if isinstance(slave, Overlapping):
            complete = slave.complete

            def completed(_time: float) -> None:
                try:
                    complete()
                except EndOfSimulation as end:
                    self._end(end)

            return StartedStep(begin=(*before, step), finish=(Python(call=completed, component=name), *after))
        if self._threads and step_apart(step.call) is not None:
            return StartedStep(begin=(*before, Begin(step=step)), finish=(Finish(step=step), *after))
        return (*before, step, *after)

    def _check_finite(self, name: str, references: Sequence[int], values: Buffer, time: float) -> None:
        try:
            self.not_finite.check(name, references, np.asarray(values, np.float64), time)
        except RunError as error:
            logged = self._slaves[name].last_messages()  # the only report of a slave that cannot return an error
            raise RunError(f"{error}" + (f"; it logged: {logged}" if logged else "")) from None

    def capture(self, tick: int, row: NextRow) -> Block:
        """Return the copy of what is true at this tick into the recorder's next row."""
        layout, task = self._layout, self._layout.schedule.task
        parts = [(name, task(name).true_at(tick), by_scalar(refs)) for name, refs in layout.recorded.items()]
        parts += [(name, task(name).begun(tick), by_scalar(refs)) for name, refs in layout.held.items()]
        key = tuple(layout.place_of(name, s, version) for name, version, refs in parts for s in refs)
        if key not in self._captures:
            index: dict[Scalar, NDArray[np.intp]] = {}
            for scalar in SCALARS:
                of_type = [(n, refs[scalar], version) for n, version, refs in parts if scalar in refs]
                places = [place for n, refs, version in of_type for place in layout.positions(n, scalar, refs, version)]
                index[scalar] = np.array(places, np.intp)
            self._captures[key] = (Capture(index=index, sources=self._bus, row=row),)
        return self._captures[key]
