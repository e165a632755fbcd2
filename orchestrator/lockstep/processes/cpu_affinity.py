"""Choose the cores that isolated FMUs run on: the master's own core while no other program needs it.

Master and worker take turns. On two cores each turn wakes one that has gone to sleep, which takes 25 to 100 us on the
machines measured; on one core it is a change of process, 3 us, and the values are in its cache. So the workers that the
master only waits for are pinned to its core.

The master stays there only in a program of this project, within `own_thread`: a thread that calls `simulate` in another
program may do other work, and what it starts inherits its cores. Such a thread is not restricted; where it has moved,
its workers follow at the next judgement, at a cost of up to 10 us a step.

The kernel places the other workers, which may use all cores: a worker during whose step the master or another worker
does more than waking a core takes, and one whose steps are so long that waking does not count. Where the kernel reports
that other programs ran on the core while the master or a worker waited for it, all are released for a pause, which
doubles while the core stays crowded. Where the kernel reports nothing, all are released for good. Threads that start
after the first interval stay on the core of the process that starts them.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from time import monotonic, thread_time

from lockstep.operating_system import available_cores, current_core, pin, thread_times
from lockstep.processes.last_call import BUSY, LastCall
from lockstep.processes.worker_link import WorkerLink

_INTERVAL = 0.05  # [s] between two judgements
_LONGEST_PAUSE = 1.6  # [s] for which all are released
_WAKING = 1e-4  # [s] that a core takes to wake up, generously
_LONG = 1e-3  # [s] of a step for which that does not count
SAMPLE = 7  # of so many messages one is timed: the clock for that is slow
_ENOUGH = 4 * SAMPLE  # messages to judge a worker by
_CROWDED = 0.25  # share of an interval for which others may use the core

_local = threading.local()

Times = tuple[float, float]


@dataclass(slots=True, eq=False)
class WorkerLoad:
    """One worker's process, and what it did since the last judgement."""

    pid: int
    last_call: LastCall
    link: WorkerLink
    pinned: bool = False  # to the master's core
    busy: float = 0.0  # [s] of its work up to then


class CoreAssignment:
    """The core of one thread that steps FMUs, and of its workers."""

    def __init__(self) -> None:
        self._thread = threading.get_native_id()
        self._all = available_cores()  # as the user started the master
        self._core: int | None = None  # that workers are pinned to, and the thread, if it may be
        self._pins_thread = False
        self._workers: list[WorkerLoad] = []
        self.timed: set[WorkerLoad] = set()  # while they have something to do
        self._times: dict[int, Times] = {}  # at the last judgement, by thread
        self._last = self._next = self._settled = 0.0  # [s]
        self._pause = _INTERVAL

    @property
    def cores(self) -> set[int]:
        """All cores that the program may run on: those of threads that are not stepping FMUs."""
        return set(self._all)

    def leave_thread(self) -> None:
        """Leave the thread alone from here on: it is given a core, to which its workers follow it."""
        self.give_back()
        self._pins_thread = False

    def give_back(self) -> None:
        """Release the thread and its workers to all cores. A process started now may run anywhere."""
        if self._core is not None:
            self._core = None
            if self._pins_thread:
                pin(self._thread, self._all)
            for worker in self._workers:
                self._place(worker, pinned=False)

    def add(self, pid: int, last_call: LastCall, link: WorkerLink) -> WorkerLoad:
        """Add a worker that was just started."""
        if not self._workers:
            self._all = available_cores()
            self._pause = _INTERVAL
            self._pins_thread = getattr(_local, "own", False)
        worker = WorkerLoad(pid, last_call, link)
        self._workers.append(worker)
        self._next = monotonic() + _INTERVAL if len(self._all) > 1 else math.inf
        return worker

    def remove(self, worker: WorkerLoad) -> None:
        """Remove a worker that ends. After the last one the master may use all its cores again."""
        self.timed.discard(worker)
        self._workers.remove(worker)
        if not self._workers:
            self.give_back()

    def message_sent(self, worker: WorkerLoad, now: float) -> None:
        """Note a message to a worker at this time [s]; needed for one in SAMPLE, and while others are timed."""
        for other in self.timed:
            other.link.overlap += SAMPLE * worker.link.step
        if worker.link.messages % SAMPLE == 0:
            self.timed.add(worker)
            worker.link.since = (
                thread_time()
            )  # the wall clock would count the worker's own work, where that comes first
            self.look(now)

    def waits(self, worker: WorkerLoad) -> None:
        """Note that the master has nothing left to do but wait for a worker that is timed."""
        self.timed.discard(worker)
        worker.link.overlap += SAMPLE * (thread_time() - worker.link.since)

    def look(self, now: float) -> None:
        """Choose the core, or judge each worker again, or release the core; where that is due."""
        if now <= self._next:
            return
        elapsed, self._last, self._next = now - self._last, now, now + _INTERVAL
        before, self._times = self._times, self._read_times()
        if not self._times:
            self.give_back()
            self._next = math.inf
        elif self._core is None:
            if any(worker.link.messages >= _ENOUGH for worker in self._workers):
                self._core, self._settled = current_core(), now
                if self._pins_thread:
                    pin(self._thread, {self._core})
                self._judge()
        elif self._crowded(before, elapsed):
            self.give_back()
            again = now - self._settled < 2.0 * self._pause
            self._pause = min(2.0 * self._pause, _LONGEST_PAUSE) if again else _INTERVAL
            self._next = now + self._pause
        else:
            self._follow()
            self._judge()

    def _follow(self) -> None:
        """Pin the workers of this core to the one that the thread has moved to, if it may move."""
        core = self._core if self._pins_thread else current_core()
        if core is not None and core != self._core:
            self._core = core
            for worker in self._workers:
                if worker.pinned:
                    pin(worker.pid, {core})

    def _crowded(self, before: dict[int, Times], elapsed: float) -> bool:
        """Return whether other programs used the core while the master or a pinned worker wanted it.

        Those also wait for each other, but not for longer than they run: the rest of the waiting is due to others.
        """
        here = [self._thread, *(worker.pid for worker in self._workers if worker.pinned)]
        ran, waited = (
            sum(self._times[one][k] - before[one][k] for one in here if one in before and one in self._times)
            for k in range(2)
        )
        return min(waited, elapsed - ran) > _CROWDED * elapsed

    def _read_times(self) -> dict[int, Times]:
        """Return how long each thread ran and waited for a core [s]; nothing where the kernel does not report it."""
        with suppress(OSError, ValueError, IndexError):
            return {one: thread_times(one) for one in (self._thread, *(worker.pid for worker in self._workers))}
        return {}

    def _judge(self) -> None:
        """Pin workers the master blocks on to its core; release the rest."""
        for worker in self._workers:
            if worker.link.messages >= _ENOUGH:
                busy = worker.last_call.reals[BUSY]
                link = worker.link
                link.step = (busy - worker.busy) / link.messages
                saved = min(link.step, link.overlap / link.messages)
                self._place(worker, pinned=saved < _WAKING and link.step < _LONG)
                worker.busy, link.messages, link.overlap = busy, 0, 0.0

    def _place(self, worker: WorkerLoad, *, pinned: bool) -> None:
        """Pin a worker to the master's core, or release it."""
        if pinned != worker.pinned:
            worker.pinned = pinned
            pin(worker.pid, {self._core} if pinned and self._core is not None else self._all)


def core_assignment() -> CoreAssignment:
    """Return the assignment of the calling thread."""
    if not hasattr(_local, "assignment"):
        _local.assignment = CoreAssignment()
    found: CoreAssignment = _local.assignment
    return found


@contextmanager
def own_thread() -> Iterator[None]:
    """Let the calling thread be pinned too while it steps isolated FMUs: one that does nothing else meanwhile."""
    before = getattr(_local, "own", False)
    _local.own = True
    try:
        yield
    finally:
        _local.own = before
