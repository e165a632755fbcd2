"""Give a component a shadow: the variables that it then shows, its period, and the slave that holds both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lockstep.adapter.component import shown_description
from lockstep.array_names import array_of
from lockstep.errors import InputError
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import Slave
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW, Joined, join
from lockstep.shadow.slave import AddEvent, ShadowedSlave
from lockstep.system.adapter_file import Adapter
from lockstep.system.clock import Time, common_divisor, common_multiple, seconds_text
from lockstep.system.component import DEFAULT_BLEND, Component, Shadow
from lockstep.system.system import System

Tolerances = float | str | Mapping[str, float | str]  # of all, or by component


def with_shadow(
    system: System,
    name: str,
    fmu: Path,
    adapter: Adapter | None = None,
    switchover: Time | None = None,
    blend: Time | None = None,
) -> System:
    """Return the system with another FMU in shadow of a component, which may replace it during the run.

    Parameters
    ----------
    system : holds the component
    name : of the component
    fmu : the shadow; without an adapter it needs the outputs of the component that others read
    adapter : between the shadow and the ports of the component; its step becomes the shadow's period
    switchover : when the shadow replaces the component [ns], at a step of both; None: never
    blend : time over which the difference at the switchover decays [ns]; None: 5 s

    Raises
    ------
    InputError
        If the shadow does not fit, or the times do not.
    """
    original = system.component(name)
    if original.shadow is not None:
        raise InputError(f"{name}: has a shadow already, {original.shadow.component.source.name}; one is possible")
    if any(component.name == f"{name}_shadow" for component in system.components):
        raise InputError(f"{name}_shadow: is a component of the system, and would be the name of the shadow of {name}")
    period = (adapter and adapter.step) or original.period
    kinds = {name: original.kind, f"{name}_shadow": (adapter and adapter.kind) or original.kind}
    for named, kind in kinds.items():
        if kind != "sampled":
            raise InputError(f"{named}: is {kind}; a shadow and the component that it may replace must be sampled")
    for other in (period, original.period):
        if original.offset >= other:
            raise InputError(
                f"{name}: offset {seconds_text(original.offset)} s must be below the periods of both, "
                f"{seconds_text(other)} s is one"
            )
    shadow = Shadow(
        component=Component(
            name=f"{name}_shadow",
            source=fmu.absolute(),
            period=period,
            offset=original.offset,
            kind="sampled",
            adapter=adapter,
            stands_for=(original.stands_for or original) if adapter else None,
        ),
        period=original.period,
        outputs=tuple(dict.fromkeys(c.output for c in system.connections if c.from_component == name)),
        switchover=switchover,
        blend=DEFAULT_BLEND if blend is None else blend,
    )
    if not shadow.outputs:
        raise InputError(f"{name}: nothing reads its outputs, so that a shadow could replace nothing")
    _check_time(name, shadow, system.start_time)
    common = common_divisor(period, original.period)
    held = replace(original, period=common, offset=original.offset % common, shadow=shadow)
    joined_ports(held)
    return replace(
        system,
        components=tuple(held if c.name == name else c for c in system.components),
        record=(*system.record, *recorded(held)),
    )


def _check_time(name: str, shadow: Shadow, start: Time) -> None:
    over = shadow.switchover
    if over is None:
        return
    both, offset = common_multiple(shadow.period, shadow.component.period), start + shadow.component.offset
    if (over - offset) % both:
        lower = (over - offset) // both * both + offset
        near = " or ".join(f"{seconds_text(time)} s" for time in (lower, lower + both) if time >= start)
        raise InputError(
            f"switchover {seconds_text(over)} s is no step of {name} and its shadow, whose periods are "
            f"{seconds_text(shadow.period)} s and {seconds_text(shadow.component.period)} s; choose {near}"
        )


def check_times(system: System, stop: Time) -> None:
    """Refuse a switchover [ns] that is no step of both FMUs, or before or after the run."""
    for component in system.components:
        over = component.shadow.switchover if component.shadow else None
        if over is None or component.shadow is None:
            continue
        if over < (start := system.start_time):
            begins = f"the run begins at {seconds_text(start)} s"
            raise InputError(f"switchover {seconds_text(over)} s: {begins}; choose a later time")
        _check_time(component.name, component.shadow, start)
        if over >= stop:
            raise InputError(
                f"switchover {seconds_text(over)} s: the run ends at {seconds_text(stop)} s; choose an earlier time"
            )


def recorded(component: Component) -> tuple[str, ...]:
    """Return the signals by which a shadow is judged: the outputs that act, of both FMUs, and their residuals."""
    if component.shadow is None:
        return ()
    variables = joined_ports(component).variables
    names = (
        f"{prefix}{output}"
        for prefix in ("", ORIGINAL, SHADOW, RESIDUAL)
        for output in component.shadow.outputs
        if f"{prefix}{output}" in variables
    )
    return tuple(f"{component.name}.{array}" for array in dict.fromkeys(map(array_of, names)))


def described(component: Component) -> Description:
    """Return the description of a component with its adapter and its shadow. Raises InputError."""
    description = shown_description(component)
    if component.shadow is None:
        return description
    return replace(description, variables=joined_ports(component).variables)


def joined_ports(component: Component) -> Joined:
    """Match a component with its shadow, or raise InputError."""
    assert component.shadow is not None
    shadow = component.shadow.component
    return join(shadow.name, component.shadow.outputs, shown_description(component), shown_description(shadow))


def shadow_descriptions(system: System) -> dict[str, Description]:
    """Return the descriptions of all shadows by their names."""
    shadows = [component.shadow.component for component in system.components if component.shadow]
    return {shadow.name: shown_description(shadow) for shadow in shadows}


def with_shadow_components(system: System) -> list[Component]:
    """Return all components, and after them their shadows."""
    return [*system.components, *(component.shadow.component for component in system.components if component.shadow)]


def with_shadows(system: System, slaves: Mapping[str, Slave], add_event: AddEvent) -> dict[str, Slave]:
    """Return the slaves of the components, with their shadows inside; `add_event` records an event."""
    found: dict[str, Slave] = {}
    for component in system.components:
        slave, plan = slaves[component.name], component.shadow
        if plan is not None:
            shadow, first = slaves[plan.component.name], system.start_time + plan.component.offset
            slave = ShadowedSlave(slave, shadow, joined_ports(component), plan, first, add_event)
        found[component.name] = slave
    return found


def with_isolation(system: System, name: str, isolated: bool | None) -> System:
    """Return the system with a component or a shadow, by name, in a process of its own or in the master's."""
    return _with_changed(system, name, isolated=isolated)


def with_tolerances(system: System, given: Tolerances) -> System:
    """Return the system with a tolerance of all components and shadows, or of some by name; or raise InputError."""
    by_name = given if isinstance(given, Mapping) else dict.fromkeys(names_of(system), given)
    for name, tolerance in by_name.items():
        try:
            number = float(tolerance)
        except (ValueError, TypeError):
            raise InputError(f"{name}: tolerance {tolerance!r} must be a number > 0, for example 1e-6") from None
        system = _with_changed(system, name, tolerance=number)
    return system


def names_of(system: System) -> list[str]:
    """Return the names of all components and of their shadows."""
    return [component.name for component in with_shadow_components(system)]


def tolerances_of(system: System, descriptions: Mapping[str, Description]) -> dict[str, float]:
    """Return the tolerances that are passed to FMUs, by component; InputError if one is given and cannot be passed."""
    found = {}
    for component in with_shadow_components(system):
        description = descriptions[component.name]
        if component.tolerance is not None and description.version == "1.0":
            remedy = "name the others, as --tolerance C=T, or leave it out"
            raise InputError(
                f"{component.name}: tolerance {component.tolerance!r}: FMI 1.0 cannot pass a tolerance; {remedy}"
            )
        tolerance = description.tolerance_of(component)
        if tolerance is not None:
            found[component.name] = tolerance
    return found


def _with_changed(system: System, name: str, **changes: Any) -> System:
    """Return the system with other fields of a component or a shadow."""
    for holder in system.components:
        if holder.shadow is not None and holder.shadow.component.name == name:
            shadow = replace(holder.shadow, component=replace(holder.shadow.component, **changes))
            changed = replace(holder, shadow=shadow)
            return replace(system, components=tuple(changed if c is holder else c for c in system.components))
    found = system.component(name)
    return replace(system, components=tuple(replace(c, **changes) if c is found else c for c in system.components))
