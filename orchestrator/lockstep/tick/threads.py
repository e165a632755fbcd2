"""Steps of FMUs in threads of the tick in C: the jobs of a program, and their messages and failures.

A job is one component's step, which is begun, and finished before its results are used: `c/threads.h`. What an FMU logs
during its step is kept until that is finished, and reported then, in the order of the schedule.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import CDLL, Structure, addressof, c_double, c_int32, c_int64, c_uint32, c_void_p, sizeof
from threading import get_native_id
from time import monotonic
from typing import Any

from lockstep.fmi.native_call import Apart
from lockstep.fmi.slave import FATAL, WARNING
from lockstep.operating_system import available_cores, pin
from lockstep.tick.operations import Judge

PATIENCE = 0.05  # [s] that a wait in C lasts: signals are handled after it
_UNDER_WAY = (1, 2)  # JOB_WAITING and JOB_RUNNING


class StepJob(Structure):
    """step_job."""

    _fields_ = [
        ("call", c_void_p),
        ("what", c_void_p),
        ("time", c_double),
        ("busy", c_double),
        ("measured", c_int64),
        ("begun", c_int64),
        ("apart", c_int32),
        ("status", c_uint32),
        ("state", c_int32),
        ("logged", c_int32),
        ("next", c_int64),
    ]


_SIZE = sizeof(StepJob)
_abandoned: list[object] = []  # jobs of which one still lasts


class Jobs:
    """The jobs of a program, and the threads for them once those are started."""

    def __init__(
        self, library: CDLL, names: Sequence[str], steps: Mapping[str, tuple[Apart, Judge]], used: object = None
    ) -> None:
        """Prepare the jobs of components, none of which threads make yet; `steps` judges their steps.

        `used` is kept alive: memory that their steps use.
        """
        self._used = used
        self.names = tuple(names)
        self.structures: Any = (StepJob * max(1, len(self.names)))()
        self.pool: int | None = None  # where the structure of the threads lies in memory
        self._library = library
        self._steps = [steps[name] for name in self.names]
        for job, (apart, _) in zip(self.structures, self._steps, strict=False):
            apart.messages.keep = _keeping(job)

    @property
    def address(self) -> int:
        """Where the jobs lie in memory."""
        return addressof(self.structures)

    def start(self, threads: int, cores: Iterable[int]) -> bool:
        """Have so many threads step components, this one included, on these cores; return whether it can be had."""
        if self.pool is None and threads > 1:
            with _on_cores(set(cores)):
                self.pool = self._library.pool_open(self.address, threads - 1)
        return self.pool is not None

    def choose(self, numbers: frozenset[int]) -> None:
        """Have threads make the steps of these jobs that begin from now on."""
        for number in range(len(self.names)):
            self.structures[number].apart = number in numbers

    def means(self) -> list[float]:
        """Return what a step of each job took on average [s] since the last call; 0 where none was measured."""
        found = []
        for job in self.structures:
            found.append(job.busy / job.measured if job.measured else 0.0)
            if job.state not in _UNDER_WAY:
                job.busy, job.measured = 0.0, 0
        return found

    def complete(self, number: int) -> None:
        """Wait for the end of a step."""
        job = self.address + number * _SIZE
        while not self._library.job_finish(self.pool, job, PATIENCE):
            pass  # Python handles signals here

    def failed(self, number: int) -> bool:
        """Return whether a step that is complete failed, or asked for the end."""
        return bool(self.structures[number].status > WARNING)

    def finish(self, number: int, time: float) -> None:
        """Report what a step that is complete logged, and judge its status."""
        job, (apart, judge) = self.structures[number], self._steps[number]
        status, job.status, job.logged = job.status, 0, 0
        apart.messages.report_kept()
        if status:
            judge(time, status)

    def settle(self, patience: float = math.inf) -> None:
        """Wait for all steps under way, so many seconds at most; note their failures, which nothing else reports.

        An FMU whose step still lasts then is not called any more; the step goes on in its thread.
        """
        due = monotonic() + patience
        for number, (apart, _) in enumerate(self._steps):
            job = self.structures[number]
            while not self._library.job_finish(self.pool, self.address + number * _SIZE, PATIENCE):
                if monotonic() > due:
                    apart.failed(FATAL)
                    _abandoned.append(self)  # what the thread still uses
                    break
            if job.status and job.state not in _UNDER_WAY:
                apart.failed(job.status)

    def close(self) -> None:
        """End the threads."""
        pool, self.pool = self.pool, None
        if pool is not None and self not in _abandoned:
            self._library.pool_close(pool)


def _keeping(job: Any) -> Callable[[], bool]:
    """Return what says whether a message is kept: while a thread makes the step, which notes that there is one."""

    def keeping() -> bool:
        if job.state not in _UNDER_WAY:
            return False
        job.logged = 1
        return True

    return keeping


@contextmanager
def _on_cores(cores: set[int]) -> Iterator[None]:
    """Let this thread use these cores meanwhile: threads that it starts inherit them."""
    before, thread = available_cores(), get_native_id()
    pin(thread, cores)
    try:
        yield
    finally:
        pin(thread, before)
