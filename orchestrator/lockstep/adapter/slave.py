"""A slave with the ports of ours and a foreign slave inside. `lockstep.run.exchange` sees no difference."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.adapter.bind import Binding, Bound
from lockstep.adapter.conversion import Map
from lockstep.arrays import Array
from lockstep.errors import InputError, compact
from lockstep.fmi.slave import DTYPES, ERROR, OK, SCALARS, WARNING, Buffer, Scalar, Slave, Stateful
from lockstep.system.component import Value

_FILE = "adapter.npz"
_LIMITS = {  # the outermost doubles that fit, by the type of a buffer
    np.dtype(np.int32): (-(2.0**31), 2.0**31 - 1.0),
    np.dtype(np.int64): (-(2.0**63), 2.0**63 - 1024.0),
    np.dtype(np.uint64): (0.0, 2.0**64 - 2048.0),
}


class _Side:
    """Buffers of the foreign slave's inputs, or of its outputs, one a type, and the calls that move them."""

    def __init__(self, slave: Slave, bounds: Sequence[Bound], inward: bool) -> None:
        self.calls: list[Callable[[], int]] = []
        self.buffers: list[Buffer] = []
        self._place: dict[tuple[str, int], tuple[Buffer, int]] = {}
        for scalar in SCALARS:
            references = sorted({v.reference for b in bounds for v in b.theirs if v.scalar == scalar})
            if not references:
                continue
            buffer: Buffer = np.zeros(len(references), DTYPES[scalar])
            self.buffers.append(buffer)
            self._place |= {(scalar, r): (buffer, k) for k, r in enumerate(references)}
            bind = slave.setter if inward else slave.getter
            self.calls.append(bind(scalar, np.array(references, np.uint32), buffer))

    def spans(self, bound: Bound) -> list[tuple[Buffer, NDArray[np.intp], NDArray[np.intp]]]:
        """Return, for each type among a bound entry's variables: the buffer, places in it, places in the entry."""
        found = []
        for scalar in SCALARS:
            mine = [k for k, v in enumerate(bound.theirs) if v.scalar == scalar]
            if mine:
                places = [self._place[scalar, bound.theirs[k].reference] for k in mine]
                found.append((places[0][0], np.array([p for _, p in places], np.intp), np.array(mine, np.intp)))
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _Work:
    """One entry, ready: where its values lie on our side and on theirs."""

    convert: Map
    ours: NDArray[np.intp]
    spans: list[tuple[Buffer, NDArray[np.intp], NDArray[np.intp]]]
    size: int  # of theirs
    hold: int | None  # place of the flag on our side


class AdaptedSlave:
    """Implements `lockstep.fmi.slave.Slave`. Values are kept as doubles in one array, by their new reference."""

    def __init__(self, slave: Slave, binding: Binding) -> None:
        self._slave, self._binding = slave, binding
        self._values: Array = np.zeros(len(binding.variables))
        number = {name: v.reference for name, v in binding.variables.items()}
        for name, value in binding.substitutes.items():
            self._values[number[name]] = value
        inputs = _Side(slave, binding.inputs, inward=True)
        outputs = _Side(slave, binding.outputs, inward=False)
        self._setters, self._getters = inputs.calls, outputs.calls
        self._buffers = inputs.buffers + outputs.buffers
        self._inputs = [self._work(b, b.conversion.to_theirs, inputs, number) for b in binding.inputs]
        self._outputs = [self._work(b, b.conversion.to_ours, outputs, number) for b in binding.outputs]
        self._foreign_step = slave.do_step

    @staticmethod
    def _work(bound: Bound, convert: Map, side: _Side, number: Mapping[str, int]) -> _Work:
        return _Work(
            convert=convert,
            ours=np.array([number[v.name] for v in bound.ours], np.intp),
            spans=side.spans(bound),
            size=len(bound.theirs),
            hold=None if bound.hold is None else number[bound.hold.name],
        )

    def do_step(self, time: float, step: float, new: int, /) -> int:
        """Hand the inputs over, step, and take the outputs."""
        status = self._push(first=False)
        if status > WARNING:
            return status
        status = max(status, self._foreign_step(time, step, new))
        return status if status > WARNING else max(status, self._pull())

    def _push(self, first: bool) -> int:
        values = self._values
        for work in self._inputs:
            if work.hold is not None and not first and not values[work.hold]:
                continue  # no new sample: the FMU keeps the last
            theirs = work.convert(values[work.ours])
            for buffer, places, mine in work.spans:
                buffer[places] = theirs[mine] if buffer.dtype == np.float64 else _whole(theirs[mine], buffer)
        return _called(self._setters)

    def _pull(self) -> int:
        status = _called(self._getters)
        for work in self._outputs:
            theirs = np.empty(work.size)
            for buffer, places, mine in work.spans:
                theirs[mine] = buffer[places]
            self._values[work.ours] = work.convert(theirs)
        return status

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that fills the buffer with values of ours."""
        values, places = self._values, references.astype(np.intp)

        def get() -> int:
            buffer[:] = values[places] if scalar == "Real" else _whole(values[places], buffer)
            return OK

        return get

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:  # noqa: ARG002
        """Return a call that takes values of ours from the buffer; the FMU gets them at its next step."""
        values, places = self._values, references.astype(np.intp)

        def put() -> int:
            values[places] = buffer
            return OK

        return put

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set start values of inputs of ours, and parameters of theirs."""
        theirs: dict[int, Value] = {}
        for reference, value in values.items():
            parameter = self._binding.parameters.get(reference)
            if parameter is None:
                self._values[reference] = float(value)
            else:
                theirs[parameter.reference] = value
        return self._slave.set_start(theirs, scalar) if theirs else OK

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span [s]."""
        return self._slave.setup_experiment(start, stop)

    def enter_initialization(self) -> int:
        """Enter initialization mode."""
        return self._slave.enter_initialization()

    def exit_initialization(self) -> int:
        """Leave initialization mode, with the inputs handed over before and the initial outputs taken after."""
        status = self._push(first=True)
        if status > WARNING:
            return status
        status = max(status, self._slave.exit_initialization())
        return status if status > WARNING else max(status, self._pull())

    def save_state(self, folder: str) -> int:
        """Save the FMU's state, and the values on both sides: some of them wait for their flag."""
        if not isinstance(self._slave, Stateful):
            return ERROR
        np.savez(Path(folder, _FILE), *self._memory(), allow_pickle=False)
        return self._slave.save_state(folder)

    def restore_state(self, folder: str) -> int:
        """Take what a folder holds."""
        if not isinstance(self._slave, Stateful):
            return ERROR
        with np.load(Path(folder, _FILE), allow_pickle=False) as saved:
            for values, name in zip(self._memory(), saved.files, strict=True):
                values[:] = saved[name]
        return self._slave.restore_state(folder)

    def _memory(self) -> list[NDArray[Any]]:
        """All that has to be the same where the run goes on."""
        return [self._values, *self._buffers]

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self._slave.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Say what a call came to that failed."""
        return self._slave.outcome(call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last, or nothing."""
        return self._slave.last_messages()

    def close(self) -> None:
        """Terminate and free."""
        self._slave.close()


def adapt_slave(slave: Slave, binding: Binding) -> AdaptedSlave:
    """Wrap a fresh instance, and give it the constants and parameters of the adapter file."""
    for scalar in SCALARS:
        values = {v.reference: value for v, value in binding.starts.items() if v.scalar == scalar}
        if values and slave.set_start(values, scalar) > WARNING:
            names = compact(v.name for v in binding.starts if v.scalar == scalar)
            reason = slave.last_messages() or "it logged no reason"
            raise InputError(f"{binding.adapter.path.name}: the FMU refuses a value of {names}: {reason}")
    return AdaptedSlave(slave, binding)


def _whole(values: Array, buffer: Buffer) -> Array:
    """Round as an Integer has to; what is no number becomes 0, what is too large the largest."""
    return np.rint(np.clip(np.nan_to_num(values), *_LIMITS[buffer.dtype]))


def _called(calls: Sequence[Callable[[], int]]) -> int:
    status = OK
    for call in calls:
        status = max(status, call())
    return status
