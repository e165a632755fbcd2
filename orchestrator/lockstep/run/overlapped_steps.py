"""Start steps and complete them later, so that FMUs in processes of their own work side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Protocol, runtime_checkable

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
    """A step in two parts: a call starts it; `finish` completes it and fetches the outputs.

    Or several steps, which take their inputs after they have begun: `reads` are the components that those are of.
    """

    def __init__(
        self,
        begin: Action,
        complete: Callable[[], None],
        fetch: Iterable[Action],
        *,
        reads: frozenset[str] = frozenset(),
    ) -> None:
        self._begin, self._complete, self._fetch = begin, complete, tuple(fetch)
        self.reads = reads

    def __call__(self, time: float) -> None:
        """Start the step."""
        self._begin(time)

    def finish(self, time: float) -> None:
        """Complete the step and fetch the outputs."""
        self._complete()
        for call in self._fetch:
            call(time)


def interleaved(layout: Layout, tick: int, steps: Iterable[tuple[Sequence[Task], Action]]) -> Iterator[Action]:
    """Yield the actions of one tick, each of one component's step or of several.

    A step is finished before another component reads its new outputs, or replaces outputs that it still has to read.
    """
    open_: dict[str, StartedStep] = {}
    for tasks, step in steps:
        if open_:
            names = {task.name for task in tasks}
            ending = [open_[name] for name in _read(layout, tick, tasks) if name in open_]
            ending += [other for other in open_.values() if other.reads & names]
            for other in dict.fromkeys(ending):
                open_ = {name: each for name, each in open_.items() if each is not other}
                yield other.finish
        yield step
        if isinstance(step, StartedStep):
            open_ |= {task.name: step for task in tasks}
    for other in dict.fromkeys(open_.values()):
        yield other.finish


def _read(layout: Layout, tick: int, tasks: Iterable[Task]) -> Iterator[str]:
    """Yield the components whose outputs of this tick are read."""
    for task in tasks:
        for link, version in layout.renewed(task, tick):
            if version >= layout.schedule.task(link.producer).begun(tick):
                yield link.producer


def alone(steps: Iterable[tuple[Task, Any]]) -> Iterator[tuple[tuple[Task, ...], Action]]:
    """Yield steps, none of which is joined with others."""
    for task, step in steps:
        yield (task,), step
