"""Show the progress of a run: a bar on a terminal, plain lines elsewhere; and its summary at the end."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import TextIO

from rich.console import Console

from lockstep.cli.outcome import keep, remark, show_table
from lockstep.cli.progress_bars import Bars
from lockstep.run.loop_time import TABLE_HEADER
from lockstep.run.real_time_pacing import Pacer
from lockstep.simulation import Progress as Report
from lockstep.simulation import RunSummary
from lockstep.standard_streams import LINE_INTERVAL, unfiltered

_STATE, _PACE = len("86400.0 of 86400 s"), len(", 1000.0 x real time")


@contextmanager
def show_progress(
    title: str, stream: TextIO | None = None, begin: float = 0.0, pacer: Pacer | None = None
) -> Iterator[Report]:
    """Yield what `simulate` takes as `progress`; it writes to standard error, or to `stream`.

    `begin` is the simulated time [s] at which the run begins. A pacer reports its overruns.
    """
    stream = stream or sys.stderr
    console = Console(file=unfiltered(stream))
    if not console.is_terminal:
        yield _Lines(title, stream, begin, pacer)
        return
    started = perf_counter()
    bars = Bars(console, [title], _STATE, _PACE if pacer is None else len(str(pacer)) + 2)
    with bars.progress as bar:
        task = bar.add_task(bars.description(title), total=None, state="starting")

        def report(simulated: float, stop: float) -> None:
            speed = (simulated - begin) / max(perf_counter() - started, 1e-9)
            pace = f", {speed:.1f} x real time" if pacer is None else f", {pacer}"
            state = f"{simulated:.1f} of {stop:.6g} s{pace if bars.full else ''}"
            bar.update(task, completed=simulated, total=stop, state=state)

        yield report


class _Lines:
    """One line now and then, and one at the end."""

    def __init__(self, title: str, stream: TextIO, begin: float, pacer: Pacer | None) -> None:
        self._title, self._stream, self._begin, self._pacer = title, stream, begin, pacer
        self._started = perf_counter()
        self._next = self._started + LINE_INTERVAL

    def __call__(self, simulated: float, stop: float) -> None:
        now = perf_counter()
        if now < self._next and simulated < stop:
            return
        self._next = now + LINE_INTERVAL
        elapsed = max(now - self._started, 1e-9)
        speed = (simulated - self._begin) / elapsed
        left = (stop - simulated) / speed if speed else 0.0
        pace = f"{speed:.1f} x real time" if self._pacer is None else str(self._pacer)
        text = f"{self._title}: {simulated:.6g} of {stop:.6g} s, {pace}, {left:.0f} s left"
        print(text, file=self._stream, flush=True)


def in_bytes(size: int) -> str:
    """Return a size with its unit, 12.3 MB for example."""
    value, unit = float(size), "bytes"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 1000.0:
            break
        value, unit = value / 1000.0, larger
    return f"{size} bytes" if size < 1000 else f"{value:.1f} {unit}"


def print_summary(summary: RunSummary, *, profile: bool = False) -> None:
    """Print simulated time, speed and results folder of a run; as a profile, a table of where the wall time went."""
    simulated = summary.simulated_time - summary.start_time
    speed = simulated / max(summary.wall_time, 1e-9)
    begun = f", from {summary.start_time:g} s on" if summary.start_time else ""
    took = f"{simulated:g} s simulated{begun} in {summary.wall_time:.1f} s ({speed:.1f} x real time)"
    recorded = f", {summary.rows} rows in {in_bytes(summary.size)}" if summary.rows and summary.folder else ""
    remark(f"{took}{recorded}: {summary.folder}")
    if summary.folder:
        keep(summary.folder)
    if summary.loop_time is not None:
        if profile:
            show_table(TABLE_HEADER, summary.loop_time.table())
        elif line := summary.loop_time.line():
            remark(line)
    if summary.terminated:
        remark(f"ended before the stop time: {summary.terminated}")
    if summary.pacer is not None:
        print(summary.pacer)
        print("\n".join(summary.pacer.histogram()))


def print_warnings(warnings: Sequence[str], most: int = 10) -> None:
    """Print what was amended in a system file to stderr, the first lines of it; run.toml has all."""
    for text in warnings[:most]:
        print(f"warning: {text}", file=sys.stderr)
    if len(warnings) > most:
        print(f"warning: {len(warnings) - most} more, which run.toml lists", file=sys.stderr)
