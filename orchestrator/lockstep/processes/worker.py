"""The process of isolated FMUs: `python -m lockstep.processes.worker COMMANDS ANSWERS MEMORY`, three descriptors.

A request runs a program: sets, a step and gets of one FMU, or a batch of steps (`batch.py`), that were defined before;
or it is a message (`shared_memory.py`).
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
from collections import Counter, deque
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from lockstep.errors import InputError, RunError
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.slave import ERROR, WARNING, Slave, regular_end
from lockstep.interrupt import ENDING
from lockstep.operating_system import limit_process
from lockstep.processes.batch import BoundBatch
from lockstep.processes.hosted_fmu import HostedFmu
from lockstep.processes.last_call import BUSY, CALL, SPEAKER, STEP, TIME
from lockstep.processes.shared_memory import ANSWER, PROGRAM, REQUEST, WAKE, SharedMemory
from lockstep.processes.string_transfer import first_decode, then_encode

_MOST_MESSAGES = 1001  # one more than the events list, so that they can say that there were more
_LONGEST_MESSAGE = 2000  # letters

_PICKLED = b"\x80"  # how what pickle writes begins, and JSON does not

_CALLS = {
    "setup_experiment": "SetupExperiment",
    "enter_initialization": "EnterInitializationMode",
    "exit_initialization": "ExitInitializationMode",
    "save_state": "GetFMUstate",
    "restore_state": "SetFMUstate",
}

Transfer = Callable[[], int]
Routine = Callable[[], bytes]  # returns the message that answers, if there is anything to say


class Worker:
    """The FMUs of this process, and the requests that it can answer."""

    def __init__(self, shared: SharedMemory) -> None:
        self.shared = shared
        self.last_call = shared.last_call
        self.hosts: dict[int, HostedFmu] = {}
        self.closing = False  # nothing is left to do
        self.ports: list[Transfer] = []
        self.programs: list[Routine] = [lambda: b""]
        self.calls: list[str] = []  # of the ports, as FMI names them after its prefix
        self._process = os.getpid()
        self.names: list[str] = []  # of the components
        self._numbers: dict[str, int] = {}  # of the FMUs, by component
        self._sent: Counter[int] = Counter()
        self._messages: dict[int, deque[tuple[int, str, str]]] = {}  # those not sent yet, by FMU

    def log(self, component: str, status: int, category: str, message: str) -> None:
        """Keep a message for the next answer; after a number of them the last few of each FMU only."""
        if os.getpid() != self._process:
            return  # a copy of the process that the FMU made: it has no part in the shared memory
        text, speaker = message[:_LONGEST_MESSAGE], self._numbers[component]
        self.last_call.leave_text(" ".join(text.split()))
        self.last_call.integers[SPEAKER] = speaker
        waiting = self._messages.setdefault(speaker, deque())
        waiting.append((status, category, text))
        if self._sent[speaker] + len(waiting) > _MOST_MESSAGES and len(waiting) > 3:
            waiting.popleft()

    def _program(self, host: HostedFmu, sets: list[int], steps: bool, gets: list[int]) -> Routine:
        """Return a program that makes calls of one FMU."""
        before, after = [self.ports[number] for number in sets], [self.ports[number] for number in gets]
        names = (*(self.calls[k] for k in sets), *(("DoStep",) * steps), *(self.calls[k] for k in gets))
        reals, integers, slave = self.last_call.reals, self.last_call.integers, host.slave

        def failed(number: int, status: int) -> dict[str, Any]:
            integers[CALL] = 0
            return {"failed": host.failed(names[number - 1], status)}

        def run() -> bytes:
            number = 0
            ended: dict[str, Any] | None = None  # it asked for the end, with a complete step whose outputs count
            for call in before:
                integers[CALL] = number = number + 1
                status = call()
                if status > WARNING:
                    return self.reply(failed(number, status))
            if steps:
                integers[CALL] = number = number + 1
                status = slave.do_step(reals[TIME], reals[STEP], 1)
                if status > WARNING:
                    ended = failed(number, status)
                    end = regular_end(ended["failed"], "", reals[TIME], reals[STEP])
                    if end is None or not end.complete:
                        return self.reply(ended)
            for call in after:
                integers[CALL] = number = number + 1
                status = call()
                if status > WARNING:
                    return self.reply(failed(number, status))
            integers[CALL] = 0
            return self.reply(ended) if ended else self.done()

        return run

    def done(self) -> bytes:
        """Return the answer to a request that is done: a message if there is anything to say."""
        return self.reply({}) if self._messages else b""

    def reply(self, content: dict[str, Any]) -> bytes:
        """Return an answer, with all that was logged since the last one."""
        log = [(speaker, *message) for speaker, waiting in self._messages.items() for message in waiting]
        self._sent.update(speaker for speaker, *_ in log)
        self._messages.clear()
        return json.dumps(content | {"log": log}).encode()

    def answer(self, message: bytes) -> bytes:
        """Do what a message requests and return the message that answers, if there is anything to say."""
        if message.startswith(_PICKLED):
            return self.open(message)
        request = json.loads(message)
        method = request["method"]
        if method == "batch":
            self.programs.append(BoundBatch(self, request).run)
            return b""
        if method == "close":
            return self._close(request)
        host = self.hosts[request["slave"]]
        if method == "port":
            self._add_port(host.slave, request)
            return b""
        if method == "program":
            self.programs.append(self._program(host, request["sets"], request["steps"], request["gets"]))
            return b""
        arguments = request["arguments"]
        if method == "set_start":
            arguments = [dict(arguments[0]), arguments[1]]
        status = getattr(host.slave, method)(*arguments)
        if status is None or status <= WARNING:
            return self.reply({"status": status})
        call = f"Set{arguments[1]}" if method == "set_start" else _CALLS.get(method, method)
        return self.reply({"status": status, "outcome": host.failed(call, status)})

    def _add_port(self, slave: Slave, request: dict[str, Any]) -> None:
        kind, scalar = request["kind"], request["scalar"]
        references = np.array(request["references"], np.uint32)
        region = self.shared.region(scalar, len(references), request["offset"])
        bind = slave.getter if kind == "get" else slave.setter
        if scalar == "String":
            texts = np.full(len(references), "", np.object_)
            call, refuse = bind(scalar, references, texts), partial(self._refuse, request["slave"])
            wrapped = then_encode(call, texts, region, refuse) if kind == "get" else first_decode(region, texts, call)
            self.ports.append(wrapped)
        else:
            self.ports.append(bind(scalar, references, region))
        self.calls.append(f"{kind.capitalize()}{scalar}")

    def _refuse(self, number: int, reason: str) -> int:
        self.log(self.names[number], ERROR, "isolation", reason)
        return ERROR

    def open(self, start: bytes) -> bytes:
        """Load and instantiate an FMU."""
        component, description, folder = pickle.loads(start)
        number = self._numbers[component.name] = len(self.names)
        self.names.append(component.name)
        try:
            slave = instantiate(component, description, Path(folder, "fmu"), self.log, alone=True)
        except (InputError, RunError) as error:
            kind = InputError if isinstance(error, InputError) else RunError
            return self.reply({"refused": kind.__name__, "reason": str(error)})
        self.hosts[number] = HostedFmu(slave)
        return self.reply({})

    def _close(self, request: dict[str, Any]) -> bytes:
        self.closing = bool(request["last"])
        host = self.hosts.get(request["slave"])  # one that could not be instantiated is not there
        if host is not None:
            host.slave.close()
        return self.reply({"status": None})


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
        for host in worker.hosts.values():
            host.slave.close()
    sys.stdout.flush()
    if any(host.fatal for host in worker.hosts.values()):
        os._exit(0)  # nothing of the library may run any more, not even what it does at exit
    return 0


def _serve(worker: Worker, commands: int, answers: int) -> None:
    """Answer the requests of the master, each once."""
    read, write, programs = os.read, os.write, worker.programs
    reals, numbers = worker.last_call.reals, worker.shared.numbers
    number = 0
    while not worker.closing and read(commands, 1):  # it ends where the master has ended
        began = perf_counter()
        if numbers[REQUEST] == number:
            continue  # woken by somebody else
        number += 1
        if numbers[REQUEST] != number:
            raise RuntimeError(f"request {numbers[REQUEST]} came where {number} was expected")
        program = numbers[PROGRAM]
        message = programs[program]() if program else worker.answer(worker.shared.message())
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
