"""Watch one worker's process for time and memory, and end it with everything it started."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event, Thread
from time import monotonic

import psutil

from lockstep.interrupt import PATIENCE, Interrupt
from lockstep.operating_system import physical_memory, same_memory_layout
from lockstep.processes.child_process import ChildProcess, ending, printed_lines
from lockstep.processes.running_time import RunningTime
from lockstep.processes.worker_link import WorkerLink

GIGABYTE = 2**30
_INTERVAL = 0.05  # [s] between two looks at time and memory
_MOST_PRINTED = 2**20  # bytes of what the FMU prints; then it is discarded
_GRACE = 5.0  # [s] for a process that is ending


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What one isolated FMU may use."""

    step: float = 60.0  # [s] of wall time for one call
    memory: int = min(8 * GIGABYTE, physical_memory() // 2)  # bytes: above the needs of an FMU
    reserved: int = 4  # times as much may be reserved without being used
    interrupt: Interrupt = field(default_factory=Interrupt)  # Ctrl-C, which ends a call that lasts


class WatchedProcess:
    """A worker's process. `busy_since` of the link is when the call under way began, 0 if none is."""

    def __init__(
        self,
        descriptors: tuple[int, ...],
        folder: Path,
        limits: Limits,
        call: Callable[[], int] = lambda: 0,
        link: WorkerLink | None = None,
    ) -> None:
        """Start the worker; `call` returns another number for each call of an FMU that a request leads to."""
        self._link = WorkerLink() if link is None else link
        self.limit = limits.step  # [s] for one call
        self.closing = False  # a worker that is stopped is not waited for any more
        self.cause = ""  # why it was ended, if it was
        self.interrupt = limits.interrupt
        self.interrupted = False  # whether it was ended for that
        self._limits, self._call = limits, call
        directory = folder / "directory"  # not the user's: an FMU may write to the working directory
        directory.mkdir(parents=True, exist_ok=True)
        with same_memory_layout():
            self._child = ChildProcess(
                ["-m", "lockstep.processes.worker", *map(str, descriptors)],
                printed=folder / "printed",
                temporary=folder / "tmp",
                directory=directory,
                descriptors=descriptors,
            )
        self._ended = Event()
        self._watch = Thread(target=self._look, name="watch", daemon=True)
        self._watch.start()

    @property
    def guard(self) -> int:
        """The number of the process that guards the worker."""
        return self._child.guard

    @property
    def pid(self) -> int:
        """The number of the worker's process; waits until it is there."""
        return self._child.pid

    def _look(self) -> None:
        limits, child = self._limits, self._child
        asked = 0.0  # when Ctrl-C was seen
        call, time = (0.0, 0.0, 0), RunningTime(self.limit)  # what is measured: when it began, its limit and number
        while not self._ended.wait(_INTERVAL):
            since = self._link.busy_since
            if child.code is not None:
                child.kill()  # what it started keeps the pipes open
                return
            if (now := (since, self.limit, self._call())) != call:
                call, time = now, RunningTime(self.limit)
            elif since:
                time.look(counts=self.closing or not child.stopped)
                if time.is_over:
                    self._end_for(f"no answer within {self.limit:g} s")
            if self.interrupt.requested:
                asked = asked or monotonic()
                if since and monotonic() - max(since, asked) > PATIENCE:
                    self.interrupted = True
                    self.interrupt.end()  # from here on a second Ctrl-C does not disturb the closing of files
                    self._end_for("interrupted")
            with suppress(psutil.Error, OSError):
                memory = child.process.memory_info()
                if memory.rss > limits.memory or memory.data > limits.reserved * limits.memory:
                    self._end_for(f"took more than {limits.memory / GIGABYTE:.3g} GB of memory")
                if child.printed.stat().st_size > _MOST_PRINTED:
                    os.truncate(child.printed, 0)

    def _end_for(self, cause: str) -> None:
        self.cause = self.cause or cause
        self._child.kill()

    def end(self, grace: float = _GRACE) -> None:
        """Wait so many seconds for its end, then end it and everything it started."""
        self._child.wait(grace)
        self._ended.set()
        self._child.kill()
        self._child.wait()
        self._watch.join()

    def how_it_ended(self) -> str:
        """Describe why a process stopped answering, with the last line that it printed."""
        code = self._child.wait(_GRACE)
        if self.cause:
            return self.cause
        if code is None:
            return "closed its connection to the master"
        lines = printed_lines(self._child.printed, 1)
        return f"{ending(code)} ({lines[0]})" if lines else ending(code)
