"""Show the progress of a study's runs: a bar for each on a terminal, else a line for each that has finished."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from lockstep.standard_streams import printable, unfiltered

Show = Callable[[str, float, float], None]


@contextmanager
def show_jobs(titles: Sequence[str]) -> Iterator[Show]:
    """Yield a function that shows progress: a bar for each run on a terminal, else a line for each finished run."""
    console = Console(file=unfiltered(sys.stderr))
    if not console.is_terminal:
        ended: set[str] = set()

        def line(title: str, simulated: float, stop: float) -> None:
            if simulated >= stop and title not in ended:
                ended.add(title)
                print(
                    f"{title}: {simulated:g} s simulated ({len(ended)} of {len(titles)})", file=sys.stderr, flush=True
                )

        yield line
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} s{task.fields[speed]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bars:
        tasks = {title: bars.add_task(escape(printable(title)), total=1.0, start=False, speed="") for title in titles}
        started: dict[str, float] = {}

        def bar(title: str, simulated: float, stop: float) -> None:
            if title not in started:
                started[title] = perf_counter()
                bars.start_task(tasks[title])
            speed = simulated / max(perf_counter() - started[title], 1e-3)
            bars.update(tasks[title], completed=simulated, total=stop, speed=f", {speed:.1f} x real time")

        yield bar
