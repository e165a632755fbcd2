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

    def spans(self, bound: Bound) -> list[tuple[Buffer, NDArray[np.intp], NDArray[np.intp]]]:
        """Return, for each type among an entry's variables: the buffer, positions in it, positions in the entry."""
        found = []
        for scalar in SCALARS:
            mine = [k for k, v in enumerate(bound.variables) if v.scalar == scalar]
            if mine:
                positions = [self._positions[scalar, bound.variables[k].reference] for k in mine]
                found.append((positions[0][0], np.array([p for _, p in positions], np.intp), np.array(mine, np.intp)))
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _Work:
    """One entry with the positions of its values among the interface ports and in the buffers of the FMU."""

    convert: Map
    ports: NDArray[np.intp]
    spans: list[tuple[Buffer, NDArray[np.intp], NDArray[np.intp]]]
    size: int  # number of FMU variables
    hold: int | None  # position of the flag among the interface ports


class AdaptedSlave:
    """Implement `lockstep.fmi.slave.Slave`. Port values are doubles in one array, at their value references."""

    def __init__(self, slave: Slave, binding: Binding) -> None:
        self._slave, self._binding = slave, binding
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
            size=len(bound.variables),
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
        for work in self._inputs:
            if work.hold is not None and not first and not values[work.hold]:
                continue  # no new sample: the FMU keeps the last
            converted = work.convert(values[work.ports])
            for buffer, positions, mine in work.spans:
                buffer[positions] = converted[mine] if buffer.dtype == np.float64 else _whole(converted[mine], buffer)
        return _called(self._setters)

    def _pull(self) -> int:
        status = _called(self._getters)
        for work in self._outputs:
            fetched = np.empty(work.size)
            for buffer, positions, mine in work.spans:
                fetched[mine] = buffer[positions]
            self._values[work.ports] = work.convert(fetched)
        return status

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that fills the buffer with port values."""
        values, positions = self._values, references.astype(np.intp)

        def get() -> int:
            buffer[:] = values[positions] if scalar == "Real" else _whole(values[positions], buffer)
            return OK

        return get

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:  # noqa: ARG002
        """Return a call that takes port values from the buffer; the FMU gets them at its next step."""
        values, positions = self._values, references.astype(np.intp)

        def put() -> int:
            values[positions] = buffer
            return OK

        return put

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set start values of interface ports, and parameters of the FMU."""
        parameters: dict[int, Value] = {}
        for reference, value in values.items():
            parameter = self._binding.parameters.get(reference)
            if parameter is None:
                self._values[reference] = float(value)
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
                values[:] = saved[name]
        return self._slave.restore_state(folder)

    def _memory(self) -> list[NDArray[Any]]:
        """Return the arrays that a restarted run needs."""
        return [self._values, *self._buffers]

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self._slave.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Describe a failed call."""
        return self._slave.outcome(call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last, or nothing."""
        return self._slave.last_messages()

    def close(self) -> None:
        """Terminate and free."""
        self._slave.close()


def _whole(values: Array, buffer: Buffer) -> Array:
    """Round for an Integer buffer; NaN becomes 0, and a number out of range the nearest limit."""
    return np.rint(np.clip(np.nan_to_num(values), *_LIMITS[buffer.dtype]))


def _called(calls: Sequence[Callable[[], int]]) -> int:
    status = OK
    for call in calls:
        status = max(status, call())
    return status
