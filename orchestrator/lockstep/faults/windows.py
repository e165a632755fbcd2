"""Read the windows in which faults acted from the events of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lockstep.errors import InputError
from lockstep.results.read_events import read_events

_KEYS = ("state", "name", "kind", "component", "variables", "values")  # of every event of a fault


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultWindow:
    """One fault on one component as recorded. Without an end, the run ended before the fault."""

    name: str
    kind: str
    component: str
    variables: tuple[str, ...]
    begin: float  # [s]
    end: float | None
    values: Mapping[str, Any] = field(default_factory=dict)


def fault_windows(folder: Path) -> list[FaultWindow]:
    """Return the faults of a run in the order in which they began; none for a folder without events."""
    begun: list[dict[str, Any]] = []
    for event in read_events(folder):
        if event["event"] != "fault":
            continue
        if lacking := [key for key in _KEYS if key not in event]:
            raise InputError(f"{folder}: a fault among its events has no {lacking[0]}; restore events.jsonl")
        if event["state"] == "begin":
            begun.append(event)
            continue
        same = ("name", "kind", "component", "variables")
        for open_ in begun:
            if "end" not in open_ and all(open_[key] == event[key] for key in same):
                open_["end"] = event["time"]
                break
    return [
        FaultWindow(
            name=event["name"],
            kind=event["kind"],
            component=event["component"],
            variables=tuple(event["variables"]),
            begin=event["time"],
            end=event.get("end"),
            values=event["values"],
        )
        for event in begun
    ]
