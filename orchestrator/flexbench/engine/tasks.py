"""Tasks, and what comes of them; the function that an executor calls for each, on whatever machine."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter, time
from typing import Any, Literal

from lockstep.errors import InputError, RunError
from lockstep.fmi.safe_zip import TemporaryFolderError

from .content import File, found, receive
from .worker import LostWorker, MachineFailure, Silence, WorkerProcess

Failure = Literal["", "error", "crash", "hang", "vanished"]
TRIES = 2  # of a task whose process is lost


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A call of a function in a worker process. With files, their paths by file are its last argument."""

    number: int
    title: str
    function: Callable[..., Any]  # of a module that the worker process can import
    arguments: tuple[Any, ...]
    files: Sequence[File] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskSettings:
    """What all tasks of a pool have in common. It travels with each."""

    pool: str  # name of the pool: its tasks share worker processes
    silence: Silence = field(default_factory=Silence)
    store: Path | None = None  # of the files


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskOutcome:
    """What came of a task."""

    number: int
    result: Any = None
    failure: Failure = ""
    cause: str = ""  # one line, the same for every such failure
    error: BaseException | None = None  # that the function raised
    attempts: int = 1
    wall_time: float = 0.0  # s
    worker: str = ""
    ended: float = 0.0  # s since the epoch


@dataclass(frozen=True, slots=True, kw_only=True)
class Missing:
    """A task was not carried out, as its files are not on the machine."""

    number: int
    files: tuple[File, ...]
    worker: str


class NoResult(RunError):
    """A machine cannot carry out a task: that says nothing about the task."""


class DiskFull(NoResult):
    """A machine cannot write what a task needs: no result of the task."""


_workers: dict[tuple[str, int], WorkerProcess] = {}  # by pool and thread
_listeners: dict[str, Callable[[int, float, float], None]] = {}  # to progress, by pool, where that is in this process
_ended: set[str] = set()  # pools whose tasks are not to be carried out any more
_lock = threading.Lock()


def carry_out(
    task: Task, settings: TaskSettings, contents: Mapping[File, bytes] | None = None
) -> TaskOutcome | Missing:
    """Carry out a task in the worker process of this thread, twice if that is lost, and return what came of it."""
    if contents:
        receive(contents)
    paths = found(task.files, settings.store)
    if lacking := tuple(file for file in task.files if file not in paths):
        return Missing(number=task.number, files=lacking, worker=worker_name())
    listener = _listeners.get(settings.pool)

    def progress(simulated: float, stop: float) -> None:
        if listener is not None:
            listener(task.number, simulated, stop)

    started = perf_counter()
    lost: LostWorker | MachineFailure | None = None
    arguments = (*task.arguments, paths) if task.files else task.arguments
    for attempt in range(1, TRIES + 1):
        about: dict[str, Any] = {"number": task.number, "attempts": attempt, "worker": worker_name()}
        worker = _worker(settings.pool)  # in each attempt: the pool may have ended meanwhile
        try:
            result = worker.run(task.function, arguments, settings.silence, progress)
        except LostWorker as error:
            lost = error
            continue
        except MachineFailure as error:
            lost = error
            worker.restart()
            continue
        except TemporaryFolderError as error:
            return TaskOutcome(error=DiskFull(str(error)), **about)
        except (InputError, RunError) as error:
            about |= {"wall_time": perf_counter() - started, "ended": time()}
            return TaskOutcome(failure="error", cause=_line(error), error=error, **about)
        return TaskOutcome(result=result, wall_time=perf_counter() - started, ended=time(), **about)
    assert lost is not None
    if isinstance(lost, MachineFailure):
        cause = f"{task.title}: {lost}, twice, on {socket.gethostname()}; mend that and give the same command again"
        return TaskOutcome(error=NoResult(cause), **about)
    about |= {"wall_time": perf_counter() - started, "ended": time()}
    return TaskOutcome(failure=lost.kind, cause=lost.cause, **about)


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())


def _worker(pool: str) -> WorkerProcess:
    key = pool, threading.get_ident()
    with _lock:
        if pool in _ended:
            raise KeyboardInterrupt
        return _workers.setdefault(key, WorkerProcess())


def worker_name() -> str:
    """Return a name for this thread: machine, process, thread."""
    return f"{socket.gethostname()}-{os.getpid()}-{threading.get_ident() % 100_000}"


def listen(pool: str, listener: Callable[[int, float, float], None]) -> None:
    """Have progress of a pool's tasks reported: number of the task, simulated and final time [s]."""
    _listeners[pool] = listener


def end_workers(pool: str) -> None:
    """End the worker processes of a pool in this process; tasks under way raise KeyboardInterrupt."""
    with _lock:
        _ended.add(pool)
        chosen = [worker for (name, _), worker in _workers.items() if name == pool]
    for worker in chosen:
        worker.end()


def forget_workers(pool: str) -> None:
    """Wait for the end of the worker processes of a pool in this process, once no task is under way."""
    _listeners.pop(pool, None)
    with _lock:
        chosen = [_workers.pop(key) for key in list(_workers) if key[0] == pool]
    for worker in chosen:
        worker.close()
