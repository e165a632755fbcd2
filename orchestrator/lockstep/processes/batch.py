"""Steps of several FMUs at one request, in the worker: values between them do not travel to the master.

A batch is a sequence of waves. In a wave no FMU reads what another one of it computes, so the inputs of all are
gathered at its beginning from the bus, the memory of all exchanged values, and the outputs are checked at its end. What
a wave calls is a flat list; a request runs it from a call on, and stops at what the master has to decide.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from ctypes import c_double, c_int
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.fmi2 import Fmi2Slave
from lockstep.fmi.slave import DTYPES, WARNING, Buffer, Scalar, Slave, regular_end
from lockstep.processes.hosted_fmu import HostedFmu
from lockstep.processes.last_call import CALL, TIME
from lockstep.processes.shared_memory import START, SharedMemory

OVERFLOW, NOT_FINITE = 1 << 40, 1 << 41  # what the calls of a wave itself return; beyond all status of FMI

Call = Callable[[], int]
Bus = Mapping[Scalar, Buffer]


class Hosting(Protocol):
    """The FMUs of a process, its memory, and its answers."""

    shared: SharedMemory
    hosts: dict[int, HostedFmu]

    def done(self) -> bytes:
        """Return the answer to a request that is done."""
        ...

    def reply(self, content: dict[str, Any]) -> bytes:
        """Return an answer that says something."""
        ...


@dataclass(frozen=True, slots=True)
class _Made:
    """One call of the list, the FMU that it is of, and its name without the prefix of FMI."""

    call: Call
    host: HostedFmu | None = None
    name: str = ""
    length: float = 0.0  # of a step [s]


@dataclass(slots=True)
class _Inputs:
    """Inputs of one type of all FMUs of a wave, in one buffer."""

    positions: list[int] = field(default_factory=list)  # on the bus
    gain: list[float] = field(default_factory=list)
    bias: list[float] = field(default_factory=list)
    buffer: Buffer = field(default_factory=lambda: np.zeros(0))


class BoundBatch:
    """The calls of a batch, bound to FMUs and memory of this process."""

    def __init__(self, worker: Hosting, request: Mapping[str, Any]) -> None:
        self._worker = worker
        self._reals, self._integers = worker.shared.last_call.reals, worker.shared.last_call.integers
        self._numbers = worker.shared.numbers
        self._clock = c_double()
        bus: Bus = {s: worker.shared.region(s, count, offset) for s, (offset, count) in request["bus"].items()}
        self._made = [made for wave in request["waves"] for made in self._wave(wave, bus)]
        self._calls = [made.call for made in self._made]

    def run(self) -> bytes:
        """Make the calls; return the message that answers, if there is anything to say."""
        number, integers = self._numbers[START], self._integers
        self._clock.value = self._reals[TIME]
        for call in self._calls[number:] if number else self._calls:
            integers[CALL] = number = number + 1
            status = call()
            if status > WARNING:
                return self._stopped(number, status)
        integers[CALL] = 0
        return self._worker.done()

    def _stopped(self, number: int, status: int) -> bytes:
        self._integers[CALL] = 0
        made = self._made[number - 1]
        found: dict[str, Any] = {"stopped": number}
        if made.host is not None:
            found["failed"] = made.host.failed(made.name, status)
            end = regular_end(found["failed"], "", self._reals[TIME], made.length)
            found["ended"] = made.name == "DoStep" and end is not None
        return self._worker.reply(found)

    def _wave(self, members: Iterable[Mapping[str, Any]], bus: Bus) -> Iterable[_Made]:
        """Yield the calls of one wave."""
        groups: dict[tuple[Scalar, bool], _Inputs] = {}
        places = []  # of each set of each FMU
        for member in members:
            for scalar, _, positions, gain, bias in member["sets"]:
                inputs = groups.setdefault((scalar, gain is not None), _Inputs())
                first = len(inputs.positions)
                inputs.positions += positions
                inputs.gain += gain or []
                inputs.bias += bias or []
                places.append((inputs, slice(first, len(inputs.positions))))
        for (scalar, _), inputs in groups.items():
            inputs.buffer = np.zeros(len(inputs.positions), DTYPES[scalar])
        yield _Made(_gather(groups, bus))
        following = iter(places)
        for member in members:
            host, length = self._worker.hosts[member["slave"]], member["length"]
            for scalar, references, *_ in member["sets"]:
                inputs, part = next(following)
                call = host.slave.setter(scalar, np.array(references, np.uint32), inputs.buffer[part])
                yield _Made(call, host, f"Set{scalar}")
            yield _Made(self._step(host.slave, length), host, "DoStep", length)
            for scalar, start, references in member["gets"]:
                values = bus[scalar][start : start + len(references)]
                yield _Made(host.slave.getter(scalar, np.array(references, np.uint32), values), host, f"Get{scalar}")
        gets = [get for member in members for get in member["gets"] if get[0] == "Real"]
        outputs = [start + k for _, start, references in gets for k in range(len(references))]
        if outputs:
            yield _Made(_check(bus["Real"], np.array(outputs, np.intp)))

    def _step(self, slave: Slave, length: float) -> Call:
        clock = self._clock
        step: Callable[..., int] = slave.do_step
        if isinstance(slave, Fmi2Slave):  # a function of C: instances of ctypes are passed as they are
            return partial(step, clock, c_double(length), c_int(1))
        return lambda: step(clock.value, length, 1)


def _gather(groups: Mapping[tuple[Scalar, bool], _Inputs], bus: Bus) -> Call:
    """Return a call that fills the buffers of a wave, with the conversions that the master makes."""
    unconverted = [
        (bus[scalar].take, np.array(inputs.positions, np.intp), inputs.buffer)
        for (scalar, converted), inputs in groups.items()
        if not converted
    ]
    linear = [
        (bus[scalar].take, np.array(i.positions, np.intp), i.buffer, np.array(i.gain), np.array(i.bias))
        for (scalar, converted), i in groups.items()
        if converted
    ]

    def fill() -> int:
        for take, index, buffer in unconverted:
            take(index, None, buffer, "clip")  # clip: the other modes copy through a temporary
        for take, index, buffer, gain, bias in linear:
            take(index, None, buffer, "clip")
            np.multiply(buffer, gain, buffer)
            np.add(buffer, bias, buffer)
            if not np.isfinite(buffer).all():
                return OVERFLOW
        return 0

    return fill


def _check(values: Buffer, index: NDArray[np.intp]) -> Call:
    """Return a call that looks for outputs that are not finite."""
    found = np.zeros(len(index))
    marks = bytearray(len(index))  # searched ten times faster than an array
    finite, take, isfinite = np.frombuffer(marks, np.bool_), values.take, np.isfinite

    def check() -> int:
        take(index, None, found, "clip")
        isfinite(found, finite)
        return NOT_FINITE if 0 in marks else 0

    return check
