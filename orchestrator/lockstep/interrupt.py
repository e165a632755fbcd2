"""Turn Ctrl-C, SIGTERM and SIGHUP into a request that the master checks between ticks.

An exception raised in the middle of a call into an FMU would be caught there: a slave written in Python runs
in this interpreter, and treats it as its own failure.
"""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from time import monotonic
from types import FrameType
from typing import NoReturn

_SAME = 1.0  # [s] within which two signals are one Ctrl-C
PATIENCE = 0.8  # [s] from Ctrl-C on for calls under way: they are ended before a second Ctrl-C counts
_OTHERS = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
ENDING = (signal.SIGINT, *_OTHERS)  # signals that end a run


class Stopped(KeyboardInterrupt):
    """A signal other than that of Ctrl-C ends the program."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number

    @property
    def name(self) -> str:
        """Name of the signal."""
        return signal.Signals(self.number).name


class Interrupt:
    """Whether the run is to end, and by which signal."""

    requested = False
    stepping = False  # whether a run that is stepped is in a step
    ending = False  # whether the run is being closed for it
    number: int = signal.SIGINT

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal asked for the end."""
        if self.requested:
            raise self.end()

    def end(self) -> KeyboardInterrupt:
        """Return the exception that ends the run; from here on its files are closed undisturbed."""
        self.ending = True
        return _exception(self.number)


@contextmanager
def deferred_interrupt() -> Iterator[Interrupt]:
    """Defer the signals inside the block; a second one acts at once, unless the run is being closed for the first.

    Do nothing outside the main thread, or for a signal that is ignored or handled by the caller.

    A terminal signals a whole process group, and a parent may pass the signal on: within a second that is one signal.
    """
    interrupt = Interrupt()
    first = 0.0

    def request(number: int, _frame: FrameType | None) -> None:
        nonlocal first
        if not interrupt.requested:
            interrupt.requested, interrupt.number, first = True, number, monotonic()
        elif monotonic() - first > _SAME and not interrupt.ending:
            raise _exception(number)

    with ExitStack() as stack:
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                before = signal.getsignal(number)
                if before in (signal.default_int_handler, _raise, _between_ticks) or (
                    before == signal.SIG_DFL and number in _OTHERS
                ):
                    signal.signal(number, request)
                    stack.callback(signal.signal, number, before)
        yield interrupt


_stepped: list[Interrupt] = []  # of the runs that are stepped from the main thread


def attend(interrupt: Interrupt) -> None:
    """Have Ctrl-C end a run that is stepped between two ticks; outside its steps it acts as without the run.

    Called again it does so anew, where another handler was installed meanwhile. It does nothing outside the main
    thread, or where the program handles or ignores Ctrl-C.
    """
    if threading.current_thread() is threading.main_thread():
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, _between_ticks)
        if interrupt not in _stepped:
            _stepped.append(interrupt)


def dismiss(interrupt: Interrupt) -> None:
    """Have Ctrl-C act as before the run."""
    if interrupt in _stepped:
        _stepped.remove(interrupt)
    here = threading.current_thread() is threading.main_thread()
    if here and not _stepped and signal.getsignal(signal.SIGINT) is _between_ticks:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _between_ticks(number: int, _frame: FrameType | None) -> None:
    inside = [interrupt for interrupt in _stepped if interrupt.stepping and not interrupt.requested]
    if not inside:
        raise _exception(number)
    for interrupt in inside:
        interrupt.requested, interrupt.number = True, number


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Have SIGTERM and SIGHUP raise Stopped inside the block, as Ctrl-C raises KeyboardInterrupt, unless ignored."""
    with ExitStack() as stack:
        if threading.current_thread() is threading.main_thread():
            for number in _OTHERS:
                if signal.getsignal(number) == signal.SIG_DFL:
                    signal.signal(number, _raise)
                    stack.callback(signal.signal, number, signal.SIG_DFL)
        yield


def exit_code(error: KeyboardInterrupt) -> int:
    """Return the exit code of a program that a signal ended: 130, 143 or 129."""
    return 128 + (error.number if isinstance(error, Stopped) else signal.SIGINT)


def end_program(code: int) -> NoReturn:
    """Exit with this code, and ignore signals while the interpreter ends: there is nothing left to interrupt."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)
    sys.exit(code)


def _raise(number: int, _frame: FrameType | None) -> NoReturn:
    raise _exception(number)


def _exception(number: int) -> KeyboardInterrupt:
    return KeyboardInterrupt() if number == signal.SIGINT else Stopped(number)
