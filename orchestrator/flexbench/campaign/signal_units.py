"""Units of metrics that are taken from recorded signals: those that the FMUs declare, without conversion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from lockstep import InputError, System
from lockstep.fmi.model_description import read_description

from .metrics import MetricSource

if TYPE_CHECKING:
    from .statistics.sample import Metric


def check_signal_units(
    metrics: Iterable[Metric], sources: Mapping[str, MetricSource], systems: Iterable[System], where: str
) -> None:
    """Refuse a metric of a signal whose unit is not that of the signal: its limits would be of another unit.

    Raises
    ------
    InputError
        With the signal's unit. A signal that no FMU declares, and one without a unit, takes any.
    """
    given = [metric for metric in metrics if metric.shown_unit and sources[metric.name].of_signal]
    for system in systems:
        for metric in given:
            signal = sources[metric.name].of
            declared = declared_unit(system, signal)
            if declared not in (None, metric.shown_unit):
                raise InputError(
                    f"{where}: metric.{metric.name}: unit = {metric.shown_unit!r}: {signal} is in {declared}, and "
                    f"metrics of signals are not converted; write unit = {declared!r}, and limits in it"
                )


def declared_unit(system: System, name: str) -> str | None:
    """Return the unit that an FMU declares for a component's variable; None if there is no such one, or it has none."""
    component, _, variable = name.partition(".")
    for one in system.components:
        if one.name == component:
            found = read_description(one).variables.get(variable)
            return None if found is None or found.unit is None else found.unit.name
    return None
