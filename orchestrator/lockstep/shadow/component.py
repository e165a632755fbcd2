"""Give a component a shadow: what it then shows, when it is stepped, and the slave that holds both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import gcd, lcm
from pathlib import Path

from lockstep.adapter.component import shown_description
from lockstep.array_names import array_of
from lockstep.errors import InputError
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import Slave
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW, Joined, join
from lockstep.shadow.slave import ShadowedSlave, Tell
from lockstep.system.adapter_file import Adapter
from lockstep.system.clock import seconds_text
from lockstep.system.component import DEFAULT_BLEND, Component, Shadow
from lockstep.system.system import System


def with_shadow(
    system: System,
    name: str,
    fmu: Path,
    adapter: Adapter | None = None,
    hand_over: int | None = None,
    blend: int | None = None,
) -> System:
    """Return the system with another FMU that rides along beside a component, and may take over from it.

    Parameters
    ----------
    system : holds the component
    name : of the component
    fmu : the shadow; without an adapter it has to have the outputs that others read of the component
    adapter : between the shadow and the ports of the component; its step becomes the shadow's period
    hand_over : when the shadow takes over [ns], at a step of both; None: never
    blend : how long the difference at the hand-over takes to pass [ns]; None: 5 s

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
    for who, kind in kinds.items():
        if kind != "sampled":
            raise InputError(f"{who}: is {kind}; a shadow and what it may replace have to be sampled: to act at once")
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
            adapter=adapter,
            stands_for=(original.stands_for or original) if adapter else None,
        ),
        period=original.period,
        outputs=tuple(dict.fromkeys(c.output for c in system.connections if c.from_component == name)),
        hand_over=hand_over,
        blend=DEFAULT_BLEND if blend is None else blend,
    )
    if not shadow.outputs:
        raise InputError(f"{name}: nothing reads an output of it, so there is nothing that a shadow could take over")
    _check_time(name, shadow)
    common = gcd(period, original.period)
    held = replace(original, period=common, offset=original.offset % common, shadow=shadow)
    joined_ports(held)
    return replace(
        system,
        components=tuple(held if c.name == name else c for c in system.components),
        record=(*system.record, *recorded(held)),
    )


def _check_time(name: str, shadow: Shadow) -> None:
    over = shadow.hand_over
    if over is None:
        return
    both, offset = lcm(shadow.period, shadow.component.period), shadow.component.offset
    if (over - offset) % both:
        lower = (over - offset) // both * both + offset
        near = " or ".join(f"{seconds_text(time)} s" for time in (lower, lower + both) if time >= 0)
        raise InputError(
            f"hand-over {seconds_text(over)} s is no step of {name} and its shadow, whose periods are "
            f"{seconds_text(shadow.period)} s and {seconds_text(shadow.component.period)} s; choose {near}"
        )


def check_before(system: System, stop: int) -> None:
    """Refuse a hand-over [ns] that the run would not reach."""
    for component in system.components:
        over = component.shadow.hand_over if component.shadow else None
        if over is not None and over >= stop:
            raise InputError(
                f"hand-over {seconds_text(over)} s: the run ends at {seconds_text(stop)} s; hand over before that"
            )


def recorded(component: Component) -> tuple[str, ...]:
    """Return what has to be recorded for the shadow to be judged: outputs that can be handed over, of all kinds."""
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
    """Return what a component shows, with its adapter and its shadow. Raises InputError."""
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


def everyone(system: System) -> list[Component]:
    """Return all components, and after them their shadows."""
    return [*system.components, *(component.shadow.component for component in system.components if component.shadow)]


def with_shadows(system: System, slaves: Mapping[str, Slave], tell: Tell) -> dict[str, Slave]:
    """Return the slaves of the components, with their shadows inside; `tell` writes an event."""
    found: dict[str, Slave] = {}
    for component in system.components:
        slave, plan = slaves[component.name], component.shadow
        if plan is not None:
            shadow = slaves[plan.component.name]
            slave = ShadowedSlave(slave, shadow, joined_ports(component), plan, plan.component.offset, tell)
        found[component.name] = slave
    return found


def with_isolation(system: System, name: str, isolated: bool) -> System:
    """Return the system with a component or a shadow, by name, in a process of its own or in the master's."""
    for holder in system.components:
        if holder.shadow is not None and holder.shadow.component.name == name:
            shadow = replace(holder.shadow, component=replace(holder.shadow.component, isolated=isolated))
            changed = replace(holder, shadow=shadow)
            return replace(system, components=tuple(changed if c is holder else c for c in system.components))
    return system.with_isolation(name, isolated)
