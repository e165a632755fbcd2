"""Start steps and complete them later, so that FMUs in processes of their own work side by side."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Protocol, runtime_checkable

from lockstep.plan.bus_layout import Layout
from lockstep.plan.schedule import Task
from lockstep.tick.operations import Block, StartedStep


@runtime_checkable
class Overlapping(Protocol):
    """A slave whose do_step only starts a step."""

    overlaps: bool

    def complete(self) -> None:
        """Wait for the end of the step."""
        ...


def interleaved(
    layout: Layout, tick: int, steps: Iterable[tuple[Sequence[Task], Block | StartedStep]]
) -> Iterator[Block]:
    """Yield the blocks of one tick, each of one component's step or of several.

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
        if isinstance(step, StartedStep):
            yield step.begin
            open_ |= {task.name: step for task in tasks}
        else:
            yield step
    for other in dict.fromkeys(open_.values()):
        yield other.finish


def _read(layout: Layout, tick: int, tasks: Iterable[Task]) -> Iterator[str]:
    """Yield the components whose outputs of this tick are read."""
    for task in tasks:
        for link, version in layout.renewed(task, tick):
            if version >= layout.schedule.task(link.producer).begun(tick):
                yield link.producer


def alone(steps: Iterable[tuple[Task, Any]]) -> Iterator[tuple[tuple[Task, ...], Block | StartedStep]]:
    """Yield steps, none of which is joined with others."""
    for task, step in steps:
        yield (task,), step
