"""Which core isolated FMUs run on: the master's own, while nobody else wants it.

Master and worker take turns. On two cores each turn wakes one that has gone to sleep, which takes 25 to 100 us on the
machines we have seen; on one core it is a change of process, 3 us, and the values are in its cache. So the master keeps
to the core that it is on, and keeps with it the workers for which it only waits.

The kernel places the others, which have all cores: a worker beside whose step more is done than waking a core takes,
and one whose steps are so long that waking does not count. Where the kernel tells that others had the core while we
waited for it, it places all of us for a time, which doubles while it goes on like that; and always if it does not tell.
Threads that start after the first interval keep to the core of the process that starts them.
"""

from __future__ import annotations

import ctypes
import math
import os
import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import monotonic, thread_time

from lockstep.processes.shared_memory import BUSY, Shared

_INTERVAL = 0.05  # [s] between two looks at who runs where
_LONGEST_PAUSE = 1.6  # [s] that all are left to the kernel
_WAKING = 1e-4  # [s] that a core takes to wake up, generously
_LONG = 1e-3  # [s] of a step beside which that does not count
SAMPLE = 7  # messages, for one of which it is measured what goes on beside it: the clock for that is slow
_ENOUGH = 4 * SAMPLE  # messages to judge a worker by
_CROWDED = 0.25  # of an interval: for how much of it others may have the core that we want
_ASK, _ALIKE = 0xFFFFFFFF, 0x0040000  # linux/personality.h: ADDR_NO_RANDOMIZE
_local = threading.local()

Times = tuple[float, float]


@dataclass(slots=True, eq=False)
class Worker:
    """One worker's process, and what it did since it was judged last."""

    pid: int
    shared: Shared
    near: bool = False  # kept to the master's core
    step: float = 0.0  # [s] of work for a message, on average, before that
    messages: int = 0
    since: float = 0.0  # when one of them was sent, by the master's processor clock [s]
    beside: float = 0.0  # [s] of work of others while it had something to do
    busy: float = 0.0  # [s] of its work up to then


class Cores:
    """The cores of one thread that steps FMUs, and of their workers."""

    def __init__(self) -> None:
        self._thread = threading.get_native_id()
        self._all = os.sched_getaffinity(0)  # as the user started the master
        self._home: int | None = None  # the core that is kept to
        self._workers: list[Worker] = []
        self.watched: set[Worker] = set()  # while they have something to do
        self._times: dict[int, Times] = {}  # at the last look, by thread
        self._last = self._next = self._settled = 0.0  # [s]
        self._pause = _INTERVAL

    def scatter(self) -> None:
        """Leave all to the kernel. Who is started now may run anywhere."""
        if self._home is not None:
            self._home = None
            keep(self._thread, self._all)
            for worker in self._workers:
                self._place(worker, near=False)

    def join(self, pid: int, shared: Shared) -> Worker:
        """Take in a worker that was just started."""
        if not self._workers:
            self._all = os.sched_getaffinity(self._thread)
            self._pause = _INTERVAL
        worker = Worker(pid, shared)
        self._workers.append(worker)
        self._next = monotonic() + _INTERVAL if len(self._all) > 1 else math.inf
        return worker

    def leave(self, worker: Worker) -> None:
        """Let go of one that ends. After the last one the master has all its cores again."""
        self.watched.discard(worker)
        self._workers.remove(worker)
        if not self._workers:
            self.scatter()

    def begins(self, worker: Worker, now: float) -> None:
        """Note that it is sent something to do at this time [s]; needed for one message in SAMPLE, and beside those."""
        for other in self.watched:
            other.beside += SAMPLE * worker.step
        if worker.messages % SAMPLE == 0:
            self.watched.add(worker)
            worker.since = thread_time()  # the wall clock would count the worker's own work, where that comes first
            if now > self._next:
                self._look(now)

    def waits(self, worker: Worker) -> None:
        """Note that the master has nothing more to do but to wait for one that is watched."""
        self.watched.discard(worker)
        worker.beside += SAMPLE * (thread_time() - worker.since)

    def _look(self, now: float) -> None:
        """Keep to a core, or see who should be near, or give the core up."""
        elapsed, self._last, self._next = now - self._last, now, now + _INTERVAL
        before, self._times = self._times, self._read_times()
        if not self._times:
            self.scatter()
            self._next = math.inf
        elif self._home is None:
            if any(worker.messages >= _ENOUGH for worker in self._workers):
                self._home, self._settled = core(), now
                keep(self._thread, {self._home})
                self._judge()
        elif self._crowded(before, elapsed):
            self.scatter()
            again = now - self._settled < 2.0 * self._pause
            self._pause = min(2.0 * self._pause, _LONGEST_PAUSE) if again else _INTERVAL
            self._next = now + self._pause
        else:
            self._judge()

    def _crowded(self, before: dict[int, Times], elapsed: float) -> bool:
        """Tell whether others had the core while one of us wanted it.

        We also wait for each other, but not for longer than we run: what is left of the time is not ours.
        """
        here = [self._thread, *(worker.pid for worker in self._workers if worker.near)]
        ran, waited = (
            sum(self._times[one][k] - before[one][k] for one in here if one in before and one in self._times)
            for k in range(2)
        )
        return min(waited, elapsed - ran) > _CROWDED * elapsed

    def _read_times(self) -> dict[int, Times]:
        """Return how long each of us has run and waited for a core [s]; nothing where the kernel does not say."""
        with suppress(OSError, ValueError, IndexError):
            return {one: times(one) for one in (self._thread, *(worker.pid for worker in self._workers))}
        return {}

    def _judge(self) -> None:
        """Send the workers home that the master waits for, and the others away."""
        for worker in self._workers:
            if worker.messages >= _ENOUGH:
                busy = worker.shared.reals[BUSY]
                worker.step = (busy - worker.busy) / worker.messages
                saved = min(worker.step, worker.beside / worker.messages)
                self._place(worker, near=saved < _WAKING and worker.step < _LONG)
                worker.busy, worker.messages, worker.beside = busy, 0, 0.0

    def _place(self, worker: Worker, *, near: bool) -> None:
        """Keep a worker to the master's core, or let it go."""
        if near != worker.near:
            worker.near = near
            keep(worker.pid, {self._home} if near and self._home is not None else self._all)


def cores() -> Cores:
    """Return those of the calling thread."""
    if not hasattr(_local, "cores"):
        _local.cores = Cores()
    found: Cores = _local.cores
    return found


def core() -> int:
    """Return the core that the calling thread is on."""
    return int(_libc().sched_getcpu())


def keep(thread: int, to: Collection[int]) -> None:
    """Have a thread run on these cores only; one that is gone runs nowhere."""
    with suppress(OSError):
        os.sched_setaffinity(thread, to)


def times(thread: int) -> Times:
    """Return how long a thread has run, and waited for a core [s], or raise OSError."""
    ran, waited, _ = Path(f"/proc/{thread}/schedstat").read_text().split()
    return int(ran) / 1e9, int(waited) / 1e9


@contextmanager
def same_layout() -> Iterator[None]:
    """Have processes that are started in here lay out their memory alike, if the system lets us.

    What a core has learnt about the branches of Python in one worker then holds in the next. The layout is random as a
    defence against bad data; a worker runs foreign code anyhow.
    """
    before = _libc().personality(_ASK)
    if before != -1:
        _libc().personality(before | _ALIKE)
    try:
        yield
    finally:
        if before != -1:
            _libc().personality(before)


@cache
def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None)
