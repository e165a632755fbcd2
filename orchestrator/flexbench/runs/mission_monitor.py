"""Watch the mission of a run: changes of mode, wheels that fail, outages of the star tracker, as events of the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.runtime.missions.mode_logic import MODES
from lockstep.results.monitor import Found, Monitor
from lockstep.system.system import System

from ..loop.loop_parts import Parameters
from ..loop.mission_file import MANAGER
from .loop_monitor import watch_loop

MODE, OUTAGE, STATUS = f"{MANAGER}.mode", f"{MANAGER}.star_tracker.outage", f"{MANAGER}.wheel.status"
STATES = ("works", "off", "seized")  # of a wheel, by its status
_WATCHED = (MODE, OUTAGE, STATUS)


class MissionMonitor:
    """Looks at the rows of one run; a `lockstep.results.monitor.Monitor`."""

    def __init__(self, columns: Sequence[str]) -> None:
        """Prepare for recorded signals of a mission manager."""
        self._columns = tuple(columns)
        self._last: dict[str, int] = {}

    def rows(self, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> Iterator[Found]:
        """Yield what these rows show, in the order of their times."""
        found: list[Found] = []
        for name in self._columns:
            values = columns[name].astype(np.int64)
            before = np.concatenate([[self._last.get(name, values[0])], values[:-1]]) if len(values) else values
            found += [_change(name, float(time[k]), int(before[k]), int(values[k]))
                      for k in np.flatnonzero(values != before).tolist()]  # fmt: skip
            if len(values):
                self._last[name] = int(values[-1])
        yield from sorted(found, key=lambda one: one.time)

    def end(self) -> Iterable[Found]:
        """Return nothing: every change was shown."""
        return ()

    def summary(self) -> Sequence[Mapping[str, object]]:
        """Return nothing: the changes are events."""
        return ()


class _Together:
    """Several monitors as one."""

    def __init__(self, monitors: Sequence[Monitor]) -> None:
        self._monitors = monitors

    def rows(self, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> Iterator[Found]:
        for monitor in self._monitors:
            yield from monitor.rows(time, columns)

    def end(self) -> Iterator[Found]:
        for monitor in self._monitors:
            yield from monitor.end()

    def summary(self) -> Sequence[Mapping[str, object]]:
        return [table for monitor in self._monitors for table in monitor.summary()]


def watch_mission(system: System, recorded: Sequence[str]) -> MissionMonitor | None:
    """Return what watches the mission manager of a system; None if there is none, or nothing of it is recorded."""
    if all(component.name != MANAGER for component in system.components):
        return None
    columns = [name for name in recorded if name.partition("[")[0] in _WATCHED]
    return MissionMonitor(columns) if columns else None


def watch_run(system: System, parameters: Parameters, recorded: Sequence[str]) -> Monitor | None:
    """Return what watches the loop and the mission of a system; None for a system without both.

    It is a `lockstep.results.monitor.Watch`: the argument `watch` of `lockstep.simulate`.
    """
    loop, mission = watch_loop(system, parameters, recorded), watch_mission(system, recorded)
    if loop is None or mission is None:
        return loop if mission is None else mission
    return _Together((loop, mission))


def _change(name: str, time: float, before: int, after: int) -> Found:
    if name == MODE:
        return Found(time=time, event="mode", details={"from": MODES[before], "to": MODES[after]})
    if name == OUTAGE:
        return Found(time=time, event="star-tracker-outage", details={"begins" if after else "ends": True})
    wheel = int(name.partition("[")[2].rstrip("]"))
    return Found(time=time, event="wheel-status", details={"wheel": wheel, "from": STATES[before], "to": STATES[after]})
