"""Run Python in a child of this process, and end what that started: `python -m lockstep.processes.guard REPORT -m ...`.

This process waits. Processes whose parents end become its children, whatever session and environment they have: so it
finds all of them when the child ends, also by a crash, when this process is terminated, or when the master is killed.
It writes a line to the descriptor REPORT when the child runs, with its number, and one when all have ended, with how
many the child left running. Then it ends as the child did.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from time import monotonic, sleep
from typing import NoReturn

import psutil

from lockstep.interrupt import ENDING
from lockstep.operating_system import (
    adopt_orphans,
    close_descriptors,
    copy_process,
    end_like,
    end_with_parent,
    kill,
    reap,
    wait_for_child,
)

END: int = getattr(signal, "SIGUSR1", signal.SIGTERM)  # to the guard: it is to end all
_LIMIT = 5.0  # [s] for all that are killed to be gone


def main(report: int, arguments: list[str]) -> NoReturn:
    """Run Python with the arguments in a child, and guard it."""
    guard_copy(report)
    # not runpy: a step of a worker that goes on in a copy of this memory takes 1.5 us more
    os.execv(sys.executable, [sys.executable, "-P", *arguments])


def guard_copy(report: int) -> None:
    """Copy this process, which becomes the guard of its copy; return in the copy alone."""
    child = 0

    def end_child(*_: object) -> None:
        if not child:
            os._exit(1)
        kill(child)

    signal.signal(END, end_child)
    end_with_parent(END)
    adopt_orphans()
    child = copy_process()
    if child:
        _guard(report, child)
    end_with_parent()
    signal.signal(END, signal.SIG_DFL)
    os.close(report)


def _guard(report: int, child: int) -> NoReturn:
    """Wait for the end of the child, end what it left, and end as it did."""
    for number in ENDING:  # the master decides
        signal.signal(number, lambda *_: None)
    close_descriptors(but=report)  # the pipes are to be closed when the child has ended
    os.write(report, b"%d\n" % child)
    code = wait_for_child(child)
    left = _end_all()
    with suppress(BrokenPipeError):
        os.write(report, b"%d\n" % left)
    end_like(code)


def _end_all() -> int:
    """End all children, and those that become children then; return how many there were at first."""
    count = -1
    deadline = monotonic() + _LIMIT
    while reap() and monotonic() < deadline:
        children = psutil.Process().children()
        if count < 0:
            count = len(children)
        for process in children:
            with suppress(psutil.Error):
                process.kill()
        sleep(0.002)
    return max(0, count)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
