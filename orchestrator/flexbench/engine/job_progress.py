"""Show the progress of a study's runs: a bar for each under way on a terminal, and a line for each that has ended.

What draws bars is imported where they are drawn: worker processes import this module and draw none.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING

from lockstep.standard_streams import printable, unfiltered

if TYPE_CHECKING:
    from rich.progress import TaskID

    from lockstep.cli.progress_bars import Bars

_STATE, _SPEED = len("300 of 300 s"), len(", 1000.0 x real time")


class ShownJobs:
    """Count the runs of a study, and print a line for each that has ended."""

    def __init__(self, titles: Sequence[str], bars: Bars | None = None) -> None:
        self._bars = bars
        self._runs = len(titles)
        self._ended: set[str] = set()
        self._shares: dict[str, float] = {}  # of the time to simulate
        self._tasks: dict[str, TaskID] = {}
        self._started: dict[str, float] = {}
        if bars is not None:
            self._whole = bars.progress.add_task(self._count, total=float(self._runs), state="")

    @property
    def _count(self) -> str:
        return f"{len(self._ended)} of {self._runs} runs"

    def __call__(self, title: str, simulated: float, stop: float) -> None:
        """Show how far a run is."""
        if title in self._ended:
            return
        self._shares[title] = simulated / stop if stop else 1.0
        if simulated >= stop:
            self.end(title, f"{simulated:g} s simulated")
        elif self._bars is not None:
            if title not in self._tasks:
                self._started[title] = perf_counter()
                description = self._bars.description(title)
                self._tasks[title] = self._bars.progress.add_task(description, total=stop, state="")
            speed = simulated / max(perf_counter() - self._started[title], 1e-3)
            state = f"{simulated:.0f} of {stop:.0f} s" + (f", {speed:.1f} x real time" if self._bars.full else "")
            self._bars.progress.update(self._tasks[title], completed=simulated, total=stop, state=state)
            self._show_whole()

    def end(self, title: str, how: str) -> None:
        """Print that a run has ended, unless that was printed."""
        if title in self._ended:
            return
        self._ended.add(title)
        self._shares[title] = 1.0
        line = f"{title}: {how} ({len(self._ended)} of {self._runs})"
        if self._bars is None:
            print(line, file=sys.stderr, flush=True)
            return
        if title in self._tasks:
            self._bars.progress.remove_task(self._tasks.pop(title))
        self._show_whole()
        self._bars.progress.console.print(printable(line), markup=False, highlight=False, soft_wrap=True)

    def _show_whole(self) -> None:
        if self._bars is not None:
            done = sum(self._shares.values())
            self._bars.progress.update(self._whole, description=self._count, completed=done)


@contextmanager
def show_jobs(titles: Sequence[str]) -> Iterator[ShownJobs]:
    """Yield what shows progress: a bar for each run under way on a terminal, and a line for each that has ended."""
    from rich.console import Console

    console = Console(file=unfiltered(sys.stderr))
    if not console.is_terminal:
        yield ShownJobs(titles)
        return
    from lockstep.cli.progress_bars import Bars

    bars = Bars(console, titles, _STATE, _SPEED)
    with bars.progress:
        yield ShownJobs(titles, bars)
