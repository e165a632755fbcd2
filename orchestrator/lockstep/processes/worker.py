"""The process of one isolated FMU: `python -m lockstep.processes.worker COMMANDS ANSWERS MEMORY`, three descriptors.

A request runs a program: sets, a step and gets that were defined before; or it is a message (`shared_memory.py`).
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
from collections import deque
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from lockstep.errors import InputError, RunError
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.slave import ERROR, FATAL, WARNING, Slave, regular_end
from lockstep.interrupt import ENDING
from lockstep.operating_system import limit_process
from lockstep.processes.last_call import BUSY, CALL, STEP, TIME
from lockstep.processes.shared_memory import ANSWER, PROGRAM, REQUEST, WAKE, SharedMemory
from lockstep.processes.string_transfer import first_decode, then_encode

_MOST_MESSAGES = 1001  # one more than the events list, so that they can say that there were more
_LONGEST_MESSAGE = 2000  # letters

_CALLS = {
    "setup_experiment": "SetupExperiment",
    "enter_initialization": "EnterInitializationMode",
    "exit_initialization": "ExitInitializationMode",
    "save_state": "GetFMUstate",
    "restore_state": "SetFMUstate",
}

Transfer = Callable[[], int]
Program = tuple[tuple[Transfer, ...], bool, tuple[Transfer, ...]]


class Worker:
    """One FMU and the requests that it can answer."""

    def __init__(self, shared: SharedMemory) -> None:
        self.shared = shared
        self.last_call = shared.last_call
        self.slave: Slave | None = None
        self.ports: list[Transfer] = []
        self.programs: list[Program] = [((), False, ())]
        self.calls: list[str] = []  # of the ports, as FMI names them after its prefix
        self.names: list[tuple[str, ...]] = [()]  # of the calls of the programs
        self.fatal = False
        self._process = os.getpid()
        self._sent = 0
        self._ended = False  # the FMU asked for the end, with a complete step whose outputs count
        self._messages: deque[tuple[int, str, str]] = deque()

    def log(self, _component: str, status: int, category: str, message: str) -> None:
        """Keep a message for the next answer; after a number of them the last few only."""
        if os.getpid() != self._process:
            return  # a copy of the process that the FMU made: it has no part in the shared memory
        text = message[:_LONGEST_MESSAGE]
        self.last_call.leave_text(" ".join(text.split()))
        self._messages.append((status, category, text))
        if self._sent + len(self._messages) > _MOST_MESSAGES and len(self._messages) > 3:
            self._messages.popleft()

    def run(self, number: int) -> bytes:
        """Run a program and return the message that answers, if there is anything to say."""
        sets, steps, gets = self.programs[number]
        reals, integers, slave = self.last_call.reals, self.last_call.integers, self.slave
        number_of_call = 0
        assert slave is not None
        status = 0
        for call in sets:
            integers[CALL] = number_of_call = number_of_call + 1
            status = call()
            if status > WARNING:
                return self._failed(number, number_of_call, status)
        if steps:
            integers[CALL] = number_of_call = number_of_call + 1
            status = slave.do_step(reals[TIME], reals[STEP], 1)
            if status > WARNING:
                failed = self._failed(number, number_of_call, status)
                if not self._ended:
                    return failed
        for call in gets:
            integers[CALL] = number_of_call = number_of_call + 1
            status = call()
            if status > WARNING:
                return self._failed(number, number_of_call, status)
        integers[CALL] = 0
        if self._ended:
            return failed
        return self._reply({}) if self._messages else b""

    def _failed(self, number: int, number_of_call: int, status: int) -> bytes:
        self._note(status)
        self.last_call.integers[CALL] = 0
        assert self.slave is not None
        outcome = self.slave.outcome(self.names[number][number_of_call - 1], status)
        end = regular_end(outcome, "", self.last_call.reals[TIME], self.last_call.reals[STEP])
        self._ended = end is not None and end.complete
        return self._reply({"failed": outcome})

    def _reply(self, content: dict[str, Any]) -> bytes:
        messages = list(self._messages)
        self._messages.clear()
        self._sent += len(messages)
        return json.dumps(content | {"log": messages}).encode()

    def answer(self, request: dict[str, Any]) -> bytes:
        """Do what a message requests and return the message that answers, if there is anything to say."""
        match request["method"]:
            case "port":
                references = np.array(request["references"], np.uint32)
                region = self.shared.region(request["scalar"], len(references), request["offset"])
                bind = self.slave.getter if request["kind"] == "get" else self.slave.setter  # type: ignore[union-attr]
                if request["scalar"] == "String":
                    texts = np.full(len(references), "", np.object_)
                    call = bind(request["scalar"], references, texts)
                    if request["kind"] == "get":
                        self.ports.append(then_encode(call, texts, region, self._refuse))
                    else:
                        self.ports.append(first_decode(region, texts, call))
                else:
                    self.ports.append(bind(request["scalar"], references, region))
                self.calls.append(f"{request['kind'].capitalize()}{request['scalar']}")
                return b""
            case "program":
                sets, gets = (tuple(self.ports[number] for number in request[kind]) for kind in ("sets", "gets"))
                self.programs.append((sets, request["steps"], gets))
                names = [[self.calls[number] for number in request[kind]] for kind in ("sets", "gets")]
                self.names.append((*names[0], *(("DoStep",) * request["steps"]), *names[1]))
                return b""
        arguments = request["arguments"]
        if request["method"] == "set_start":
            arguments = [dict(arguments[0]), arguments[1]]
        status = getattr(self.slave, request["method"])(*arguments)
        if status is None or status <= WARNING:
            return self._reply({"status": status})
        self._note(status)
        return self._reply({"status": status, "outcome": self._outcome(request["method"], arguments, status)})

    def _outcome(self, method: str, arguments: list[Any], status: int) -> str:
        assert self.slave is not None
        call = f"Set{arguments[1]}" if method == "set_start" else _CALLS.get(method, method)
        return self.slave.outcome(call, status)

    def _refuse(self, reason: str) -> int:
        self.log("", ERROR, "isolation", reason)
        return ERROR

    def _note(self, status: int) -> None:
        assert self.slave is not None
        self.slave.failed(status)
        self.fatal = self.fatal or status >= FATAL

    def open(self, start: bytes) -> bytes:
        """Load and instantiate the FMU."""
        component, description, folder = pickle.loads(start)
        try:
            self.slave = instantiate(component, description, Path(folder, "fmu"), self.log, alone=True)
        except (InputError, RunError) as error:
            kind = InputError if isinstance(error, InputError) else RunError
            return self._reply({"refused": kind.__name__, "reason": str(error)})
        return self._reply({})


def main(arguments: list[str]) -> int:
    """Serve until a request to close, or until the master has ended."""
    commands, answers, memory = map(int, arguments)
    for descriptor in (commands, answers):
        os.set_inheritable(descriptor, False)
    _limit()
    shared = SharedMemory(memory)
    os.close(memory)
    shared.hide_from_copies()
    worker = Worker(shared)
    try:
        _serve(worker, commands, answers)
    except BrokenPipeError:
        pass
    finally:
        if worker.slave is not None:
            worker.slave.close()
    sys.stdout.flush()
    if worker.fatal:
        os._exit(0)  # nothing of the library may run any more, not even what it does at exit
    return 0


def _serve(worker: Worker, commands: int, answers: int) -> None:
    """Answer the requests of the master, each once."""
    read, write, run = os.read, os.write, worker.run
    reals, numbers = worker.last_call.reals, worker.shared.numbers
    number, closing = 0, False
    while not closing and read(commands, 1):  # it ends where the master has ended
        began = perf_counter()
        if numbers[REQUEST] == number:
            continue  # woken by somebody else
        number += 1
        if numbers[REQUEST] != number:
            raise RuntimeError(f"request {numbers[REQUEST]} came where {number} was expected")
        program = numbers[PROGRAM]
        if program:
            message = run(program)
        elif number == 1:
            message = worker.open(worker.shared.message())
        else:
            request = json.loads(worker.shared.message())
            message = worker.answer(request)
            closing = request["method"] == "close"
        if message:
            worker.shared.put_message(message)
        reals[BUSY] += perf_counter() - began
        numbers[ANSWER] = -number if message else number
        write(answers, WAKE)


def _limit() -> None:
    """Write no core files, and leave the signals that end a run to the master."""
    limit_process(core=0)
    for number in ENDING:  # not ignored, which what the FMU starts would inherit
        signal.signal(number, lambda *_: None)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
