"""Start steps and complete them later, so that FMUs in processes of their own work side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, runtime_checkable

from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import Task

Action = Callable[[float], None]


@runtime_checkable
class Overlapping(Protocol):
    """A slave whose do_step only starts a step."""

    overlaps: bool

    def complete(self) -> None:
        """Wait for the end of the step."""
        ...


class StartedStep:
    """A step in two parts: a call starts it; `finish` completes it and fetches the outputs."""

    def __init__(self, begin: Action, complete: Callable[[], None], fetch: Iterable[Action]) -> None:
        self._begin, self._complete, self._fetch = begin, complete, tuple(fetch)

    def __call__(self, time: float) -> None:
        """Start the step."""
        self._begin(time)

    def finish(self, time: float) -> None:
        """Complete the step and fetch the outputs."""
        self._complete()
        for call in self._fetch:
            call(time)


def interleaved(layout: Layout, tick: int, steps: Iterable[tuple[Task, Action]]) -> Iterator[Action]:
    """Yield the actions of one tick; each step is finished before another component reads its new outputs."""
    open_: dict[str, StartedStep] = {}
    for task, step in steps:
        if open_:
            for link, version in layout.renewed(task, tick):
                if link.producer in open_ and version >= layout.schedule.task(link.producer).begun(tick):
                    yield open_.pop(link.producer).finish
        yield step
        if isinstance(step, StartedStep):
            open_[task.name] = step
    for step in open_.values():
        yield step.finish
