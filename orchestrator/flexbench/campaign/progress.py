"""Show how far a campaign is: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import monotonic

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Column

from lockstep.standard_streams import unfiltered

_EVERY = 10.0  # s between two lines


class Counter:
    """Count finished runs, and estimate what is left."""

    def __init__(self, total: int, done: int, failed: int) -> None:
        self.total, self.done, self.failed = total, done, failed
        self.workers = 0
        self._began, self._before = monotonic(), done

    def add(self, failed: bool) -> None:
        """Count a run that has finished now."""
        self.done += 1
        self.failed += failed

    def skip(self, failed: Sequence[bool]) -> None:
        """Count runs that were finished before, whether each failed."""
        self.done += len(failed)
        self.failed += sum(failed)
        self._before += len(failed)

    @property
    def rate(self) -> float:
        """Runs in a second since this program started."""
        return (self.done - self._before) / max(monotonic() - self._began, 1e-3)

    @property
    def text(self) -> str:
        """The state in words."""
        parts = [f"{self.done} of {self.total} runs", f"{self.failed} failed"]
        if self.done > self._before and self.done < self.total:
            parts += [f"{self.rate:.3g} a second", f"{_duration((self.total - self.done) / self.rate)} left"]
        return ", ".join([*parts, f"{self.workers} at once"])


class Show:
    """Show a counter."""

    def __init__(self, counter: Counter, name: str, bars: Progress | None) -> None:
        self.counter, self._name, self._bars = counter, name, bars
        self._last = monotonic()
        self._task = None if bars is None else bars.add_task(name, total=counter.total, completed=counter.done, text="")

    def look(self, *, now: bool = False) -> None:
        """Show the state, on a terminal at each call, else if some time has passed."""
        if self._bars is not None and self._task is not None:
            self._bars.update(self._task, total=self.counter.total, completed=self.counter.done, text=self.counter.text)
        elif now or monotonic() - self._last > _EVERY:
            self._last = monotonic()
            print(f"{self._name}: {self.counter.text}", file=sys.stderr, flush=True)


@contextmanager
def shown(counter: Counter, name: str) -> Iterator[Show]:
    """Show a counter inside the block, and at its end, however that comes."""
    console = Console(file=unfiltered(sys.stderr))
    if not console.is_terminal:
        show = Show(counter, name, None)
        try:
            yield show
        finally:
            show.look(now=True)
        return
    name_column = TextColumn("{task.description}", table_column=Column(overflow="fold"))  # a long name is not cut
    with Progress(name_column, BarColumn(), TextColumn("{task.fields[text]}"), console=console) as bars:
        show = Show(counter, name, bars)
        yield show
        show.look()


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"
