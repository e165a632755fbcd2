"""Read the signals of a run and reduce them to histories, motion and statistics that fit a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexbench.runs.slews import slews_of
from flexsat.arrays import Array
from lockstep import InputError, Signals
from lockstep.array_names import by_array

from .derived_histories import DerivedHistory, derived_histories
from .history_data import History, histories_within
from .motion_data import motion_data
from .results import Result
from .window_data import full_rate_data, windows_about

# bytes of data on a page before base64, shared by its runs: 7.3 MB of text, so that a page with figures is below 12 MB
DERIVED_BUDGET, RECORDED_BUDGET, MOTION_BUDGET, WINDOW_BUDGET = 1_200_000, 2_600_000, 800_000, 1_000_000
FIRST_ELEMENTS = 6  # of every array, before the rest of long ones
Window = tuple[float, float]  # begin, end [s]
PEAKED = 30.0  # times its median; a norm with higher peaks gets a logarithmic axis
MOST_MARKS = 40  # of one run: more hide the lines


@dataclass(frozen=True, slots=True, kw_only=True)
class HistoryStatistics:
    """Statistics of a history: RMS of the second half of the run, and largest absolute value of the whole run."""

    name: str
    unit: str
    late: float
    largest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RunData:
    """One run as the page shows it."""

    result: Result
    for_script: Mapping[str, Any]  # histories, marks and motion, for the page's script
    statistics: tuple[HistoryStatistics, ...]
    rows: int
    recorded: int  # signals
    end: float  # s, of the last row
    interval: float  # s, between two rows


def read_run_data(result: Result, runs: int, window: Window | None = None) -> RunData:
    """Read the signals of a run and reduce them to what fits a page.

    Parameters
    ----------
    result : the run
    runs : number of runs on the page
    window : part of the time to show, begin and end [s]; None for all

    Raises
    ------
    InputError
        If the run has no signals, or none in the window.
    """
    signals = result.signals()
    if len(signals.time) == 0:
        raise InputError(f"{result.folder}: has no row of signals yet; let it run longer")
    if window is not None:
        signals = _within(signals, window)
    derived = list(derived_histories(signals, result.run))
    first, rest = _by_priority(derived, signals)
    parts = [histories_within(signals.time, first, DERIVED_BUDGET // runs)] if first else []
    parts.append(histories_within(signals.time, _shortest_first(rest), RECORDED_BUDGET // runs))
    marks = list(_marks(result, signals))
    # what is whole needs no windows; a history of a short run, or of a page with few signals, is
    reduced = [
        one
        for part, ones in zip(parts, ([first, rest] if first else [rest]), strict=True)
        for one in ones
        if part["time"]["stride"] > 1
    ]
    windows = windows_about(marks, signals.time) if reduced else []
    motion = motion_data(signals, result.run, MOTION_BUDGET // runs) if result.run else None
    steps = np.diff(signals.time)
    return RunData(
        result=result,
        for_script={
            "name": result.name,
            "parts": parts,
            "marks": marks,
            "motion": motion,
            "full_rate": full_rate_data(signals.time, reduced, windows, WINDOW_BUDGET // runs),
        },
        statistics=tuple(_statistics(one, signals) for one in derived if not one.elements),
        rows=len(signals.time),
        recorded=len(signals.columns),
        end=float(signals.time[-1]),
        interval=float(np.median(steps)) if len(steps) else 0.0,
    )


def _within(signals: Signals, window: Window) -> Signals:
    start, end = window
    rows = (signals.time >= start) & (signals.time <= end)
    if np.count_nonzero(rows) < 2:
        raise InputError(
            f"--time-range {start:g} {end:g}: holds less than two rows; the record goes from {signals.time[0]:g} to"
            f" {signals.time[-1]:g} s"
        )
    columns = {name: values[rows] for name, values in signals.columns.items()}
    return replace(signals, time=signals.time[rows], columns=columns)


def _by_priority(derived: list[DerivedHistory], signals: Signals) -> tuple[list[History], list[History]]:
    """Return histories by priority for full resolution: first derived ones, then single wheels and recorded signals.

    A run without derived histories has none of first priority.
    """
    first: list[History] = []
    rest: list[History] = []
    for one in derived:
        columns = np.atleast_2d(one.values.T)
        logarithmic = _spans_decades(one.values)
        for element, values in zip(one.elements or ("",), columns, strict=True):
            history = History(
                name=f"{one.name} {element}".strip(),
                group=one.name,
                element=element,
                unit=one.unit,
                description=one.description,
                values=values,
                logarithmic=logarithmic,
            )
            (first if len(one.elements) <= 3 else rest).append(history)
    for group, elements in by_array(signals.columns).items():
        for index, name in elements.items() or [((), group)]:
            rest.append(
                History(
                    name=name,
                    group=group,
                    element=",".join(map(str, index)),
                    unit=signals.units[name],
                    description=signals.descriptions[name],
                    values=signals.columns[name],
                )
            )
    return first, rest


def _shortest_first(histories: list[History]) -> list[History]:
    """Return histories by priority for a place: the first elements of each array, then the rest, short arrays first."""
    sizes = Counter(one.group for one in histories)
    place: Counter[str] = Counter()
    ranked = []
    for one in histories:
        ranked.append((place[one.group] >= FIRST_ELEMENTS, sizes[one.group], one))
        place[one.group] += 1
    return [one for *_, one in sorted(ranked, key=lambda entry: entry[:2])]


def _spans_decades(values: Array) -> bool:
    """Return whether a norm has peaks so far above its median that a linear axis would hide the rest."""
    if not values.min() >= 0.0:  # no norm: its median, the dear part, is not needed
        return False
    usual = float(np.median(values))
    return bool(usual > 0.0 and values.max() > PEAKED * usual)


def _statistics(one: DerivedHistory, signals: Signals) -> HistoryStatistics:
    late = one.values[signals.time >= 0.5 * (signals.time[0] + signals.time[-1])]
    return HistoryStatistics(
        name=one.name,
        unit=one.unit,
        late=float(np.sqrt(np.mean(late**2))),
        largest=float(np.max(np.abs(one.values))),
    )


def is_fault(event: Mapping[str, Any]) -> bool:
    """Return whether an event is the begin or the end of an injected fault."""
    return "fault" in (event.get("event"), event.get("kind"))


def _marks(result: Result, signals: Signals) -> Iterator[dict[str, Any]]:
    """Yield the marks of a plot: begin and end of the slew, faults, and other events during the run."""
    for slew in slews_of(signals) if result.run is not None else ():
        yield {"time": slew.start, "text": "slew", "kind": "slew"}
        if slew.end is not None and slew.end > slew.start:
            yield {"time": slew.end, "text": "end", "kind": "slew"}
    count = 0
    for event in result.events:
        kind = "fault" if is_fault(event) else str(event.get("event", ""))
        if kind in ("start", "end", "log") or count >= MOST_MARKS:
            continue
        count += 1
        text = str(event.get("name") or kind.replace("-", " ") or event.get("component")) + (
            " ends" if event.get("state") == "end" else ""
        )
        yield {"time": float(event.get("time", 0.0)), "text": text[:24], "kind": kind}
