"""Turn a memory plan into bound calls: for each tick of the cycle a flat tuple of actions.

No scalar is handled in Python in a tick: each step is one gather from the bus, one set, one doStep and one get.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import EndOfSimulation, RunError, compact
from lockstep.faults.inject import Faults
from lockstep.fmi.slave import DTYPES, SCALARS, WARNING, Buffer, Scalar, Slave, regular_end
from lockstep.plan.bus_layout import Layout, by_scalar
from lockstep.plan.schedule import Task
from lockstep.plan.transfer import SetValue, converter, linear
from lockstep.plan.wiring import Link
from lockstep.processes.remote_batch import BatchedStep
from lockstep.run.batched_steps import Batches
from lockstep.run.input_signals import InputSignals
from lockstep.run.not_finite import AddEvent, Names, NotFinite
from lockstep.run.overlapped_steps import Overlapping, StartedStep, alone, interleaved
from lockstep.system.clock import seconds

Transfer = Callable[[], int]  # sets or gets values of a slave and returns the status of FMI
Action = Callable[[float], None]  # called with the simulated time [s]
NextRow = Callable[[float], Sequence[NDArray[Any]]]  # the recorder's next row, in the order of SCALARS


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
    ) -> None:
        """Bind nothing yet. `batches` joins steps of FMUs that share a process, where there are some."""
        self._layout, self._faults, self._inputs = layout, faults, inputs or InputSignals((), 0.0)
        self.not_finite = NotFinite(layout.used, names, add_event)
        self._slaves, self._names = slaves, names
        self._start = seconds(layout.schedule.start)
        make: Callable[[Scalar, int], Buffer] = batches.bus if batches else lambda s, size: np.zeros(size, DTYPES[s])
        self._bus: dict[Scalar, Buffer] = {s: make(s, layout.bus_size(s)) for s in SCALARS}
        self._batches, self._joined = batches, frozenset[str]()
        if batches is not None:
            self._joined = batches.members(layout, faults, self._inputs)
            batches.report_to(self._check_finite, self._refuse_overflow, self._end)
        self._steps: dict[object, Action] = {}  # equal phases share one action
        self._captures: dict[object, Action] = {}
        self._initial: dict[tuple[str, Scalar], dict[int, Any]] = {}
        self.end: EndOfSimulation | None = None  # the first that a component asked for
        self.on_end: Callable[[], None] = lambda: None  # called when a complete step asks for the end

    def phases(self, row: NextRow, look: Callable[[], None] = lambda: None) -> list[tuple[Action, ...]]:
        """Return the actions of every tick of the cycle, in order; `look` is called before each is bound."""
        self._captures.clear()  # they are bound to the row of a recorder
        return [self._phase(tick, row, look) for tick in range(self._layout.cycle)]

    def _phase(self, tick: int, row: NextRow, look: Callable[[], None]) -> tuple[Action, ...]:
        look()
        layout, tasks = self._layout, self._layout.schedule.tasks
        first = () if self._faults is None else (self._faults.begin_tick,)
        return (
            *first,
            *self.in_order(tick, [(t, self.step(t, tick)) for t in tasks if t.steps_at(tick)]),
            *((self.capture(tick, row),) if layout.records_at(tick) else ()),
        )

    def in_order(self, tick: int, steps: Iterable[tuple[Task, Action | BatchedStep]]) -> Iterator[Action]:
        """Yield the actions of steps in one tick."""
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
            self._check_finite(name, references, buffer, self._inputs.begin)
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
            put(self._inputs.begin)
        for scalar in SCALARS:
            entries: dict[int, Any] = {}
            for link in self._layout.feeding[name]:
                known = self._initial.get((link.producer, link.scalar))
                if (link.target_scalar or link.scalar) == scalar and known is not None:
                    values: NDArray[Any] = np.array([known[source] for source in link.sources], DTYPES[link.scalar])
                    convert = converter(scalar, link.ways, self._labels(name, scalar, link.targets))
                    found = convert(values)
                    if scalar == "Real" and not np.isfinite(found).all():
                        self._refuse_overflow(name, link.targets, found, self._start)
                    entries |= dict(zip(link.targets, found.tolist(), strict=True))
            if entries:
                targets = sorted(entries)
                buffer: Buffer = np.array([entries[target] for target in targets], DTYPES[scalar])
                call = self._slaves[name].setter(scalar, np.array(targets, np.uint32), buffer)
                self.check(name, f"Set{scalar}", self._start, call())

    def _labels(self, name: str, scalar: Scalar, references: Sequence[int]) -> list[str]:
        return [f"{name}.{self._names.get((name, scalar, r), r)}" for r in references]

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

    def _get(self, name: str, scalar: Scalar, references: list[int], buffer: Buffer) -> Transfer:
        return self._slaves[name].getter(scalar, np.array(references, np.uint32), buffer)

    def step(self, task: Task, tick: int, advances: bool = True) -> Action | BatchedStep:
        """Return a step of a component, or, where it does not advance, its sets and gets alone."""
        layout, version = self._layout, task.begun(tick)
        renewed = layout.renewed(task, tick)
        key = (
            task.name,
            advances,
            *((id(link), layout.place(link.producer, link.scalar, newest)) for link, newest in renewed),
            *(layout.place(task.name, scalar, version) for scalar in SCALARS),
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

    def _bind(
        self,
        task: Task,
        sets: Mapping[Scalar, list[SetValue]],
        gets: Mapping[Scalar, tuple[int, list[int]]],
        advances: bool = True,
    ) -> Action:
        """Bind one doStep with the sets before it and the gets after it; without the doStep if it does not advance."""
        name, slave, check = task.name, self._slaves[task.name], self.check
        do_step = slave.do_step
        length = seconds(task.period * self._layout.schedule.tick)
        end = length if task.continuous else 0.0  # from the step's start to where its outputs are true
        before = self._inputs.on_step(name, slave, check)
        before += [self._bound_set(name, scalar, entries) for scalar, entries in sets.items()]
        if self._faults is not None:
            before += self._faults.on_step(name, slave, check)
        after = [self.bound_get(name, scalar, *entry, end) for scalar, entry in gets.items()]
        if not advances:
            calls = (*before, *after)

            def exchanged(time: float) -> None:
                for call in calls:
                    call(time)

            return exchanged
        if isinstance(slave, Overlapping):

            def begin(time: float) -> None:
                for call in before:
                    call(time)
                do_step(time, length, 1)

            complete = slave.complete

            def completed() -> None:
                try:
                    complete()
                except EndOfSimulation as end:
                    self._end(end)

            return StartedStep(begin, completed, after)
        if len(before) == 1 and len(after) == 1:  # the usual step, without the two loops
            first, last = before[0], after[0]

            def usual_step(time: float) -> None:
                first(time)
                status = do_step(time, length, 1)
                if status:
                    check(name, "DoStep", time, status, length)
                last(time)

            return usual_step

        def step(time: float) -> None:
            for call in before:
                call(time)
            status = do_step(time, length, 1)
            if status:
                check(name, "DoStep", time, status, length)
            for call in after:
                call(time)

        return step

    def _bound_set(self, name: str, scalar: Scalar, entries: Sequence[SetValue]) -> Action:
        check, take, function = self.check, self._bus[scalar].take, f"Set{scalar}"
        targets = [entry.target for entry in entries]
        buffer: Buffer = np.zeros(len(targets), DTYPES[scalar])
        call = self._slaves[name].setter(scalar, np.array(targets, np.uint32), buffer)
        if self._faults is not None:
            call = self._faults.on_transfer(name, scalar, targets, buffer, call)
        index = np.array([entry.position for entry in entries], np.intp)
        ways = [entry.way for entry in entries]

        def plain(time: float) -> None:
            take(index, None, buffer, "clip")  # clip: the other modes copy through a temporary
            status = call()
            if status:
                check(name, function, time, status)

        if all(way.is_identity(scalar) for way in ways):
            return plain
        if not linear(ways, scalar):
            return self._mixed_set(name, scalar, entries, buffer, call)
        gain, bias = np.array([way.gain for way in ways]), np.array([way.bias for way in ways])
        marks = bytearray(len(targets))  # as in `_bound_get`
        finite, isfinite = np.frombuffer(marks, np.bool_), np.isfinite

        def converted(time: float) -> None:
            take(index, None, buffer, "clip")
            np.multiply(buffer, gain, buffer)
            np.add(buffer, bias, buffer)
            isfinite(buffer, finite)
            if 0 in marks:
                self._refuse_overflow(name, targets, buffer, time)
            status = call()
            if status:
                check(name, function, time, status)

        return converted

    def _refuse_overflow(self, name: str, targets: Sequence[int], values: Buffer, time: float) -> None:
        bad = ~np.isfinite(values)
        names = compact(label for label, wrong in zip(self._labels(name, "Real", targets), bad, strict=True) if wrong)
        raise RunError(
            f"{names}: is {values[bad][0]} at {time:.9g} s after the conversion of its connection; "
            "every exchanged value must be finite"
        )

    def _mixed_set(
        self, name: str, scalar: Scalar, entries: Sequence[SetValue], buffer: Buffer, call: Transfer
    ) -> Action:
        """Bind a set whose values come from outputs of several types, or through tables."""
        check, function = self.check, f"Set{scalar}"
        parts = []
        for source in SCALARS:
            places = [k for k, entry in enumerate(entries) if entry.way.source == source]
            if places:
                chosen = [entries[k] for k in places]
                names = self._labels(name, scalar, [entry.target for entry in chosen])
                index = np.array([entry.position for entry in chosen], np.intp)
                convert = converter(scalar, [entry.way for entry in chosen], names)
                parts.append((self._bus[source].take, index, convert, np.array(places, np.intp)))

        def mixed(time: float) -> None:
            for take, index, convert, places in parts:
                try:
                    buffer[places] = convert(take(index))
                except RunError as error:
                    raise RunError(f"{error} at {time:.9g} s") from None
            status = call()
            if status:
                check(name, function, time, status)

        return mixed

    def bound_get(self, name: str, scalar: Scalar, start: int, references: list[int], end: float) -> Action:
        """Bind the fetch of values to a place on the bus; they are true at the end of a step that takes `end` [s]."""
        check, function = self.check, f"Get{scalar}"
        part = self._bus[scalar][start : start + len(references)]
        call = self._get(name, scalar, references, part)

        def plain(time: float) -> None:
            status = call()
            if status:
                check(name, function, time, status)

        if scalar != "Real":
            return plain
        check_finite, isfinite = self._check_finite, np.isfinite
        marks = bytearray(len(part))  # searched ten times faster than an array
        finite = np.frombuffer(marks, np.bool_)
        reported = np.zeros(len(part), np.bool_)

        def checked(time: float) -> None:
            status = call()
            if status:
                check(name, function, time, status)
            isfinite(part, finite)
            if 0 in marks and not np.logical_or(finite, reported).all():
                check_finite(name, references, part, time + end)
                np.logical_or(reported, ~finite, reported)

        return checked

    def _check_finite(self, name: str, references: Sequence[int], values: Buffer, time: float) -> None:
        try:
            self.not_finite.check(name, references, np.asarray(values, np.float64), time)
        except RunError as error:
            logged = self._slaves[name].last_messages()  # the only report of a slave that cannot return an error
            raise RunError(f"{error}" + (f"; it logged: {logged}" if logged else "")) from None

    def capture(self, tick: int, row: NextRow) -> Action:
        """Bind the copy of what is true at this tick into the recorder's next row."""
        layout, task = self._layout, self._layout.schedule.task
        parts = [(name, task(name).true_at(tick), by_scalar(refs)) for name, refs in layout.recorded.items()]
        parts += [(name, task(name).begun(tick), by_scalar(refs)) for name, refs in layout.held.items()]
        key = tuple(layout.place(name, s, version) for name, version, refs in parts for s in refs)
        if key not in self._captures:
            index: dict[Scalar, NDArray[np.intp]] = {}
            for scalar in SCALARS:
                of_type = [(n, refs[scalar], version) for n, version, refs in parts if scalar in refs]
                places = [place for n, refs, version in of_type for place in layout.positions(n, scalar, refs, version)]
                index[scalar] = np.array(places, np.intp)
            self._captures[key] = self._bind_capture(index, row)
        return self._captures[key]

    def _bind_capture(self, index: Mapping[Scalar, NDArray[np.intp]], row: NextRow) -> Action:
        reals, take = index["Real"], self._bus["Real"].take
        others = [(k, index[s], self._bus[s].take) for k, s in enumerate(SCALARS) if s != "Real" and len(index[s])]

        def capture(time: float) -> None:
            parts = row(time)
            take(reals, None, parts[0], "clip")
            for k, places, take_other in others:
                parts[k][:] = take_other(places)

        return capture
