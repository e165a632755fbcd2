"""A worker process as its parent sees it: start it, give it tasks, notice that it crashes, hangs or vanishes."""

from __future__ import annotations

import multiprocessing.connection
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic
from typing import Any, Literal

from lockstep.interrupt import ENDING
from lockstep.operating_system import interrupts_held_back, was_killed

Progress = Callable[[float, float], None]
Kind = Literal["crash", "hang", "vanished"]
_START = 120.0  # s that a process may take to start, on a machine under load
_END = 10.0  # s to close its results
_POLL = 0.5  # s between two looks at whether the work is to end
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class LostWorker(Exception):
    """The process of a task ended or hung. `str` is the cause, the same for every such end."""

    def __init__(self, kind: Kind, cause: str) -> None:
        super().__init__(kind, cause)
        self.kind, self.cause = kind, cause

    def __str__(self) -> str:
        return self.cause


class MachineFailure(Exception):
    """The machine could not do what a task needs. `str` is the cause."""


class BugInWorker(Exception):
    """A task raised what no task should raise; the traceback of its process is a note."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence:
    """How long a task may show no progress [s]."""

    limit: float = 60.0

    @property
    def cause(self) -> str:
        """What is said of one that hangs."""
        return f"no progress in {self.limit:g} s"


class WorkerProcess:
    """A process that carries out one task at a time. It is started for the first one, and again after it was lost."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: multiprocessing.connection.Connection | None = None
        self._ending = threading.Event()

    def run(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], silence: Silence, progress: Progress
    ) -> Any:
        """Carry out a task and return its result.

        Raises
        ------
        LostWorker
            If its process ends or hangs; the process is gone then.
        MachineFailure
            If the operating system refused something, or memory is short.
        InputError, RunError
            What the task raised.
        KeyboardInterrupt
            If `end` was called meanwhile.
        """
        try:
            connection = self._started()
            connection.send_bytes(pickle.dumps((function, arguments)))
            kind, *content = self._receive(Silence(limit=max(_START, silence.limit)), progress)
            if kind == "begun":
                kind, *content = self._receive(silence, progress)
        except (EOFError, ConnectionError):
            raise self._lost() from None
        match kind:
            case "done":
                return content[0]
            case "raised":
                raise content[0]
            case "machine":
                raise MachineFailure(content[0])
        bug = BugInWorker(content[0])
        bug.add_note(content[1])
        raise bug

    def end(self) -> None:
        """Ask the process to close what it writes and end; a task under way raises KeyboardInterrupt."""
        self._ending.set()
        process = self._process
        if process is not None and process.poll() is None:
            with suppress(ProcessLookupError):
                process.send_signal(signal.SIGINT)

    def close(self) -> None:
        """End the process."""
        self._ending.set()
        connection, process = self._connection, self._process
        self._connection = self._process = None
        if connection is not None:
            connection.close()
        if process is not None:
            try:
                process.wait(_END)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def restart(self) -> None:
        """Have the next task carried out by another process."""
        self._kill()

    def _started(self) -> multiprocessing.connection.Connection:
        """Return the connection to the process; start it if there is none, or it ended for want of tasks."""
        if self._ending.is_set():
            raise KeyboardInterrupt
        if self._process is not None and self._process.poll() is not None:
            self.close()
            self._ending.clear()
        if self._connection is not None:
            return self._connection
        here, there = socket.socketpair()
        environment = {**dict.fromkeys(_ONE_THREAD, "1"), **os.environ}
        command = [sys.executable, "-m", "flexbench.engine.worker_process", str(there.fileno()), str(os.getpid())]
        with there, interrupts_held_back(ENDING):  # of a process that is not ready for them
            self._process = subprocess.Popen(
                command, pass_fds=[there.fileno()], stdin=subprocess.DEVNULL, env=environment
            )
        self._connection = multiprocessing.connection.Connection(here.detach())
        self._connection.send_bytes(pickle.dumps(sys.path))
        self._receive(Silence(limit=_START), lambda *_: None)
        return self._connection

    def _receive(self, silence: Silence, progress: Progress) -> tuple[Any, ...]:
        """Return the next answer that is no progress."""
        assert self._connection is not None
        last = monotonic()
        asked: float | None = None
        while True:
            if self._connection.poll(_POLL):
                try:
                    message: tuple[Any, ...] = pickle.loads(self._connection.recv_bytes())
                except OSError:
                    raise EOFError from None  # it ended in the middle of a message
                if message[0] != "progress":
                    return message
                last = monotonic()
                progress(*message[1:])
            elif self._ending.is_set():
                asked = asked or monotonic()
                if monotonic() - asked > _END:
                    self._kill()
                    raise KeyboardInterrupt
            elif monotonic() - last > silence.limit:
                self._kill()
                raise LostWorker("hang", silence.cause)

    def _kill(self) -> None:
        assert self._process is not None
        self._process.kill()
        ending = self._ending.is_set()
        self.close()
        if not ending:
            self._ending.clear()

    def _lost(self) -> BaseException:
        """Return what to raise for a process that ended; the next task gets another one."""
        assert self._process is not None
        if self._ending.is_set():
            return KeyboardInterrupt()
        try:
            code = self._process.wait(_END)
        except subprocess.TimeoutExpired:  # it closed its connection and lives
            self._kill()
            return LostWorker("crash", "its process closed the connection")
        self.close()
        self._ending.clear()
        if was_killed(code):
            return LostWorker("vanished", "its process was killed (SIGKILL)")
        how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
        return LostWorker("crash", f"its process ended {how}")
