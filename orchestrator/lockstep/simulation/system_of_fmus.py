"""Make a system of what a user gives: a system, a file, or FMUs by name with connections as pairs of names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from lockstep.array_names import elements_of
from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, read_description
from lockstep.ssp.load import load_system
from lockstep.ssp.step_times import DEFAULT_STEP, Timing
from lockstep.system.clock import Time, common_divisor, positive_nanoseconds, seconds_text
from lockstep.system.component import Component, Kind
from lockstep.system.system import Connection, System

Fmus = Mapping[str, "Path | str | Component"]  # by the name of the component
Pairs = Sequence[tuple[str, str]]  # `plant.rate` and `controller.rate`: an output and the input that receives it
Seconds = float | str
Periods = Seconds | Mapping[str, Seconds]  # of all components, or by name
Delays = Mapping["str | tuple[str, str]", int]  # [ticks] by the components of the connections: `plant:controller`

_PARTS = 2  # of a pair


def as_system(
    given: System | Path | str | Fmus,
    connections: Pairs = (),
    periods: Periods | None = None,
    delays: Delays | None = None,
    kinds: Mapping[str, Kind] | None = None,
) -> System:
    """Return the system that is given, or the one of a file or of FMUs by name; raise InputError.

    Parameters
    ----------
    given : a system; the path of a system file (.ssd, .ssp, OspSystemStructure.xml) or of one FMU; or FMUs by name
    connections : between FMUs by name; the names of two arrays of one size connect them whole
    periods : of the steps [s]; without one that of the file, or the default step size of the FMU
    delays : of all connections from one component to another [ticks]; without one the newest value available is read,
        as `lockstep.ssp.step_times` describes
    kinds : `sampled` or `continuous` by name; without one that of the file, or continuous, as FMI defines outputs
    """
    if isinstance(given, Mapping):
        system = _of_fmus(given, connections, periods, kinds or {})
    else:
        if connections:
            raise InputError("connections: are those of the system; give connections with FMUs by name only")
        system = _timed(given, periods, kinds or {})
    for key, ticks in (delays or {}).items():
        ends = tuple(key.split(":")) if isinstance(key, str) else tuple(key)
        if len(ends) != _PARTS:
            raise InputError(f"delays: {key!r} must name two components, such as 'plant:controller'")
        system = system.with_delay(ends[0], ends[1], ticks)
    return system


def _timed(given: System | Path | str, periods: Periods | None, kinds: Mapping[str, Kind]) -> System:
    if not isinstance(given, System):
        by_name = {name: time for name in _named(periods) if (time := _period(periods, name)) is not None}
        every = None if isinstance(periods, Mapping) else _period(periods, "all components")
        return load_system(given, Timing(period=every, periods=by_name, kinds=kinds))
    for component in given.components:
        period = _period(periods, component.name)
        given = given if period is None else given.with_period(component.name, period)
    for name in (*_named(periods), *kinds):
        given.component(name)
    return replace(given, components=tuple(replace(c, kind=kinds.get(c.name, c.kind)) for c in given.components))


def _period(periods: Periods | None, name: str) -> Time | None:
    """Return the period that is given for a component [ns], or None."""
    value = periods.get(name) if isinstance(periods, Mapping) else periods
    return None if value is None else positive_nanoseconds(value, f"{name}: period")


def _named(periods: Periods | None) -> Sequence[str]:
    return list(periods) if isinstance(periods, Mapping) else []


def _of_fmus(fmus: Fmus, connections: Pairs, periods: Periods | None, kinds: Mapping[str, Kind]) -> System:
    if not fmus:
        raise InputError("no FMUs are given; name at least one, such as {'plant': 'plant.fmu'}")
    for what, names in (("periods", _named(periods)), ("kinds", kinds)):
        for name in names:
            if name not in fmus:
                raise InputError(
                    f"{what}: {name}: no such component; there are {compact(fmus)}{suggestion(name, fmus)}"
                )
    parts = {name: _component(name, fmu) for name, fmu in fmus.items()}
    descriptions = {name: read_description(part) for name, part in parts.items()}
    warnings: list[str] = []
    found = _periods(parts, descriptions, fmus, periods, warnings)
    components = tuple(
        replace(part, period=found[name], kind=kinds.get(name, part.kind)) for name, part in parts.items()
    )
    by_name = {component.name: component for component in components}
    joined = [one for pair in connections for one in _connected(pair, descriptions, by_name)]
    tick = common_divisor(*(time for c in components for time in (c.period, c.offset) if time))
    name = "+".join(fmus)
    return System(
        name=name if len(name) <= 60 else "system",
        tick=tick,
        components=components,
        connections=tuple(joined),
        warnings=tuple(warnings),
    )


def _component(name: str, fmu: Path | str | Component) -> Component:
    if isinstance(fmu, Component):
        return replace(fmu, name=name)
    if not isinstance(fmu, str | Path):
        raise InputError(f"{name}: {fmu!r} must be the path of an FMU, or a Component")
    return Component(name=name, source=Path(fmu).absolute(), period=1)


def _periods(
    parts: Mapping[str, Component],
    descriptions: Mapping[str, Description],
    fmus: Fmus,
    periods: Periods | None,
    warnings: list[str],
) -> dict[str, Time]:
    found: dict[str, Time] = {}
    for name, part in parts.items():
        if (given := _period(periods, name)) is not None:
            found[name] = given
        elif isinstance(fmus[name], Component):
            found[name] = part.period
        elif (size := descriptions[name].step_size) is not None:
            try:
                found[name] = positive_nanoseconds(size, f"{name}: the FMU's step size")
            except InputError as error:
                raise InputError(f"{error}; give periods={{{name!r}: SECONDS}}") from None
    default = min(found.values(), default=DEFAULT_STEP)
    unknown = [name for name in parts if name not in found]
    if unknown:
        warnings.append(
            f"{compact(unknown)}: no period is given, and the FMU has no default step size: stepped every "
            f"{seconds_text(default)} s; give periods={{{unknown[0]!r}: SECONDS}}"
        )
    return {name: found.get(name, default) for name in parts}


def _connected(
    pair: tuple[str, str], descriptions: Mapping[str, Description], components: Mapping[str, Component]
) -> list[Connection]:
    """Return the connections of a pair: one, or one for each element of two arrays."""
    if isinstance(pair, str) or len(pair) != _PARTS:
        raise InputError(f"connections: {pair!r} must be a pair of names, such as ('plant.y', 'controller.u')")
    start, end = (_elements(name, descriptions, kind) for name, kind in zip(pair, ("output", "input"), strict=True))
    if len(start[1]) != len(end[1]):
        raise InputError(
            f"{pair[0]} -> {pair[1]}: {len(start[1])} and {len(end[1])} elements; connect arrays of one size, or "
            "elements by name"
        )
    delay = int(components[start[0]].kind == "continuous")
    return [
        Connection(from_component=start[0], output=output, to_component=end[0], input=target, delay=delay)
        for output, target in zip(start[1], end[1], strict=True)
    ]


def _elements(name: str, descriptions: Mapping[str, Description], kind: str) -> tuple[str, list[str]]:
    component, dot, variable = name.partition(".")
    if not dot or component not in descriptions:
        there = f"there are {compact(descriptions)}{suggestion(component, descriptions)}"
        raise InputError(f"{name}: write component.variable of a component that is there; {there}")
    variables = descriptions[component].variables
    found = [variable] if variable in variables else elements_of(variable, variables)
    if not found:
        raise InputError(descriptions[component].lacks(component, variable, kind))
    return component, found
