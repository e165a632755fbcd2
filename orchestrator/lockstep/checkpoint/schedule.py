"""Decide when to save checkpoints, and refuse components that cannot save their state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from lockstep.errors import InputError, compact
from lockstep.plan.plan import Plan
from lockstep.plan.schedule import whole_ticks
from lockstep.system.clock import nanoseconds, seconds_text
from lockstep.system.component import Component


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckpointSchedule:
    """When to save: at these times [s], and every so many seconds; without the state of these components."""

    times: Sequence[float | str] = ()
    every: float | str | None = None
    without: Sequence[str] = field(default=())

    def ticks(self, plan: Plan, first: int) -> list[int]:
        """Return after how many ticks to save, in order; those of a run that begins at tick `first`.

        Raises
        ------
        InputError
            If a time is off the tick or after the end, or a component cannot save its state and is not left out.
        """
        found = {self._tick(time, plan) for time in self.times}
        if self.every is not None:
            step = whole_ticks(nanoseconds(self.every, "checkpoint every"), plan.system.tick, "checkpoint every")
            found |= set(range(step, plan.ticks + 1, step))
        if found:
            self._refuse_without_state(plan)
        return sorted(tick for tick in found if tick >= first)

    def _tick(self, text: float | str, plan: Plan) -> int:
        time, start = nanoseconds(text, "checkpoint"), plan.system.start_time
        if time == start:
            return 0
        if start and time < start:
            times = f"checkpoint {seconds_text(time)} s: lies before the start time {seconds_text(start)} s"
            raise InputError(f"{times}; choose a later one")
        since = f"checkpoint {seconds_text(time)} s: the simulated time of" if start else "checkpoint"
        tick = whole_ticks(time - start, plan.system.tick, since)
        if tick > plan.ticks:
            end = seconds_text(plan.stop_time)
            raise InputError(
                f"checkpoint {seconds_text(time)} s: lies after the stop time {end} s; choose an earlier one"
            )
        return tick

    def _refuse_without_state(self, plan: Plan) -> None:
        for name in self.without:
            plan.system.component(name)
        unable = [c.name for c in plan.system.components if not saves_state(c, plan)]
        left = [name for name in unable if name not in self.without]
        if left:
            raise InputError(
                f"{compact(left)}: cannot save its state (canGetAndSetFMUstate, canSerializeFMUstate), so there can be "
                f"no checkpoint; --checkpoint-without {left[0]} saves the others; a branch then has to reinitialise it"
            )


def saves_state(component: Component, plan: Plan) -> bool:
    """Return whether a component, its shadow included, can save its state."""
    shadow = component.shadow
    if shadow is not None and not plan.shadows[shadow.component.name].saves_state:
        return False
    return plan.descriptions[component.name].saves_state
