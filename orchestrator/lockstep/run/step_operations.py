"""Turn the sets and gets of a step into operations: what one gather and one call of FMI do, and what needs more."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import RunError, compact
from lockstep.faults.inject import Faults
from lockstep.fmi.slave import DTYPES, SCALARS, Buffer, Scalar, Slave
from lockstep.plan.transfer import SetValue, converter, linear
from lockstep.run.input_signals import InputSignals
from lockstep.run.not_finite import Names
from lockstep.tick.operations import Action, Convert, Finite, Gather, Judge, Operation, Python, Transfer

Targets = Sequence[int]  # references of inputs
Gets = Mapping[Scalar, tuple[int, list[int]]]  # by type, where they begin on the bus and what they are


class Check(Protocol):
    """Judge a call: component, function, time [s], status, and for DoStep the step [s]."""

    def __call__(self, name: str, call: str, time: float, status: int, step: float = 0.0) -> None:
        """Raise RunError if it failed."""
        ...


class StepOperations:
    """What sets and gets need: slaves, bus, names for errors, faults and input files."""

    def __init__(
        self,
        slaves: Mapping[str, Slave],
        bus: Mapping[Scalar, Buffer],
        names: Names,
        faults: Faults | None,
        inputs: InputSignals,
        check: Check,
        check_finite: Callable[[str, Sequence[int], Buffer, float], None],
    ) -> None:
        self._slaves, self.bus, self._names = slaves, bus, names
        self._faults, self._inputs = faults, inputs
        self.check, self._check_finite = check, check_finite

    def judge(self, name: str, function: str, step: float = 0.0) -> Judge:
        """Return what judges a status of a call."""
        check = self.check
        return lambda time, status: check(name, function, time, status, step)

    def before(self, name: str, sets: Mapping[Scalar, list[SetValue]]) -> list[Operation]:
        """Return what happens before a doStep: inputs of files, connected inputs, parameters of faults."""
        slave = self._slaves[name]
        found: list[Operation] = [Python(call=put) for put in self._inputs.on_step(name, slave, self.check)]
        for scalar, entries in sets.items():
            found += self._set(name, scalar, entries)
        if self._faults is not None:
            found += self._faults.on_step(name, slave, self.check)
        return found

    def after(self, name: str, gets: Gets, end: float) -> list[Operation]:
        """Return the fetches after a doStep; the values are true at the end of a step that takes `end` [s]."""
        return [operation for scalar, entry in gets.items() for operation in self.get(name, scalar, *entry, end)]

    def _set(self, name: str, scalar: Scalar, entries: Sequence[SetValue]) -> list[Operation]:
        targets = [entry.target for entry in entries]
        buffer: Buffer = np.zeros(len(targets), DTYPES[scalar])
        call = self._slaves[name].setter(scalar, np.array(targets, np.uint32), buffer)
        function = f"Set{scalar}"
        send = Transfer(component=name, function=function, call=call, buffer=buffer, judge=self.judge(name, function))
        altered = [] if self._faults is None else self._faults.on_transfer(name, scalar, targets, buffer)
        return [*self.fill(name, scalar, entries, buffer), *altered, send]

    def fill(self, name: str, scalar: Scalar, entries: Sequence[SetValue], buffer: Buffer) -> list[Operation]:
        """Return what fills a buffer with inputs of one type."""
        ways = [entry.way for entry in entries]
        identical = all(way.is_identity(scalar) for way in ways)
        if not identical and not linear(ways, scalar):
            return [Python(call=self._mixed(name, scalar, entries, buffer))]
        index = np.array([entry.position for entry in entries], np.intp)
        take = Gather(source=self.bus[scalar], index=index, buffer=buffer)
        if identical:
            return [take]
        gain, bias = np.array([way.gain for way in ways]), np.array([way.bias for way in ways])
        targets = [entry.target for entry in entries]

        def refuse(time: float) -> None:
            self.refuse_overflow(name, targets, buffer, time)

        return [take, Convert(buffer=buffer, gain=gain, bias=bias, refuse=refuse)]

    def _mixed(self, name: str, scalar: Scalar, entries: Sequence[SetValue], buffer: Buffer) -> Action:
        """Return what fills the buffer of a set whose values come from several types, or through tables."""
        parts = []
        for source in SCALARS:
            places = [k for k, entry in enumerate(entries) if entry.way.source == source]
            if places:
                chosen = [entries[k] for k in places]
                names = self.labels(name, scalar, [entry.target for entry in chosen])
                index = np.array([entry.position for entry in chosen], np.intp)
                convert = converter(scalar, [entry.way for entry in chosen], names)
                parts.append((self.bus[source].take, index, convert, np.array(places, np.intp)))

        def mixed(time: float) -> None:
            for take, index, convert, places in parts:
                try:
                    buffer[places] = convert(take(index))
                except RunError as error:
                    raise RunError(f"{error} at {time:.9g} s") from None

        return mixed

    def get(self, name: str, scalar: Scalar, start: int, references: list[int], end: float) -> list[Operation]:
        """Return the fetch of values to a place on the bus; they are true at the end of a step that takes `end` [s]."""
        function = f"Get{scalar}"
        part = self.bus[scalar][start : start + len(references)]
        call = self._slaves[name].getter(scalar, np.array(references, np.uint32), part)
        fetch = Transfer(component=name, function=function, call=call, buffer=part, judge=self.judge(name, function))
        return [fetch, *self.finite(name, scalar, references, part, end)]

    def finite(self, name: str, scalar: Scalar, references: list[int], part: Buffer, end: float) -> list[Operation]:
        """Return the check of fetched values, if they are Reals."""
        if scalar != "Real":
            return []
        reported: NDArray[np.bool_] = np.zeros(len(part), np.bool_)

        def report(time: float) -> None:
            self._check_finite(name, references, part, time + end)
            np.logical_or(reported, ~np.isfinite(part), reported)

        return [Finite(buffer=part, report=report, reported=reported)]

    def labels(self, name: str, scalar: Scalar, references: Iterable[int]) -> list[str]:
        """Return names of variables for errors."""
        return [f"{name}.{self._names.get((name, scalar, r), r)}" for r in references]

    def refuse_overflow(self, name: str, targets: Targets, values: Buffer, time: float) -> None:
        """Raise RunError for converted inputs that are not finite."""
        bad = ~np.isfinite(values)
        names = compact(label for label, wrong in zip(self.labels(name, "Real", targets), bad, strict=True) if wrong)
        raise RunError(
            f"{names}: is {values[bad][0]} at {time:.9g} s after the conversion of its connection; "
            "every exchanged value must be finite"
        )
