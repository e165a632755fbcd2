"""The process that carries out tasks, one after another, until its parent ends it or has none for it for long.

FMUs that crash or hang end or block this process and no other; `flexbench.engine.worker` watches it.
"""

from __future__ import annotations

import multiprocessing.connection
import os
import pickle
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import Any

from lockstep.errors import InputError, RunError
from lockstep.interrupt import ENDING
from lockstep.operating_system import accept_interrupts, end_with_parent

IDLE = 600.0  # s without a task, after which the process ends; a later task starts another one
_OFTEN = 0.2  # s between two reports of progress
_connection: multiprocessing.connection.Connection | None = None
_reported = 0.0


def report_progress(simulated: float, stop: float) -> None:
    """Report how far a run is [s]: to the parent in a worker process, else to nobody. It shows that nothing hangs."""
    global _reported
    if _connection is not None and (simulated >= stop or monotonic() - _reported > _OFTEN):
        _reported = monotonic()
        _connection.send_bytes(pickle.dumps(("progress", simulated, stop)))


def in_worker() -> bool:
    """Return whether this is a worker process."""
    return _connection is not None


def serve(connection: multiprocessing.connection.Connection) -> None:
    """Carry out the tasks that come through the connection."""
    global _connection
    sys.path[:] = pickle.loads(connection.recv_bytes())
    _connection = connection
    connection.send_bytes(pickle.dumps(("ready",)))
    with suppress(KeyboardInterrupt):  # one that waited while this process started is followed by the end of the file
        accept_interrupts(ENDING)
    with suppress(EOFError, ConnectionError, KeyboardInterrupt):
        while connection.poll(IDLE):
            connection.send_bytes(_answer(connection.recv_bytes()))


def _answer(message: bytes) -> bytes:
    """Carry out a task and return what came of it."""
    try:
        function, arguments = pickle.loads(message)
        if _connection is not None:
            _connection.send_bytes(pickle.dumps(("begun",)))  # what it needs is imported, which may take long
        return pickle.dumps(("done", call(function, arguments)))
    except (InputError, RunError) as error:
        return _raised(error)
    except KeyboardInterrupt as error:
        return _raised(error)
    except Exception as error:
        if cause := _cause(error):
            return pickle.dumps(("machine", cause))
        # a bug: its traceback would be lost with this process
        return pickle.dumps(("bug", f"{type(error).__name__}: {error}", traceback.format_exc()))


def _cause(error: Exception) -> str:
    """Return what the machine refused, such as one more open file; "" for an error of the program."""
    match error:
        case MemoryError():
            return "out of memory"
        case OSError():
            return f"{error.filename}: {error.strerror}" if error.filename else error.strerror or str(error)
        case RuntimeError() if "start new thread" in str(error):
            return "no more threads"
    return ""


def call(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Call a function of a task."""
    return function(*arguments)


def _raised(error: BaseException) -> bytes:
    try:
        message = pickle.dumps(("raised", error))
        pickle.loads(message)
    except Exception:
        message = pickle.dumps(("raised", RunError(str(error))))
    return message


def main() -> None:
    """Serve on the socket whose descriptor is the first argument."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_parent()
    if int(sys.argv[2]) != os.getppid():  # it was killed while this process started
        os._exit(1)
    os.dup2(2, 1)  # what FMUs print is none of the results that a study prints
    serve(multiprocessing.connection.Connection(int(sys.argv[1])))


if __name__ == "__main__":
    # under its real name, so that tasks that report progress find this connection
    from flexbench.engine import worker_process

    worker_process.main()
