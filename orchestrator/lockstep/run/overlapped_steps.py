"""Steps that begin and are completed later, so that FMUs in processes of their own work side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, runtime_checkable

from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import Task

Step = Callable[[float], None]


@runtime_checkable
class Overlapping(Protocol):
    """A slave whose do_step only begins a step."""

    overlaps: bool

    def complete(self) -> None:
        """Wait for the end of the step."""
        ...


class BegunStep:
    """A step in two parts: called, it begins; `finish` completes it and fetches the outputs."""

    def __init__(self, begin: Step, complete: Callable[[], None], fetch: Iterable[Step]) -> None:
        self._begin, self._complete, self._fetch = begin, complete, tuple(fetch)

    def __call__(self, time: float) -> None:
        """Begin the step."""
        self._begin(time)

    def finish(self, time: float) -> None:
        """Complete it."""
        self._complete()
        for call in self._fetch:
            call(time)


def interleaved(layout: Layout, tick: int, steps: Iterable[tuple[Task, Step]]) -> Iterator[Step]:
    """Yield the steps of one tick, each finished before somebody reads of it what it makes in this tick."""
    open_: dict[str, BegunStep] = {}
    for task, step in steps:
        if open_:
            for link, version in layout.renewed(task, tick):
                if link.producer in open_ and version >= layout.schedule.task(link.producer).begun(tick):
                    yield open_.pop(link.producer).finish
        yield step
        if isinstance(step, BegunStep):
            open_[task.name] = step
    for step in open_.values():
        yield step.finish
