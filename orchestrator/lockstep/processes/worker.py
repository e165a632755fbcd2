"""The process of one isolated FMU: `python -m lockstep.processes.worker COMMANDS ANSWERS MEMORY`, three descriptors.

A command is four bytes. A positive number asks for a program: sets, a step and gets that were told before, all in one
go. A negative one announces a message of so many bytes. The answer is one byte: 0, or 1 and a message.
"""

from __future__ import annotations

import ctypes
import json
import os
import pickle
import resource
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
from lockstep.fmi.slave import ERROR, FATAL, WARNING, Slave
from lockstep.processes.pipe_messages import pack, read_exactly, write_all
from lockstep.processes.shared_memory import BUSY, PLACE, STEP, TIME, Shared
from lockstep.processes.string_transfer import first_decode, then_encode

PR_SET_PDEATHSIG = 1  # linux/prctl.h
_MOST_MESSAGES = 1001  # one more than the events list, so that they can say that there were more
_LONGEST_MESSAGE = 2000  # letters

_CALLS = {
    "setup_experiment": "SetupExperiment",
    "enter_initialization": "EnterInitializationMode",
    "exit_initialization": "ExitInitializationMode",
    "save_state": "GetFMUstate",
    "restore_state": "SetFMUstate",
}

Call = Callable[[], int]
Program = tuple[tuple[Call, ...], bool, tuple[Call, ...]]


class Worker:
    """One FMU and what may be asked of it."""

    def __init__(self, shared: Shared) -> None:
        self.shared = shared
        self.slave: Slave | None = None
        self.ports: list[Call] = []
        self.programs: list[Program] = [((), False, ())]
        self.calls: list[str] = []  # of the ports, as FMI names them after its prefix
        self.names: list[tuple[str, ...]] = [()]  # of the calls of the programs
        self.fatal = False
        self._sent = 0
        self._messages: deque[tuple[int, str, str]] = deque()

    def log(self, _component: str, status: int, category: str, message: str) -> None:
        """Keep a message for the next answer; after a number of them the last few only."""
        text = message[:_LONGEST_MESSAGE]
        self.shared.say(" ".join(text.split()))
        self._messages.append((status, category, text))
        if self._sent + len(self._messages) > _MOST_MESSAGES and len(self._messages) > 3:
            self._messages.popleft()

    def run(self, number: int) -> bytes:
        """Run a program and return the answer."""
        sets, steps, gets = self.programs[number]
        shared, place = self.shared, 0
        where, slave = shared.integers, self.slave
        assert slave is not None
        status = 0
        for call in sets:
            where[PLACE] = place = place + 1
            status = call()
            if status > WARNING:
                return self._failed(number, place, status)
        if steps:
            where[PLACE] = place = place + 1
            status = slave.do_step(shared.reals[TIME], shared.reals[STEP], 1)
            if status > WARNING:
                return self._failed(number, place, status)
        for call in gets:
            where[PLACE] = place = place + 1
            status = call()
            if status > WARNING:
                return self._failed(number, place, status)
        where[PLACE] = 0
        return self._told({}) if self._messages else b"\0"

    def _failed(self, number: int, place: int, status: int) -> bytes:
        self._note(status)
        self.shared.integers[PLACE] = 0
        assert self.slave is not None
        outcome = self.slave.outcome(self.names[number][place - 1], status)
        return self._told({"place": place, "outcome": outcome})

    def _told(self, content: dict[str, Any]) -> bytes:
        messages = list(self._messages)
        self._messages.clear()
        self._sent += len(messages)
        return b"\1" + pack(content | {"log": messages})

    def answer(self, told: dict[str, Any]) -> bytes:
        """Do what a message asks for and return the answer."""
        match told["ask"]:
            case "port":
                references = np.array(told["references"], np.uint32)
                region = self.shared.region(told["scalar"], len(references), told["offset"])
                bind = self.slave.getter if told["kind"] == "get" else self.slave.setter  # type: ignore[union-attr]
                if told["scalar"] == "String":
                    texts = np.full(len(references), "", np.object_)
                    call = bind(told["scalar"], references, texts)
                    if told["kind"] == "get":
                        self.ports.append(then_encode(call, texts, region, self._refuse))
                    else:
                        self.ports.append(first_decode(region, texts, call))
                else:
                    self.ports.append(bind(told["scalar"], references, region))
                self.calls.append(f"{told['kind'].capitalize()}{told['scalar']}")
                return b"\0"
            case "program":
                sets, gets = (tuple(self.ports[number] for number in told[kind]) for kind in ("sets", "gets"))
                self.programs.append((sets, told["steps"], gets))
                names = [[self.calls[number] for number in told[kind]] for kind in ("sets", "gets")]
                self.names.append((*names[0], *(("DoStep",) * told["steps"]), *names[1]))
                return b"\0"
        arguments = told["arguments"]
        if told["ask"] == "set_start":
            arguments = [dict(arguments[0]), arguments[1]]
        status = getattr(self.slave, told["ask"])(*arguments)
        if status is None or status <= WARNING:
            return self._told({"status": status})
        self._note(status)
        return self._told({"status": status, "outcome": self._outcome(told["ask"], arguments, status)})

    def _outcome(self, ask: str, arguments: list[Any], status: int) -> str:
        assert self.slave is not None
        call = f"Set{arguments[1]}" if ask == "set_start" else _CALLS.get(ask, ask)
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
            self.slave = instantiate(component, description, Path(folder, "fmu"), self.log)
        except (InputError, RunError) as error:
            return self._told({"refused": type(error).__name__, "reason": str(error)})
        return self._told({})


def main(arguments: list[str]) -> int:
    """Serve until told to close, or until the master is gone."""
    commands, answers, memory = map(int, arguments)
    _limit()
    worker = Worker(Shared(memory))
    os.close(memory)
    try:
        first = int.from_bytes(read_exactly(commands, 4), "little", signed=True)
        write_all(answers, worker.open(read_exactly(commands, -first)))
        read, write, run, reals = os.read, os.write, worker.run, worker.shared.reals
        while True:
            command = read(commands, 4)
            began = perf_counter()
            number = int.from_bytes(command, "little", signed=True)
            if number > 0:
                answer = run(number)
            elif len(command) < 4:
                break  # the master is gone
            else:
                told = json.loads(read_exactly(commands, -number))
                answer = worker.answer(told)
                if told["ask"] == "close":
                    write_all(answers, answer)
                    break
            reals[BUSY] += perf_counter() - began
            if len(answer) == 1:
                write(answers, answer)
            else:
                write_all(answers, answer)
    except (EOFError, BrokenPipeError):
        pass
    finally:
        if worker.slave is not None:
            worker.slave.close()
    sys.stdout.flush()
    if worker.fatal:
        os._exit(0)  # nothing of the library may run any more, not even what it does at exit
    return 0


def _limit() -> None:
    """Write no core files, leave Ctrl-C to the master, and end with it."""
    _, hard = resource.getrlimit(resource.RLIMIT_CORE)
    resource.setrlimit(resource.RLIMIT_CORE, (0, hard))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
