"""Turn Ctrl-C into a request that the master checks between ticks.

An exception raised in the middle of a call into an FMU would be caught there: a slave written in Python runs
in this interpreter, and treats it as its own failure.
"""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import NoReturn

_SAME = 1.0  # [s] within which two signals are one Ctrl-C


class Interrupt:
    """Whether Ctrl-C was pressed."""

    requested = False
    ending = False  # whether the run is being closed for it

    def check(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C was pressed."""
        if self.requested:
            raise self.end()

    def end(self) -> KeyboardInterrupt:
        """Return the exception that ends the run; from here on its files are closed undisturbed."""
        self.ending = True
        return KeyboardInterrupt()


@contextmanager
def deferred_interrupt() -> Iterator[Interrupt]:
    """Defer Ctrl-C inside the block; a second one acts at once, unless the run is being closed for the first.

    Do nothing outside the main thread, or where Ctrl-C is ignored or handled by the caller.

    A terminal signals a whole process group, and a parent may pass the signal on: within a second that is one Ctrl-C.
    """
    interrupt = Interrupt()
    first = 0.0
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is not signal.default_int_handler:
        yield interrupt
        return

    def request(number: int, frame: FrameType | None) -> None:
        nonlocal first
        if not interrupt.requested:
            interrupt.requested, first = True, monotonic()
        elif monotonic() - first > _SAME and not interrupt.ending:
            signal.default_int_handler(number, frame)

    signal.signal(signal.SIGINT, request)
    try:
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, before)


def end_program(code: int) -> NoReturn:
    """Exit with this code, and ignore Ctrl-C while the interpreter ends: there is nothing left to interrupt."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(code)
