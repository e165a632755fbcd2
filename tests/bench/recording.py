"""What recording adds to a tick, from 10 to 1000 signals: `python tests/bench/recording.py [ROWS]`.

Each row gathers all signals from a bus whose values all change. Printed are microseconds a row, the least of three
rounds: without a row (the gather into one fixed place), with a bare copy (the gather into the next row of a block that
is never written), and with the recorder, which writes its blocks beside the loop; then what the recorder takes beyond
the bare copy. All that is processor time of the loop's thread, which what else the machine does disturbs less; `clock`
is the recorder's time on the clock, in which the loop also waits where its rows come faster than the disk takes them.
At 1 kHz, on the right, they do not. `close` is the end of the run on the clock: the rest of the conversion that was
not done beside it. Nothing passes or fails here.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, sleep, thread_time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from lockstep.fmi.model_description import Variable
from lockstep.results.recorder import Recorder
from lockstep.results.signal_patterns import Signal

SIGNALS = (10, 30, 100, 300, 1000)
BLOCK = 500  # rows: half a second of 1 kHz
PERIOD = 1e-3  # [s] between two rows of a paced run
PACED = 2000  # rows of it


class Bus:
    """Values that all change from row to row, by noise in their last digits, as sampled ones do."""

    def __init__(self, count: int) -> None:
        self.values = np.random.default_rng(1).standard_normal((257, count))
        self.index = np.arange(count)

    def rows(self, number: int, row: Callable[[float], np.ndarray], *, paced: bool = False) -> tuple[float, float]:
        """Gather so many rows; return what one takes [s] of the processor, without the waits of a paced run, and on
        the clock.
        """
        index, spent, worked, start = self.index, 0.0, thread_time(), perf_counter()
        takes = [values.take for values in self.values]
        for k in range(number):
            if paced:
                while (now := perf_counter()) < start + k * PERIOD:
                    sleep(max(0.0, start + k * PERIOD - now))
                worked = thread_time()
                takes[k % 257](index, None, row(k * PERIOD), "clip")
                spent += thread_time() - worked
            else:
                takes[k % 257](index, None, row(k * PERIOD), "clip")
        return (spent if paced else thread_time() - worked) / number, (perf_counter() - start) / number


def signals(count: int) -> list[Signal]:
    """Return so many Reals."""
    return [
        Signal(component="c", variable=Variable(name=f"x[{k + 1}]", reference=k, type="Real", causality="output",
                                                unit=None))
        for k in range(count)
    ]  # fmt: skip


class Copied:
    """A block of rows that is filled again and again and never written."""

    def __init__(self, count: int) -> None:
        self.block = np.zeros((BLOCK, count))
        self.rows, self.times, self.count = list(self.block), np.zeros(BLOCK), 0

    def row(self, time: float) -> np.ndarray:
        """Return the next row."""
        count = self.count % BLOCK
        self.count = count + 1
        self.times[count] = time
        return self.rows[count]


def recorded(bus: Bus, count: int, number: int, *, paced: bool) -> tuple[float, float, float, int]:
    """Return what a row takes with the recorder, twice, what its end takes a row [s], and the bytes on disk."""
    with tempfile.TemporaryDirectory(prefix="flexsat_bench_") as folder:
        recorder = Recorder(Path(folder), signals(count), BLOCK)
        row = recorder.row
        spent = bus.rows(number, lambda time: row(time)[0], paced=paced)
        started = perf_counter()
        recorder.close()
        return *spent, (perf_counter() - started) / number, recorder.size_on_disk()


def main(number: int) -> None:
    """Measure and print the table."""
    print(f"{'':8}{'full speed, us a row':^60}{'1 kHz, us a row':^30}{'bytes':>9}")
    heads = ("nothing", "copy", "recorder", "beyond", "clock", "close", "copy", "recorder", "beyond", "a value")
    print(f"{'signals':>8}" + "".join(f"{head:>10}" for head in heads))
    for count in SIGNALS:
        bus, one = Bus(count), np.zeros(count)
        rows = max(4 * BLOCK, min(number, 40_000_000 // count))
        nothing = min(bus.rows(rows, lambda _, one=one: one)[0] for _ in range(3))
        copied = min(bus.rows(rows, Copied(count).row)[0] for _ in range(3))
        full = [recorded(bus, count, rows, paced=False) for _ in range(3)]
        slow = min(bus.rows(PACED, Copied(count).row, paced=True)[0] for _ in range(3))
        paced = min(recorded(bus, count, PACED, paced=True)[0] for _ in range(3))
        best, clock, close = (min(values) for values in list(zip(*full, strict=True))[:3])
        times = (nothing, copied, best, best - copied, clock, close, slow, paced, paced - slow)
        print(f"{count:8}" + "".join(f"{1e6 * value:10.2f}" for value in times)
              + f"{full[0][3] / rows / (count + 1):10.2f}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40_000)
