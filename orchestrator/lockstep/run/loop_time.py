"""Where the wall time of a loop goes: steps of each component, exchange of values, recording, waiting, the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lockstep.plan.schedule import Task
from lockstep.run.loop import Loop
from lockstep.system.clock import seconds

_BAR = 30  # letters of a bar for all of the wall time
_DIGITS = 9  # after the point: nanoseconds


@dataclass(frozen=True, slots=True, kw_only=True)
class Steps:
    """The steps of a component."""

    name: str
    calls: int
    time: float | None  # [s], None where it is not measured

    @property
    def mean(self) -> float | None:
        """The time of a step [s]."""
        return None if self.time is None or not self.calls else self.time / self.calls


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopTime:
    """The wall time of a loop. Where it is measured, its parts are all of it."""

    wall: float  # [s]
    simulated: float  # [s]
    components: tuple[Steps, ...]
    others: Mapping[str, float]  # [s]; empty where it is not measured

    @property
    def factor(self) -> float:
        """Simulated time over wall time."""
        return self.simulated / self.wall if self.wall else 0.0

    @property
    def parts(self) -> list[tuple[str, float]]:
        """Names and times [s] of all parts, components first; none where it is not measured."""
        if not self.others:
            return []
        return [(one.name, one.time or 0.0) for one in self.components] + list(self.others.items())

    def record(self) -> dict[str, object]:
        """Return the table for run.toml."""
        return {
            "loop": round(self.wall, _DIGITS),
            "real_time_factor": float(f"{self.factor:.6g}"),
            **{name: round(time, _DIGITS) for name, time in self.others.items()},
            "component": [
                {"name": one.name, "calls": one.calls}
                | ({} if one.time is None else {"time": round(one.time, _DIGITS)})
                | ({} if one.mean is None else {"step": float(f"{one.mean:.6g}")})
                for one in self.components
            ],
        }

    def line(self, most: int = 5) -> str:
        """Return the largest parts in one line; empty where nothing is measured."""
        parts = sorted(self.parts, key=lambda part: -part[1])
        shown = [f"{name} {_percent(time / self.wall)}" for name, time in parts[:most] if time > 0.0]
        return f"wall time of the loop: {', '.join(shown)}" if shown and self.wall else ""

    def table(self) -> list[tuple[str, ...]]:
        """Return a row for each part: name, calls, time, time of a step, share, bar."""
        calls = {one.name: one for one in self.components}
        rows: list[tuple[str, ...]] = []
        for name, time in [*self.parts, ("all", self.wall)]:
            one, share = calls.get(name), time / self.wall if self.wall else 0.0
            step = "" if one is None or one.mean is None else f"{1e6 * one.mean:.2f}"
            bar = "#" * round(_BAR * share) if name != "all" else ""
            rows.append((name, "" if one is None else str(one.calls), f"{time:.3f}", step, _percent(share), bar))
        return rows


TABLE_HEADER = ("part", "calls", "time [s]", "a step [µs]", "share", "")


def loop_time(loop: Loop, tasks: Sequence[Task]) -> LoopTime:
    """Return where the wall time of a loop has gone up to now."""
    spent = loop.spent
    wall, measured = sum(spent.values()), len(spent) > 1
    named = {name[1:]: time for name, time in spent.items() if name.startswith("/")}
    others = {name: spent.get(name, 0.0) for name in ("exchange", "recording", "waiting", "rest")} if measured else {}
    names = [task.name for task in tasks]
    calls = {task.name: _calls(task, loop.executed) for task in tasks}
    joined = [name for name in named if name not in calls]  # steps of FMUs that share a process are one call
    inside = {name for each in joined for name in each.split(" + ")}
    alone = [name for name in names if name in named or name not in inside]
    components = [Steps(name=name, calls=calls[name], time=named.get(name) if measured else None) for name in alone]
    components += [Steps(name=name, calls=max(calls[one] for one in name.split(" + ")), time=named[name])
                   for name in joined]  # fmt: skip
    simulated = sum(end - begin for begin, end in loop.executed) * loop.tick
    return LoopTime(wall=wall, simulated=seconds(simulated), components=tuple(components), others=others)


def _calls(task: Task, executed: Sequence[tuple[int, int]]) -> int:
    """Return how many steps began in these ranges of ticks."""
    return sum(max(0, task.begun(end - 1)) - max(0, task.begun(begin - 1)) for begin, end in executed if end > begin)


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"
