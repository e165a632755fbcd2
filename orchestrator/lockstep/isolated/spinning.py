"""Wait for the other process without sleeping, while that pays.

A core that has gone to sleep takes 25 to 50 us to wake up, which is most of what a round trip through two pipes costs.
So who waits first looks at a word of the shared memory for a while, and only then sleeps in the read of its pipe. The
word is a hint and no more: messages come through the pipe, and what an FMU writes to the memory can only cost time.

Where somebody else wants the core, sleeping is cheap, as the core stays awake, and spinning is dear: a turn of the
other takes milliseconds. A spinner that was away from its core notices by the clock, and sleeps from then on, for a
time that doubles while it goes on like that; before it spins again it asks the kernel whether processes wait for
cores. The same if nothing came for so long that spinning was of no use. And nobody spins where there are fewer cores
than processes that have something to do.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from time import perf_counter

from lockstep.isolated.memory import MAY_SPIN, Shared

CORES = len(os.sched_getaffinity(0))
_LONGEST = 3e-3  # [s] of one spin: more than our own systems take between two steps of one component
_AWAY = 1e-4  # [s] between two looks: more than a look takes, less than a turn of somebody else
_FIRST_PAUSE, _LAST_PAUSE = 1e-2, 1.28  # [s] without spinning
_PRESSURE = Path("/proc/pressure/cpu")  # where Linux tells, if it does, for what share of time somebody waits
_CROWDED = 20.0  # [%] of the last ten seconds


class Spinner:
    """Waits for a count in the shared memory to grow: that of the field `place`."""

    def __init__(self, shared: Shared, place: int) -> None:
        self._words, self._place = shared.integers, place
        self._pause, self._until = _FIRST_PAUSE, 0.0
        self._resting = True  # until the next spin, which has to ask first

    def spin(self, count: int) -> None:
        """Return when the message of this number is in the pipe, or when it is better to sleep until it comes."""
        words, place = self._words, self._place
        start = look = perf_counter()
        if start < self._until:
            return
        if self._resting and words[place] < count:
            self._resting = crowded()
            if self._resting:
                self._rest(start)
                return
        while words[place] < count:
            os.sched_yield()
            before, look = look, perf_counter()
            if look - before > _AWAY or look - start > _LONGEST:
                self._rest(look)
                return

    def _rest(self, now: float) -> None:
        again = now - self._until < 2.0 * self._pause
        self._pause = min(2.0 * self._pause, _LAST_PAUSE) if again else _FIRST_PAUSE
        self._until, self._resting = now + self._pause, True


def crowded() -> bool:
    """Tell whether processes wait for cores; False where the kernel does not say."""
    with suppress(OSError, ValueError, IndexError):
        return float(_PRESSURE.read_text().split("avg10=", 1)[1].split()[0]) > _CROWDED
    return False


def share_cores(workers: Collection[Shared]) -> None:
    """Let idle workers spin if there is a core for each of them beside the master's."""
    for shared in workers:
        shared.integers[MAY_SPIN] = len(workers) < CORES
