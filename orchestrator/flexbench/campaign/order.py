"""The order of one run of a campaign, as it travels to a worker; imports little, as each worker waits for that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lockstep.system.component import Component
from lockstep.system.system import System

from ..engine.content import File
from .histories import Histories
from .metrics import MetricSource


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What all runs of a campaign are to give. `histories` of a single run is none, all or bands."""

    stop_time: float | None
    record: tuple[str, ...] | None  # None: the system file's
    record_period: float | None
    sources: Mapping[str, MetricSource]
    histories: Histories
    keep_fmus: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """One run, as it travels to a worker."""

    number: int
    system: File
    overrides: Mapping[str, Any]
    delays: Mapping[tuple[str, str], int]  # ticks
    faults: str  # content of a scenario file; "": none
    commands: str  # content of a CSV file of inputs; "": none
    wanted: Wanted


def with_delays(system: System, order: Order) -> System:
    """Return a system with the delays of an order."""
    for (start, end), ticks in order.delays.items():
        system = system.with_delay(start, end, ticks)
    return system


def moved_files(system: System, places: Mapping[Path, Path]) -> System:
    """Return a system whose files are elsewhere."""
    return replace(system, components=tuple(_moved(one, places) for one in system.components))


def _moved(component: Component, places: Mapping[Path, Path]) -> Component:
    archive = component.archive
    source = component.source if archive is not None or component.sums is not None else places[component.source]
    shadow, original = component.shadow, component.stands_for
    return replace(
        component,
        source=source,
        archive=None if archive is None else places[archive],
        shadow=None if shadow is None else replace(shadow, component=_moved(shadow.component, places)),
        stands_for=None if original is None else _moved(original, places),
    )
