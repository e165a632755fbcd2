"""One instance of an FMU of FMI 1.0 or 3.0 for the checks, driven through what the master drives it with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from lockstep.check.dynamic.experiment import PERIOD, Experiment
from lockstep.check.dynamic.fmi2_instance import ERROR, OK, WARNING, Failed, Row
from lockstep.check.dynamic.trajectory import Trajectory
from lockstep.errors import RunError
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.slave import DTYPES, SCALARS, Scalar
from lockstep.processes.last_call import LastCall
from lockstep.system.component import Component, Value

_LONG = 10**6  # steps that are announced
_numbers = count(1)


@cache
def described(archive: Path) -> tuple[Component, Description]:
    """Return an FMU file as a component, and what it declares."""
    component = Component(name="checked", source=archive, period=1)
    return component, read_description(component)


class SlaveInstance:
    """An instance with the calls of `drive.Instance` that a measurement of delays needs; it is never reset."""

    def __init__(self, experiment: Experiment, archive: Path, work: Path, last_call: LastCall) -> None:
        self.experiment, self._last_call, self.worst = experiment, last_call, OK
        component, self._description = described(archive)
        self._enter("instantiation")
        try:
            place = work / f"instance{next(_numbers)}"
            self._slave = instantiate(component, self._description, place, lambda *_: None)
        except RunError as error:
            raise Failed(str(error)) from None
        self._leave()
        self.write = [(self._exchange("inputs", kind), kind, None, kind) for kind in self._kinds("inputs")]
        self._read = {kind: self._exchange("outputs", kind) for kind in self._kinds("outputs")}

    def _kinds(self, side: str) -> list[str]:
        kinds = ("Real", "Integer", "Boolean") if side == "inputs" else ("Real", "Integer", "Boolean", "String")
        return [kind for kind in kinds if self.experiment.of_kind(side, kind)]

    def _exchange(self, side: str, kind: str) -> Callable[[Any], Any]:
        """Return a function that takes or gives all values of one kind; each type has a call and buffer of its own."""
        ports = self.experiment.of_kind(side, kind)
        parts = []
        for scalar in SCALARS:
            places = [k for k, port in enumerate(ports) if self._description.variables[port.name].scalar == scalar]
            if places:
                # in the order of references, as the master calls
                places.sort(key=lambda k: ports[k].reference)
                references = np.array([ports[k].reference for k in places], np.uint32)
                buffer: Any = np.zeros(len(places), DTYPES[scalar])
                bind = self._slave.setter if side == "inputs" else self._slave.getter
                parts.append((bind(scalar, references, buffer), buffer, np.array(places), scalar))

        def put(values: Any) -> None:
            for call, buffer, places, scalar in parts:
                buffer[:] = values[places]
                self._demand(f"Set{scalar}", call)

        def get(_: Any) -> Any:
            found: Any = np.zeros(
                len(ports), DTYPES["String" if kind == "String" else "Real" if kind == "Real" else "Int64"]
            )
            for call, buffer, places, scalar in parts:
                self._demand(f"Get{scalar}", call)
                found[places] = buffer if kind in ("Real", "String") else buffer.astype(np.int64)
            return found

        return put if side == "inputs" else get

    def initialise(self) -> None:
        """Set start values, and initialise."""
        starts: dict[Scalar, dict[int, Value]] = {}
        kinds = {v.reference: v.scalar for v in self._description.variables.values()}
        for _, reference, value in self.experiment.starts:
            scalar = kinds[reference]
            if scalar is not None:
                starts.setdefault(scalar, {})[reference] = value
        for scalar, values in starts.items():
            self._demand(f"Set{scalar}", partial(self._slave.set_start, values, scalar))
        begin = self.experiment.start_time
        self._demand("SetupExperiment", lambda: self._slave.setup_experiment(begin, self.experiment.time(_LONG)))
        self._demand("EnterInitializationMode", self._slave.enter_initialization)
        self._demand("ExitInitializationMode", self._slave.exit_initialization)

    def reset(self) -> None:
        """Refuse: a new instance is made instead."""
        raise Failed("reset is not used")

    def stimuli(self, phase: int = 0) -> list[Any]:
        """Return the stimulus of each kind of inputs, (PERIOD, inputs) each."""
        return [self.experiment.stimulus(kind, phase) for _, _, _, kind in self.write]

    def put(self, values: list[Any]) -> None:
        """Set the inputs, one array for each kind."""
        for (put, _, _, _), row in zip(self.write, values, strict=True):
            put(np.asarray(row))

    def step(self, time: float, length: float) -> None:
        """Make one step, or raise Failed."""
        self._demand("DoStep", lambda: self._slave.do_step(time, length, 1), time)

    def row(self) -> Row:
        """Read all outputs."""
        found = {kind: get(None) for kind, get in self._read.items()}
        integers = [found[kind].astype(np.int32) for kind in ("Integer", "Boolean") if kind in found]
        texts = [str(text).encode() for text in found.get("String", ())]
        return found.get("Real", np.zeros(0)), np.concatenate([np.zeros(0, np.int32), *integers]), texts

    def run(self, first: int, last: int, *, tables: Sequence[Any] | None = None) -> Trajectory:
        """Make steps `first` to `last` - 1 under the stimulus, or under `tables`; return the outputs after each."""
        tables = self.stimuli() if tables is None else tables
        rows = []
        for k in range(first, last):
            self.put([table[k % PERIOD] for table in tables])
            self.step(self.experiment.time(k), self.experiment.step)
            rows.append(self.row())
        return Trajectory.of_rows(rows, self.experiment)

    def close(self) -> None:
        """End the instance."""
        self._enter("the end of the instance")
        self._slave.close()
        self._leave()

    def _demand(self, name: str, call: Callable[[], int], time: float | None = None) -> None:
        self._enter(name, time)
        status = call()
        self._leave()
        if status > WARNING:
            self.worst = max(self.worst, status if status >= ERROR else ERROR)
            self._slave.failed(status)
            at = f" at t = {time:.9g} s" if time is not None else ""
            said = self._slave.last_messages()
            raise Failed(self._slave.outcome(name, status) + at + (f": {said}" if said else ""))

    def _enter(self, name: str, time: float | None = None) -> None:
        self._last_call.enter(name, time)

    def _leave(self) -> None:
        self._last_call.leave()
