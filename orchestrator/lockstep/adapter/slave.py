"""Run a foreign slave behind the interface ports of the component that it replaces, as a slave like any other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.adapter.bind import Binding, Bound
from lockstep.adapter.conversion import Map
from lockstep.adapter.fit import Unfit, doubles, finite, whole
from lockstep.arrays import Array, refill
from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Variable
from lockstep.fmi.slave import DTYPES, ERROR, OK, SCALARS, WARNING, Buffer, Scalar, Slave, Stateful
from lockstep.system.component import Value

_FILE = "adapter.npz"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Span:
    """Variables of one type of an entry: their positions in the buffer, and among the entry's variables."""

    buffer: Buffer
    positions: NDArray[np.intp]
    mine: NDArray[np.intp]
    variables: tuple[Variable, ...]


class _Side:
    """Hold buffers for the foreign slave's inputs or outputs, one for each type, and the calls that transfer them."""

    def __init__(self, slave: Slave, bounds: Sequence[Bound], inward: bool) -> None:
        self.calls: list[Callable[[], int]] = []
        self.buffers: list[Buffer] = []
        self._positions: dict[tuple[str, int], tuple[Buffer, int]] = {}
        for scalar in SCALARS:
            references = sorted({v.reference for b in bounds for v in b.variables if v.scalar == scalar})
            if not references:
                continue
            buffer: Buffer = np.zeros(len(references), DTYPES[scalar])
            self.buffers.append(buffer)
            self._positions |= {(scalar, r): (buffer, k) for k, r in enumerate(references)}
            bind = slave.setter if inward else slave.getter
            self.calls.append(bind(scalar, np.array(references, np.uint32), buffer))

    def spans(self, bound: Bound) -> list[_Span]:
        """Return, for each type among an entry's variables, where they are."""
        found = []
        for scalar in SCALARS:
            mine = [k for k, v in enumerate(bound.variables) if v.scalar == scalar]
            if mine:
                positions = [self._positions[scalar, bound.variables[k].reference] for k in mine]
                span = _Span(
                    buffer=positions[0][0],
                    positions=np.array([p for _, p in positions], np.intp),
                    mine=np.array(mine, np.intp),
                    variables=tuple(bound.variables[k] for k in mine),
                )
                found.append(span)
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _Work:
    """One entry with the positions of its values among the interface ports and in the buffers of the FMU."""

    convert: Map
    ports: NDArray[np.intp]
    spans: list[_Span]
    bound: Bound
    numbers: bool  # all ports are Reals
    hold: int | None  # position of the flag among the interface ports


class AdaptedSlave:
    """Implement `lockstep.fmi.slave.Slave`. Port values are doubles in one array, at their value references."""

    def __init__(self, slave: Slave, binding: Binding) -> None:
        self._slave, self._binding = slave, binding
        self._problem = ""  # a value that did not fit
        self._values: Array = np.zeros(len(binding.shown))
        number = {name: v.reference for name, v in binding.shown.items()}
        for name, value in binding.substitutes.items():
            self._values[number[name]] = value
        inputs = _Side(slave, binding.inputs, inward=True)
        outputs = _Side(slave, binding.outputs, inward=False)
        self._setters, self._getters = inputs.calls, outputs.calls
        self._buffers = inputs.buffers + outputs.buffers
        self._inputs = [self._work(b, b.conversion.to_fmu, inputs, number) for b in binding.inputs]
        self._outputs = [self._work(b, b.conversion.to_port, outputs, number) for b in binding.outputs]
        self._foreign_step = slave.do_step

    @staticmethod
    def _work(bound: Bound, convert: Map, side: _Side, number: Mapping[str, int]) -> _Work:
        return _Work(
            convert=convert,
            ports=np.array([number[v.name] for v in bound.ports], np.intp),
            spans=side.spans(bound),
            bound=bound,
            numbers=all(v.scalar == "Real" for v in bound.ports),
            hold=None if bound.hold is None else number[bound.hold.name],
        )

    def do_step(self, time: float, step: float, new: int, /) -> int:
        """Set the FMU's inputs, step it, and get its outputs."""
        status = self._push(first=False)
        if status > WARNING:
            return status
        status = max(status, self._foreign_step(time, step, new))
        return status if status > WARNING else max(status, self._pull())

    def _push(self, first: bool) -> int:
        values = self._values
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                for work in self._inputs:
                    if work.hold is not None and not first and not values[work.hold]:
                        continue  # no new sample: the FMU keeps the last
                    given = values[work.ports]
                    converted = work.convert(given)
                    finite(converted, given, work.bound.variables)
                    for span in work.spans:
                        part, kind = converted[span.mine], span.buffer.dtype
                        span.buffer[span.positions] = part if kind == np.float64 else whole(part, span.variables, kind)
        except Unfit as unfit:
            return self._refuse(unfit)
        return _called(self._setters)

    def _pull(self) -> int:
        status = _called(self._getters)
        if status > WARNING:
            return status
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                for work in self._outputs:
                    fetched = np.empty(len(work.bound.variables))
                    for span in work.spans:
                        fetched[span.mine] = doubles(span.buffer[span.positions], span.variables)
                    if not work.numbers:  # a flag would be true, and an Integer is whole
                        _refuse_infinite(fetched, work.bound)
                    self._values[work.ports] = work.convert(fetched)
        except Unfit as unfit:
            return self._refuse(unfit)
        return status

    def _refuse(self, unfit: Unfit) -> int:
        """Note a value that does not fit, which ends the run though the FMU has not failed."""
        self._problem = str(unfit)
        return ERROR

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that fills the buffer with port values."""
        values, positions = self._values, references.astype(np.intp)
        if scalar == "Real":

            def get() -> int:
                buffer[:] = values[positions]
                return OK

            return get
        ports = self._ports(references)

        def get_whole() -> int:
            try:
                buffer[:] = whole(values[positions], ports, buffer.dtype)
            except Unfit as unfit:
                return self._refuse(unfit)
            return OK

        return get_whole

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that takes port values from the buffer; the FMU gets them at its next step."""
        values, positions = self._values, references.astype(np.intp)
        ports = self._ports(references)

        def put() -> int:
            try:
                values[positions] = buffer if scalar == "Real" else doubles(buffer, ports)
            except Unfit as unfit:
                return self._refuse(unfit)
            return OK

        return put

    def _ports(self, references: NDArray[np.uint32]) -> list[Variable]:
        shown = list(self._binding.shown.values())  # their references are their positions
        return [shown[reference] for reference in references.tolist()]

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set start values of interface ports, and parameters of the FMU."""
        parameters: dict[int, Value] = {}
        for reference, value in values.items():
            parameter = self._binding.parameters.get(reference)
            if parameter is None:
                self._values[reference] = value
                if float(self._values[reference]) != value:  # an integer of 64 bits
                    (port,) = self._ports(np.array([reference], np.uint32))
                    return self._refuse(Unfit(f"{port.name}: {value} has more digits than an adapter keeps"))
            else:
                parameters[parameter.reference] = value
        return self._slave.set_start(parameters, scalar) if parameters else OK

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span [s], then set the constants and parameters of the adapter file."""
        status = self._slave.setup_experiment(start, stop)
        if status <= WARNING:
            self._set_constants()
        return status

    def _set_constants(self) -> None:
        for scalar in SCALARS:
            values = {v.reference: value for v, value in self._binding.starts.items() if v.scalar == scalar}
            if values and self._slave.set_start(values, scalar) > WARNING:
                names = compact(v.name for v in self._binding.starts if v.scalar == scalar)
                reason = self._slave.last_messages() or "it logged no reason"
                raise InputError(f"{self._binding.adapter.path.name}: the FMU refuses a value of {names}: {reason}")

    def enter_initialization(self) -> int:
        """Enter initialization mode."""
        return self._slave.enter_initialization()

    def exit_initialization(self) -> int:
        """Set the inputs, leave initialization mode, and get the initial outputs."""
        status = self._push(first=True)
        if status > WARNING:
            return status
        status = max(status, self._slave.exit_initialization())
        return status if status > WARNING else max(status, self._pull())

    def save_state(self, folder: str) -> int:
        """Save the FMU's state, and the values of ports and variables: a held value is nowhere else."""
        if not isinstance(self._slave, Stateful):
            return ERROR
        np.savez(Path(folder, _FILE), *self._memory(), allow_pickle=False)
        return self._slave.save_state(folder)

    def restore_state(self, folder: str) -> int:
        """Restore what `save_state` wrote."""
        if not isinstance(self._slave, Stateful):
            return ERROR
        with np.load(Path(folder, _FILE), allow_pickle=False) as saved:
            for values, name in zip(self._memory(), saved.files, strict=True):
                refill(values, saved[name])
        return self._slave.restore_state(folder)

    def _memory(self) -> list[NDArray[Any]]:
        """Return the arrays that a restarted run needs."""
        return [self._values, *self._buffers]

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        if not self._problem:
            self._slave.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Describe a failed call, or the value that did not fit."""
        return self._problem or self._slave.outcome(call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last, or nothing."""
        return "" if self._problem else self._slave.last_messages()

    def close(self) -> None:
        """Terminate and free."""
        self._slave.close()


def _refuse_infinite(values: Array, bound: Bound) -> None:
    found = np.isfinite(values)
    if not found.all():
        first = int(np.argmin(found))
        ports = compact(v.name for v in bound.ports)
        raise Unfit(f"{bound.variables[first].name}: is {values[first]}, of which no {bound.ports[0].type} can be made "
                    f"for {ports}")  # fmt: skip


def _called(calls: Sequence[Callable[[], int]]) -> int:
    status = OK
    for call in calls:
        status = max(status, call())
    return status
