"""The connection between the master and one worker, which runs one FMU or several.

A request is a number in the shared memory and a byte that wakes the worker; so is its answer (`shared_memory.py`). One
request is under way at a time: before another one its answer is read, and kept by whoever made it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any, Protocol

from lockstep.errors import InputError, RunError, compact
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.slave import WARNING, Buffer, Scalar
from lockstep.interrupt import Interrupt
from lockstep.operating_system import can_isolate
from lockstep.processes.cpu_affinity import SAMPLE, core_assignment
from lockstep.processes.last_call import CALL, SPEAKER, TIME
from lockstep.processes.shared_memory import ANSWER, PROGRAM, REQUEST, START, WAKE, SharedMemory, shared_file
from lockstep.processes.watched_process import Limits, WatchedProcess
from lockstep.processes.worker_link import NOBODY, PYTHON

_LAST_STEP, _LAST_CALLS = 2.0, 10.0  # [s] for a step whose result is not needed any more, and for terminating

Answer = dict[str, Any]


class Asking(Protocol):
    """Who makes requests."""

    def keep(self, answer: Answer) -> None:
        """Take the answer, since the connection is needed for another request."""
        ...


class Speaking(Protocol):
    """Whose messages the worker sends: one FMU."""

    name: str

    def take_message(self, status: int, category: str, text: str) -> None:
        """Take a message that the FMU logged."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Calls:
    """The calls of FMI that a request leads to, in order, and the component of each."""

    names: tuple[str, ...]
    components: tuple[str, ...]


class Connection:
    """One worker's process, and the requests to it."""

    def __init__(self, name: str, folder: Path, log: Log, limits: Limits | None = None) -> None:
        """Start the worker. `name` is that of the component for which it is started."""
        if not can_isolate():
            remedy = f"give --share-process {name}"
            raise InputError(f"{name}: cannot run in a process of its own on this operating system; {remedy}")
        self._log = log
        self.speakers: list[Speaking] = []  # by the number of the FMU
        self.ports: list[str] = []  # the calls of all ports, without the prefix of FMI
        self.programs = 0
        self.time = 0.0  # of the last step [s]
        self.broken = self.closing = self._ended = self._disturbed = False
        self._open = 0  # FMUs that have not been closed
        self._asking: Asking | None = None  # whose request is under way
        self.adopt_from_c: Callable[[], None] = lambda: None  # has those who C asks for call `adopt`
        self._under_way = Calls(names=(), components=(name,))
        memory = shared_file()
        worker_commands, self._commands = os.pipe()
        self._answers, worker_answers = os.pipe()
        try:
            self._shared = SharedMemory(memory)
            self.last_call, self.numbers = self._shared.last_call, self._shared.numbers
            self.link = self._shared.link(self._commands, self._answers)
            integers = self.last_call.integers
            self._cores = core_assignment()
            self._cores.give_back()
            descriptors = (worker_commands, worker_answers, memory)
            self.process = WatchedProcess(
                descriptors, folder.absolute(), limits or Limits(), lambda: integers[CALL], self.link
            )
        finally:
            for descriptor in (memory, worker_commands, worker_answers):
                os.close(descriptor)
        self._worker = self._cores.add(self.process.guard, self.last_call, self.link)

    def add(self, speaker: Speaking) -> int:
        """Add an FMU, which its user closes; return its number."""
        self.speakers.append(speaker)
        self._open += 1
        return len(self.speakers) - 1

    def started(self) -> None:
        """Note that the worker has answered: its process is there."""
        self._worker.pid = self.process.pid

    def array(self, scalar: Scalar, count: int) -> tuple[int, Buffer]:
        """Return a new array in the memory that the worker sees, and its place there, or raise MemoryError."""
        offset = self._shared.allocate(scalar, count)
        return offset, self._shared.region(scalar, count, offset)

    def request(self, asking: Asking, name: str, component: str, message: dict[str, object]) -> Answer:
        """Send a message and return the answer. `name` is the call that it leads to, with the prefix of FMI."""
        self.send(asking, Calls(names=(name,), components=(component,)), 0, json.dumps(message).encode(), call=1)
        return self.read()

    def send(
        self, asking: Asking, calls: Calls, program: int, message: bytes = b"", *, start: int = 0, call: int = -1
    ) -> None:
        """Make a request: to run a program from a call on, or what a message says; `call` is the one under way then."""
        self.settle()
        if message:
            try:
                self._shared.put_message(message)
            except ValueError as error:
                raise RunError(f"{calls.components[0]}: {error}") from None
        if call >= 0:
            self.last_call.integers[CALL] = call
        self._under_way = calls
        link, worker = self.link, self._worker
        link.busy_since = now = monotonic()
        link.messages = messages = link.messages + 1
        if messages % SAMPLE == 0 or self._cores.timed:
            self._cores.message_sent(worker, now)
        link.number = number = link.number + 1
        numbers = self.numbers
        numbers[PROGRAM] = program
        numbers[START] = start
        numbers[REQUEST] = number
        self._asking, link.asking = asking, PYTHON
        try:
            os.write(self._commands, WAKE)
        except BrokenPipeError:
            raise self._death() from None

    def adopt(self, asking: Asking, calls: Calls) -> float:
        """Wait for the answer to a request that C has made when it is needed; return the time of its step [s]."""
        self._asking, self._under_way = asking, calls
        self.link.asking, self.link.timed = PYTHON, 0
        self.time = self.last_call.reals[TIME]
        return self.time

    def settle(self) -> None:
        """Wait until no request is under way: whoever made the last one keeps its answer."""
        if self.link.asking > NOBODY:
            self.adopt_from_c()
        if self._asking is not None:
            asking, answer = self._asking, self.read()
            asking.keep(answer)

    def read(self) -> Answer:
        """Wait for the answer to the request under way."""
        answer = self._read()
        self._asking, self.link.asking = (
            None,
            NOBODY,
        )  # not before: a second Ctrl-C interrupts the wait, and the answer is still to come
        return answer

    def _read(self) -> Answer:
        if self._worker in self._cores.timed:
            self._cores.waits(self._worker)
        woken = os.read(self._answers, 1)
        number, answer = self.link.number, self.numbers[ANSWER]
        while woken and answer not in (number, -number):
            self._disturb()
            woken = os.read(self._answers, 1)
            answer = self.numbers[ANSWER]
        self.link.busy_since = 0.0
        if woken and answer == number:
            return {}
        try:
            if not woken:
                raise EOFError
            message = json.loads(self._shared.message())
            for speaker, status, category, text in message["log"]:
                self.speakers[speaker].take_message(status, category, text)
            return dict(message)
        except (EOFError, KeyError, TypeError, ValueError, IndexError):  # it ended, or its answer is invalid
            raise self._death() from None

    def _disturb(self) -> None:
        """Note once that something other than the worker writes to the pipe of its answers."""
        if not self._disturbed:
            self._disturbed = True
            text = "it, or a process that it started, writes to the pipe of its answers to the master; that is ignored"
            self._log(compact(speaker.name for speaker in self.speakers), WARNING, "isolation", text)

    def _death(self) -> RunError | KeyboardInterrupt:
        """Return what ended the process, as an error that names the FMU whose call was under way."""
        self.broken, self._asking, self.link.asking = True, None, NOBODY
        self._cores.timed.discard(self._worker)
        number, calls = self.last_call.integers[CALL], self._under_way
        inside = 0 < number <= len(calls.names)
        where = f"in {calls.names[number - 1]}" if inside else f"after {calls.names[-1]}" if calls.names else "idle"
        component = calls.components[number - 1] if inside else compact(dict.fromkeys(calls.components))
        cause = f"{self.process.how_it_ended()} {where} at {self.time:.9g} s"
        if self.process.interrupted:
            return self.process.interrupt.end()
        logged, speaker = self.last_call.text, self.last_call.integers[SPEAKER]
        known = 0 <= speaker < len(self.speakers) and self.speakers[speaker].name == component
        others = len(self.speakers) - 1
        remedy = f"; its process holds {others + 1} FMUs, --isolate {component} gives it one of its own"
        return RunError(
            f"{component}: {cause}"
            + (f"; it logged: {logged}" if logged and known else "")
            + (remedy if others and inside else "")
        )

    def close(self, free: Callable[[bool], object]) -> None:
        """Close one FMU by a call that frees it, unless the process has ended; after the last one end the process.

        The call gets whether it is the last one.

        Raises RunError if the process ended in that call.
        """
        self._open -= 1
        self.closing, grace = True, 0.0
        try:
            if not self.broken:
                self.process.interrupt = Interrupt()  # the FMU is being ended anyway
                self.process.closing = True
                self.process.limit = _LAST_STEP
                self.settle()
                self.process.limit = _LAST_CALLS
                free(self._open <= 0)
                grace = _LAST_CALLS
        finally:
            if self._open <= 0:
                self.end(grace)

    def end(self, grace: float = 0.0) -> None:
        """Wait so many seconds for the end of the process, then end it. May be called twice."""
        if self._ended:
            return
        self._ended = True
        self._cores.remove(self._worker)
        os.close(self._commands)
        self.process.end(grace)
        os.set_blocking(self._answers, False)
        with suppress(BlockingIOError):
            if not self.broken and os.read(self._answers, 1):  # more bytes than answers
                self._disturb()
        os.close(self._answers)


def of_one(component: str, prefix: str, names: Iterable[str]) -> Calls:
    """Return the calls of one component, named without the prefix of FMI."""
    found = tuple(f"{prefix}{name}" for name in names)
    return Calls(names=found, components=(component,) * max(1, len(found)))
