"""A slave whose FMU runs in another process: values through shared memory, one round trip a step.

Inputs that are set are sent with the next step. `do_step` sends and returns at once: `overlaps` states that. The first
call after it waits for the answer, which holds the outputs that were fetched after the same step before. So the failure
of any call is reported when the answer is there, as a RunError that names the call, by whatever method waits for it.
"""

from __future__ import annotations

import json
import pickle
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import InputError, RunError
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import ERROR, OK, Buffer, Scalar, regular_end, returned
from lockstep.processes.connection import Answer, Calls, Connection, of_one
from lockstep.processes.last_call import STEP, TIME
from lockstep.processes.string_transfer import RAW, first_encode, then_decode
from lockstep.processes.watched_process import Limits
from lockstep.system.component import Component, Value

_NONE: frozenset[int] = frozenset()

Key = tuple[tuple[int, ...], bool, tuple[int, ...]]  # sets, whether to step, gets


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandCalls:
    """The calls that the worker makes at one command."""

    number: int  # 0 for a message
    calls: Calls
    gets: frozenset[int]


class RemoteSlave:
    """One running instance in a worker's process. Implements `lockstep.fmi.slave.Slave`."""

    overlaps = True  # do_step only begins: complete, or a getter, waits for its end

    def __init__(
        self,
        component: Component,
        description: Description,
        folder: Path,
        log: Log,
        limits: Limits | None = None,
        connection: Connection | None = None,
    ) -> None:
        """Begin to instantiate the FMU, in the process of a connection that others use too or in one of its own."""
        self.name, folder = component.name, folder.absolute()
        self.prefix = description.prefix
        self._log = log
        self._messages: deque[str] = deque(maxlen=3)
        self._outcome = ""  # of the call that failed last
        self._time = self._length = 0.0  # of the last step [s]
        self._waiting = self._ready = self._closed = False
        self._answer: Answer | None = None  # to the request that is waited for, if others needed the connection
        self._ports: dict[tuple[str, Scalar, bytes], tuple[int, Buffer]] = {}
        self._programs: dict[Key, CommandCalls] = {}
        self._under_way = self._single("Instantiate")
        self._pending: dict[int, None] = {}  # sets to send with the next step, in order
        self._current = _NONE  # gets whose regions hold the present values
        self._seen = 0  # requests by C until then
        self._used: list[int] = []  # gets called since the last step
        self._last: _Step | None = None
        self.connection = Connection(self.name, folder, log, limits) if connection is None else connection
        self.number = self.connection.add(self)
        self._last_call = self.connection.last_call
        source, archive = component.source, component.archive
        if archive is None:
            source = source.absolute()  # the worker has another working directory
        else:
            archive = archive.absolute()
        part = Component(name=self.name, source=source, period=1, archive=archive, tolerance=component.tolerance)
        start = (part, replace(description, variables=dict(description.variables)), str(folder))
        self._send(pickle.dumps(start))

    def keep(self, answer: Answer) -> None:
        """Keep the answer until it is waited for, as others need the connection."""
        self._answer = answer

    def take_message(self, status: int, category: str, text: str) -> None:
        """Log a message of the FMU."""
        self._messages.append(" ".join(text.split()))
        self._log(self.name, status, category, text)

    def ready(self) -> None:
        """Wait until the FMU is instantiated, or raise the worker's error; several start side by side."""
        if not self._ready:
            self._ready = True
            answer = self._complete()
            self.connection.started()
            if "refused" in answer:
                raise (InputError if answer["refused"] == "InputError" else RunError)(str(answer["reason"]))

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that waits for the step and copies the values that it gave."""
        if buffer.dtype == object:
            raw = np.zeros(len(references), RAW)
            return then_decode(self.getter(scalar, references, raw), raw, buffer)
        port, region = self.port("get", scalar, references)
        link = self.connection.link

        def get() -> int:
            if self._waiting:
                self._complete()
            self._used.append(port)
            if self._seen != link.by_c:
                self._current, self._seen = _NONE, link.by_c
            if port not in self._current:
                current = self._current
                self._run(self.program((tuple(self._pending), False, (port,))))
                self._complete()
                self._current = current | {port}
            buffer[:] = region
            return OK

        return get

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that copies the values to the region that the next step reads."""
        if buffer.dtype == object:
            raw = np.zeros(len(references), RAW)
            return first_encode(buffer, raw, self.setter(scalar, references, raw), self._refuse)
        port, region = self.port("set", scalar, references)
        pending = self._pending

        def put() -> int:
            if self._waiting:
                self._complete()
            region[:] = buffer
            pending.pop(port, None)  # the later of two sets has to remain the later one
            pending[port] = None
            self._current = _NONE  # an output may depend on it at once
            return OK

        return put

    def _refuse(self, reason: str) -> int:
        raise RunError(f"{self.name}: {reason}")

    @property
    def do_step(self) -> Callable[[float, float, int], int]:
        """A call that begins a step. Each expects the same gets after it as were called the last time."""
        return _Step(self)

    def start_step(self, step: _Step, time: float, length: float) -> None:
        """Send a step, with the sets before it and the gets that it expects."""
        if self._waiting:
            self._complete()
        last, used = self._last, self._used
        if last is not None and used != last.expected:
            last.expected, last.program = list(dict.fromkeys(used)), None
        self._last, self._used = step, []
        connection, reals = self.connection, self._last_call.reals
        connection.settle()  # before the worker reads the time of this step
        connection.time = self._time = reals[TIME] = time
        reals[STEP] = self._length = length
        sets = tuple(self._pending)
        program = step.program
        if program is None or sets != step.sets:
            step.sets, step.program = sets, program = sets, self.program((sets, True, tuple(step.expected)))
        self._run(program)

    def begin_program(self, program: CommandCalls, time: float, length: float) -> None:
        """Send a step, with the sets and gets of its program."""
        self._last, self._used = None, []
        connection, reals = self.connection, self._last_call.reals
        connection.settle()  # before the worker reads the time of this step
        connection.time = self._time = reals[TIME] = time
        reals[STEP] = self._length = length
        self._run(program)

    def adopt(self, program: CommandCalls, length: float) -> None:
        """Wait for a step that C has sent, when it is to be completed."""
        self._under_way, self._waiting, self._length = program, True, length
        self._time = self.connection.adopt(self, program.calls)

    def complete(self) -> None:
        """Wait for the end of the step, or raise RunError."""
        if self._waiting:
            self._complete()

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values of one type by value reference."""
        return self._call("set_start", f"Set{scalar}", list(values.items()), scalar)

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span."""
        return self._call("setup_experiment", "SetupExperiment", start, stop)

    def enter_initialization(self) -> int:
        """Enter initialization mode."""
        return self._call("enter_initialization", "EnterInitializationMode")

    def exit_initialization(self) -> int:
        """Leave initialization mode."""
        return self._call("exit_initialization", "ExitInitializationMode")

    def save_state(self, folder: str) -> int:
        """Serialise the state into a folder, which the worker sees as the master does."""
        return self._call("save_state", "GetFMUstate", folder)

    def restore_state(self, folder: str) -> int:
        """Set the state that a folder holds."""
        return self._call("restore_state", "SetFMUstate", folder)

    def failed(self, status: int) -> None:
        """Do nothing: the worker has noted the failure."""

    def outcome(self, call: str, status: int) -> str:
        """Describe how a call failed."""
        return self._outcome or returned(self.prefix, call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi2OK."""
        return " | ".join(self._messages)

    def close(self) -> None:
        """Terminate, free and end the process; a failure is logged. Never raises, may be called twice."""
        if self._closed:
            return
        self._closed = True
        try:
            self.connection.close(self._free)
        except RunError as error:
            self._log(self.name, ERROR, "isolation", str(error))

    def _free(self, last: bool) -> None:
        self.complete()
        self._request("FreeInstance", method="close", last=last)

    def port(self, kind: str, scalar: Scalar, references: NDArray[np.uint32]) -> tuple[int, Buffer]:
        """Return the number of a set or get, and the region of its values."""
        key = (kind, scalar, references.tobytes())
        if key not in self._ports:
            self.ready()
            self.complete()
            try:
                offset, region = self.connection.array(scalar, len(references))
            except MemoryError as error:
                raise RunError(f"{self.name}: {error}") from None
            name = f"{kind.capitalize()}{scalar}"
            self._request(name, method="port", kind=kind, scalar=scalar, references=references.tolist(), offset=offset)
            names = self.connection.ports
            self._ports[key] = (len(names), region)
            names.append(name)
        return self._ports[key]

    def flush(self) -> None:
        """Send the sets that wait for a step, before another request steps the FMU."""
        self.complete()
        if self._pending:
            self._run(self.program((tuple(self._pending), False, ())))
            self._complete()
        self._current = _NONE

    def _run(self, program: CommandCalls) -> None:
        """Send the command of a program; its answer has to be waited for."""
        self._pending.clear()
        self._under_way = program
        self._waiting = True
        self.connection.send(self, program.calls, program.number)

    def _single(self, name: str) -> CommandCalls:
        """Return a message that leads to one call."""
        return CommandCalls(number=0, calls=of_one(self.name, self.prefix, [name]), gets=frozenset())

    def program(self, key: Key) -> CommandCalls:
        """Return the program that makes these calls of ports; it is sent to the worker once."""
        if key in self._programs:
            return self._programs[key]
        sets, steps, gets = key
        self._request("DoStep", method="program", sets=sets, steps=steps, gets=gets)
        names = self.connection.ports
        calls = (*(names[port] for port in sets), *(("DoStep",) * steps), *(names[port] for port in gets))
        self.connection.programs = number = self.connection.programs + 1
        program = CommandCalls(number=number, calls=of_one(self.name, self.prefix, calls), gets=frozenset(gets))
        self._programs[key] = program
        return program

    def _call(self, method: str, name: str, *arguments: object) -> int:
        """Have the worker call a method of its slave; return the status."""
        self.ready()
        self.flush()
        answer = self._request(name, method=method, arguments=arguments)
        self._outcome = str(answer.get("outcome", ""))
        return int(answer["status"])

    def _request(self, name: str, **message: object) -> Answer:
        """Send a message and return the answer. `name` is the call that it leads to, for error messages."""
        self._under_way = self._single(name)
        self._send(json.dumps({"slave": self.number, **message}).encode())
        return self._complete()

    def _send(self, message: bytes) -> None:
        self._waiting = True
        self.connection.send(self, self._under_way.calls, 0, message, call=1)

    def _complete(self) -> Answer:
        """Wait for the answer."""
        answer, self._answer = self._answer, None
        if answer is None:
            answer = self.connection.read()
        self._waiting = False
        if answer.get("failed") is None:
            self._current = self._under_way.gets
            return answer
        failed = str(answer["failed"])
        end = regular_end(failed, self.name, self._time, self._length)
        if end is not None:
            self._current = self._under_way.gets if end.complete else _NONE
            raise end
        logged = f": {self.last_messages()}" if self._messages else ""
        raise RunError(f"{self.name}: {failed} at {self._time:.9g} s{logged}")


class _Step:
    """A call that begins a step, with the sets before it and the gets after it when it was called last."""

    def __init__(self, slave: RemoteSlave) -> None:
        self.expected: list[int] = []
        self.sets: tuple[int, ...] = ()
        self.program: CommandCalls | None = None  # for these sets, and the gets expected
        self._begin = slave.start_step

    def __call__(self, time: float, length: float, _no_set_state: int) -> int:
        self._begin(self, time, length)
        return OK
