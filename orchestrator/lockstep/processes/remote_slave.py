"""A slave whose FMU runs in another process: values through shared memory, one round trip a step.

A request is a number in the shared memory and a byte that wakes the worker; so is its answer (`shared_memory.py`).

Inputs that are set are sent with the next step. `do_step` sends and returns at once: `overlaps` states that. The first
call after it waits for the answer, which holds the outputs that were fetched after the same step before. So the failure
of any call is reported when the answer is there, as a RunError that names the call, by whatever method waits for it.
"""

from __future__ import annotations

import json
import os
import pickle
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import InputError, RunError
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import ERROR, OK, WARNING, Buffer, Scalar, regular_end, returned
from lockstep.interrupt import Interrupt
from lockstep.operating_system import can_isolate
from lockstep.processes.cpu_affinity import SAMPLE, core_assignment
from lockstep.processes.last_call import CALL, STEP, TIME
from lockstep.processes.shared_memory import ANSWER, PROGRAM, REQUEST, WAKE, SharedMemory, shared_file
from lockstep.processes.string_transfer import RAW, first_encode, then_decode
from lockstep.processes.watched_process import Limits, WatchedProcess
from lockstep.system.component import Component, Value

_LAST_STEP, _LAST_CALLS = 2.0, 10.0  # [s] for a step whose result is not needed any more, and for terminating

_NONE: frozenset[int] = frozenset()

Key = tuple[tuple[int, ...], bool, tuple[int, ...]]  # sets, whether to step, gets


@dataclass(frozen=True, slots=True, kw_only=True)
class _Program:
    """The calls that the worker makes at one command."""

    number: int  # 0 for a message
    calls: tuple[str, ...]
    gets: frozenset[int]


class RemoteSlave:
    """One running instance in a process of its own. Implements `lockstep.fmi.slave.Slave`."""

    overlaps = True  # do_step only begins: complete, or a getter, waits for its end

    def __init__(
        self, component: Component, description: Description, folder: Path, log: Log, limits: Limits | None = None
    ) -> None:
        self.name, folder = component.name, folder.absolute()
        self._prefix = description.prefix
        self._log = log
        self._messages: deque[str] = deque(maxlen=3)
        self._outcome = ""  # of the call that failed last
        self._time = 0.0  # of the last step [s]
        self._waiting = self._ready = self._broken = self._closed = self._disturbed = False
        self._number = 0  # of the last request
        self._ports: dict[tuple[str, Scalar, bytes], tuple[int, Buffer]] = {}
        self._names: list[str] = []  # of the ports' calls
        self._programs: dict[Key, _Program] = {}
        self._under_way = _Program(number=0, calls=("Instantiate",), gets=frozenset())
        self._pending: dict[int, None] = {}  # sets to send with the next step, in order
        self._current = _NONE  # gets whose regions hold the present values
        self._used: list[int] = []  # gets called since the last step
        self._last: _Step | None = None
        if not can_isolate():
            remedy = f"give --share-process {self.name}"
            raise InputError(f"{self.name}: cannot run in a process of its own on this operating system; {remedy}")
        memory = shared_file()
        worker_commands, self._commands = os.pipe()
        self._answers, worker_answers = os.pipe()
        try:
            self._shared = SharedMemory(memory)
            self._last_call, self._numbers = self._shared.last_call, self._shared.numbers
            self._cores = core_assignment()
            self._cores.release()
            self._process = WatchedProcess((worker_commands, worker_answers, memory), folder, limits or Limits())
        finally:
            for descriptor in (memory, worker_commands, worker_answers):
                os.close(descriptor)
        self._worker = self._cores.add(self._process.guard, self._last_call)
        source, archive = component.source, component.archive
        if archive is None:
            source = source.absolute()  # the worker has another working directory
        else:
            archive = archive.absolute()
        part = Component(name=self.name, source=source, period=1, archive=archive, tolerance=component.tolerance)
        start = (part, replace(description, variables=dict(description.variables)), str(folder))
        self._send(0, pickle.dumps(start))

    def ready(self) -> None:
        """Wait until the FMU is instantiated, or raise the worker's error; several start side by side."""
        if not self._ready:
            self._ready = True
            answer = self._complete()
            self._worker.pid = self._process.pid
            if "refused" in answer:
                raise (InputError if answer["refused"] == "InputError" else RunError)(str(answer["reason"]))

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that waits for the step and copies the values that it gave."""
        if buffer.dtype == object:
            raw = np.zeros(len(references), RAW)
            return then_decode(self.getter(scalar, references, raw), raw, buffer)
        port, region = self._port("get", scalar, references)

        def get() -> int:
            if self._waiting:
                self._complete()
            self._used.append(port)
            if port not in self._current:
                current = self._current
                self._run(self._program((tuple(self._pending), False, (port,))))
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
        port, region = self._port("set", scalar, references)
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

    def begin(self, step: _Step, time: float, length: float) -> None:
        """Send a step, with the sets before it and the gets that it expects."""
        if self._waiting:
            self._complete()
        last, used = self._last, self._used
        if last is not None and used != last.expected:
            last.expected, last.program = list(dict.fromkeys(used)), None
        self._last, self._used = step, []
        reals = self._last_call.reals
        self._time = reals[TIME] = time
        reals[STEP] = length
        sets = tuple(self._pending)
        program = step.program
        if program is None or sets != step.sets:
            step.sets, step.program = sets, program = sets, self._program((sets, True, tuple(step.expected)))
        self._run(program)

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
        return self._outcome or returned(self._prefix, call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi2OK."""
        return " | ".join(self._messages)

    def close(self) -> None:
        """Terminate, free and end the process; a failure is logged. Never raises, may be called twice."""
        if self._closed:
            return
        self._closed = True
        grace = 0.0
        try:
            if not self._broken:
                self._process.interrupt = Interrupt()  # the FMU is being ended anyway
                self._process.closing = True
                self._process.limit = _LAST_STEP
                self.complete()
                self._process.limit = _LAST_CALLS
                self._request("FreeInstance", method="close", arguments=[])
                grace = _LAST_CALLS
        except RunError as error:
            self._log(self.name, ERROR, "isolation", str(error))
        finally:
            self._cores.remove(self._worker)
            os.close(self._commands)
            self._process.end(grace)
            os.set_blocking(self._answers, False)
            with suppress(BlockingIOError):
                if not self._broken and os.read(self._answers, 1):  # more bytes than answers
                    self._disturb()
            os.close(self._answers)

    def _port(self, kind: str, scalar: Scalar, references: NDArray[np.uint32]) -> tuple[int, Buffer]:
        key = (kind, scalar, references.tobytes())
        if key not in self._ports:
            self.ready()
            self.complete()
            try:
                offset = self._shared.allocate(scalar, len(references))
            except MemoryError as error:
                raise RunError(f"{self.name}: {error}") from None
            name = f"{kind.capitalize()}{scalar}"
            self._request(name, method="port", kind=kind, scalar=scalar, references=references.tolist(), offset=offset)
            self._ports[key] = (len(self._names), self._shared.region(scalar, len(references), offset))
            self._names.append(name)
        return self._ports[key]

    def _run(self, program: _Program) -> None:
        """Send the command of a program; its answer has to be waited for."""
        self._pending.clear()
        self._under_way = program
        self._send(program.number)

    def _program(self, key: Key) -> _Program:
        """Return the program that makes these calls; it is sent to the worker once."""
        if key in self._programs:
            return self._programs[key]
        sets, steps, gets = key
        self._request("DoStep", method="program", sets=sets, steps=steps, gets=gets)
        names = self._names
        calls = (*(names[port] for port in sets), *(("DoStep",) * steps), *(names[port] for port in gets))
        program = _Program(number=len(self._programs) + 1, calls=calls, gets=frozenset(gets))
        self._programs[key] = program
        return program

    def _call(self, method: str, name: str, *arguments: object) -> int:
        """Have the worker call a method of its slave; return the status."""
        self.ready()
        self.complete()
        if self._pending:
            self._run(self._program((tuple(self._pending), False, ())))
            self._complete()
        self._current = _NONE
        answer = self._request(name, method=method, arguments=arguments)
        self._outcome = str(answer.get("outcome", ""))
        return int(answer["status"])

    def _request(self, name: str, **message: object) -> dict[str, Any]:
        """Send a message and return the answer. `name` is the call that it leads to, for error messages."""
        self._under_way = _Program(number=0, calls=(name,), gets=frozenset())
        self._last_call.integers[CALL] = 1
        self._send(0, json.dumps(message).encode())
        return self._complete()

    def _send(self, program: int, message: bytes = b"") -> None:
        """Make a request: to run a program, or what a message says."""
        if message:
            try:
                self._shared.put_message(message)
            except ValueError as error:
                raise RunError(f"{self.name}: {error}") from None
        self._process.busy_since = now = monotonic()
        self._waiting = True
        worker = self._worker
        worker.messages += 1
        if worker.messages % SAMPLE == 0 or self._cores.timed:
            self._cores.message_sent(worker, now)
        self._number = number = self._number + 1
        numbers = self._numbers
        numbers[PROGRAM] = program
        numbers[REQUEST] = number
        try:
            os.write(self._commands, WAKE)
        except BrokenPipeError:
            raise self._death() from None

    def _complete(self) -> dict[str, Any]:
        """Wait for the answer."""
        if self._worker in self._cores.timed:
            self._cores.waits(self._worker)
        woken = os.read(self._answers, 1)
        number, answer = self._number, self._numbers[ANSWER]
        while woken and answer not in (number, -number):
            self._disturb()
            woken = os.read(self._answers, 1)
            answer = self._numbers[ANSWER]
        self._waiting = False
        self._process.busy_since = 0.0
        if woken and answer == number:
            self._current = self._under_way.gets
            return {}
        try:
            if not woken:
                raise EOFError
            message = json.loads(self._shared.message())
            for status, category, text in message["log"]:
                self._messages.append(" ".join(text.split()))
                self._log(self.name, status, category, text)
            failed = str(message["failed"]) if "failed" in message else None
        except (EOFError, KeyError, TypeError, ValueError, IndexError):  # it ended, or its answer is invalid
            raise self._death() from None
        if failed is not None:
            logged = f": {self.last_messages()}" if self._messages else ""
            end = regular_end(failed, self.name, self._time, self._last_call.reals[STEP])
            if end is not None:
                self._current = self._under_way.gets if end.complete else _NONE
                raise end
            raise RunError(f"{self.name}: {failed} at {self._time:.9g} s{logged}")
        self._current = self._under_way.gets
        return dict(message)

    def _disturb(self) -> None:
        """Note once that something other than the worker writes to the pipe of its answers."""
        if not self._disturbed:
            self._disturbed = True
            text = "it, or a process that it started, writes to the pipe of its answers to the master; that is ignored"
            self._log(self.name, WARNING, "isolation", text)

    def _death(self) -> RunError | KeyboardInterrupt:
        """Return what ended the process, as an error."""
        self._broken, self._waiting = True, False
        self._cores.timed.discard(self._worker)
        number = self._last_call.integers[CALL]
        calls = [f"{self._prefix}{call}" for call in self._under_way.calls]
        where = f"in {calls[number - 1]}" if 0 < number <= len(calls) else f"after {calls[-1]}" if calls else "idle"
        logged = self._last_call.text
        cause = f"{self._process.how_it_ended()} {where} at {self._time:.9g} s"
        if self._process.interrupted:
            return self._process.interrupt.end()
        return RunError(f"{self.name}: {cause}" + (f"; it logged: {logged}" if logged else ""))


class _Step:
    """A call that begins a step, with the sets before it and the gets after it when it was called last."""

    def __init__(self, slave: RemoteSlave) -> None:
        self.expected: list[int] = []
        self.sets: tuple[int, ...] = ()
        self.program: _Program | None = None  # for these sets, and the gets expected
        self._begin = slave.begin

    def __call__(self, time: float, length: float, _no_set_state: int) -> int:
        self._begin(self, time, length)
        return OK
