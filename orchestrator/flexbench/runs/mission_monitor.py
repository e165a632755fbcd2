"""Watch the mission of a run: changes of mode, wheels that fail, outages of the star tracker, as events of the run.

At the end of a run the same events say how the mission went.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.runtime.missions.mode_logic import MODES, OFF_LOAD
from flexsat.runtime.missions.off_loading import GIVEN_UP
from lockstep.results.monitor import Found, Monitor
from lockstep.results.run_record import EVENTS
from lockstep.system.system import System

from ..loop.loop_parts import Parameters, number_of
from ..loop.mission_file import MANAGER
from .loop_monitor import watch_loop

MODE, OUTAGE, STATUS = f"{MANAGER}.mode", f"{MANAGER}.star_tracker.outage", f"{MANAGER}.wheel.status"
STATES = ("works", "off", "seized")  # of a wheel, by its status
MOMENTUM = f"{MANAGER}.momentum"
NEARLY = 0.99  # of that: rows are not at the very ends of an off-loading
Event = Mapping[str, Any]  # of events.jsonl
_WATCHED = (MODE, OUTAGE, STATUS)


class MissionMonitor:
    """Looks at the rows of one run; a `lockstep.results.monitor.Monitor`."""

    def __init__(
        self,
        columns: Sequence[str],
        momentum: Sequence[str] = (),
        tolerance: float | None = None,
        duration: float | None = None,
    ) -> None:
        """Prepare for recorded signals of a mission manager.

        Parameters
        ----------
        columns : modes, states of wheels, outages
        momentum : of the wheels about each axis, if it is recorded
        tolerance : of off-loadings [N.m.s]
        duration : of an off-loading as planned [s]; it is given up after GIVEN_UP times that
        """
        self._columns, self._momentum = tuple(columns), tuple(momentum)
        self._known = {"tolerance": tolerance, "limit": None if duration is None else GIVEN_UP * duration}
        self._last: dict[str, int] = {}

    def rows(self, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> Iterator[Found]:
        """Yield what these rows show, in the order of their times."""
        found: list[Found] = []
        for name in self._columns:
            values = columns[name].astype(np.int64)
            before = np.concatenate([[self._last.get(name, values[0])], values[:-1]]) if len(values) else values
            for k in np.flatnonzero(values != before).tolist():
                one = _change(name, float(time[k]), int(before[k]), int(values[k]))
                ended = name == MODE and int(before[k]) == OFF_LOAD and self._momentum
                found.append(replace(one, details={**one.details, **self._left(columns, k)}) if ended else one)
            if len(values):
                self._last[name] = int(values[-1])
        yield from sorted(found, key=lambda one: one.time)

    def _left(self, columns: Mapping[str, NDArray[Any]], row: int) -> dict[str, float]:
        """Return what an off-loading left, about the axis with most of it [N.m.s]."""
        left = max(abs(float(columns[name][row])) for name in self._momentum)
        return {"momentum_left": left} | {name: value for name, value in self._known.items() if value is not None}

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


def watch_mission(system: System, parameters: Parameters, recorded: Sequence[str]) -> MissionMonitor | None:
    """Return what watches the mission manager of a system; None if there is none, or nothing of it is recorded."""
    manager = next((component for component in system.components if component.name == MANAGER), None)
    columns = [name for name in recorded if name.partition("[")[0] in _WATCHED]
    if manager is None or not columns:
        return None
    momentum = [name for name in recorded if name.partition("[")[0] == MOMENTUM]
    tolerance, duration = (number_of(manager, f"off_loading.{name}", parameters) for name in ("tolerance", "duration"))
    return MissionMonitor(columns, momentum, tolerance, duration)


def watch_run(system: System, parameters: Parameters, recorded: Sequence[str]) -> Monitor | None:
    """Return what watches the loop and the mission of a system; None for a system without both.

    It is a `lockstep.results.monitor.Watch`: the argument `watch` of `lockstep.simulate`.
    """
    loop, mission = watch_loop(system, parameters, recorded), watch_mission(system, parameters, recorded)
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


def print_mission(folder: Path) -> None:
    """Print how the mission of a run went; nothing for a run without a mission manager."""
    from lockstep.cli.outcome import remark

    path = folder / EVENTS
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    remark(*mission_lines([json.loads(line) for line in lines]))


def mission_lines(events: Sequence[Event]) -> list[str]:
    """Return a line for the mode at the end, and one each for wheels that failed, outages and short off-loadings."""
    modes, wheels, outages = (
        [event for event in events if event["event"] == kind]
        for kind in ("mode", "wheel-status", "star-tracker-outage")
    )
    if not modes and not wheels and not outages:
        return []
    return [*_mode(modes, wheels, outages), *_wheels(wheels), *_outages(outages), *_off_loadings(modes)]


def _mode(modes: Sequence[Event], wheels: Sequence[Event], outages: Sequence[Event]) -> Iterator[str]:
    if not modes:
        return
    last = modes[-1]
    text = f"mission: in mode {last['to']} from {last['time']:.6g} s to the end"
    if last["to"] != "safe":
        yield text
    elif any(wheel["time"] == last["time"] for wheel in wheels):
        yield f"{text}: the remaining wheels give no torque about some axis, and the attitude drifts about it"
    elif outages and outages[-1].get("begins"):
        yield f"{text}: no sample of the star tracker from {outages[-1]['time']:.6g} s on"
    else:
        yield f"{text}, by command"


def _wheels(wheels: Sequence[Event]) -> Iterator[str]:
    for number in sorted({event["wheel"] for event in wheels}):
        changes = [f"{event['to']} from {event['time']:.6g} s on" for event in wheels if event["wheel"] == number]
        yield f"wheel {number}: {', '.join(changes)}"


def _outages(outages: Sequence[Event]) -> Iterator[str]:
    begins = [event["time"] for event in outages if event.get("begins")]
    ends = [event["time"] for event in outages if event.get("ends")]
    for begin in begins:
        end = next((time for time in ends if time > begin), None)
        until = "to the end" if end is None else f"to {end:.6g} s"
        yield f"star tracker: no samples, known from {begin:.6g} s {until}"


def _off_loadings(modes: Sequence[Event]) -> Iterator[str]:
    """Name those that were given up. One that ended by itself was within its tolerance, whatever has come since."""
    for before, event in pairwise(modes):
        left, tolerance = event.get("momentum_left"), event.get("tolerance")
        if before["to"] != "off-load" or left is None or tolerance is None:
            continue
        given_up = event["to"] == "safe" or event["time"] - before["time"] > NEARLY * event.get("limit", 0.0)
        if given_up and left > tolerance:
            yield (
                f"off-loading from {before['time']:.6g} to {event['time']:.6g} s left {left:.3g} N.m.s about an axis,"
                f" more than mission.off_loading.tolerance, {tolerance:g}"
            )
