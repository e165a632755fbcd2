"""Call a function in a child process, which it may take down."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from lockstep.errors import InputError, RunError
from lockstep.operating_system import has_fork
from lockstep.processes.child_process import ending


def call_in_child(call: Callable[[], object]) -> object:
    """Return what a call returns in a child process, or a text that says how it failed.

    The child is a copy of this process where the system can copy one, which then must have one thread; elsewhere it is
    a new one, and the call must be of what pickle can name.
    """
    context: Any = multiprocessing.get_context("fork" if has_fork() else "spawn")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_answer, args=(call, sender))
    child.start()
    sender.close()
    try:
        return receiver.recv()
    except EOFError:
        child.join()
        return f"the FMU {ending(child.exitcode or 0)}"
    finally:
        receiver.close()
        child.join()


def _answer(call: Callable[[], object], sender: Connection) -> None:
    result: object
    process = os.getpid()
    try:
        result = call()
    except (InputError, RunError) as error:
        result = str(error)
    except BaseException as error:
        result = f"{type(error).__name__}: {error}"
    if os.getpid() != process:
        os._exit(0)  # a copy that the FMU made of this process returned too
    sender.send(result)
    sender.close()
