"""What has to be the same where a checkpoint is used: FMUs, adapters, timing, connections, fixed parameters."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from lockstep.errors import InputError, compact
from lockstep.plan.plan import Plan
from lockstep.system.clock import seconds_text
from lockstep.system.component import Component, Value
from lockstep.system.system import Connection

_REMEDY = "give the same, or --reinitialise {name}"
_TIMING = {"period": "period", "offset": "offset"}


def identity(plan: Plan) -> dict[str, Any]:
    """Return what a run is, as JSON takes it."""
    system = plan.system
    return {
        "tick": system.tick,
        "components": {
            c.name: {
                "source": str(c.source),
                "sha256": plan.descriptions[c.name].sha256,
                "adapter": c.adapter.sha256 if c.adapter else "",
                "period": c.period,
                "offset": c.offset,
                "kind": c.kind,
                **_shadow(c, plan),
                "parameters": dict(plan.wiring.parameters[c.name]),
            }
            for c in system.components
        },
        "connections": {str(c): [c.from_component, c.to_component, *_way(c)] for c in system.connections},
    }


def _shadow(component: Component, plan: Plan) -> dict[str, Any]:
    """Return which shadow rides along. When it takes over may differ, until it has."""
    if component.shadow is None:
        return {}
    shadow = component.shadow.component
    adapter = shadow.adapter.sha256 if shadow.adapter else ""
    return {"shadow": [plan.shadows[shadow.name].sha256, adapter, shadow.period, component.shadow.period]}


def _way(connection: Connection) -> list[Any]:
    c = connection
    return [c.delay, c.factor, c.offset, c.convert_units, repr(c.table), repr(c.via)]


def refuse_other(there: Mapping[str, Any], plan: Plan, reinitialised: Collection[str], name: str) -> None:
    """Refuse, by name, a run that is not the one of a checkpoint. Components that are reinitialised may differ.

    Parameters that may change while an FMU runs are left to `changes`.
    """
    here = identity(plan)
    for component in reinitialised:
        plan.system.component(component)
    if here["tick"] != there["tick"]:
        ticks = f"{seconds_text(there['tick'])} s there, {seconds_text(here['tick'])} s here"
        raise InputError(f"{name}: was made with another tick: {ticks}")
    missing = sorted(there["components"].keys() - here["components"].keys() - set(reinitialised))
    if missing:
        raise InputError(
            f"{name}: holds {compact(missing)}, which the system lacks; use the system that it was made of"
        )
    for component, mine in here["components"].items():
        if component not in reinitialised:
            _same_component(component, there["components"].get(component), mine, name)
    _same_connections(there["connections"], here["connections"], reinitialised, name)


def _same_component(component: str, its: Mapping[str, Any] | None, mine: Mapping[str, Any], name: str) -> None:
    remedy = _REMEDY.format(name=component)
    if its is None:
        raise InputError(f"{component}: is not in {name}; give --reinitialise {component}")
    if its["sha256"] != mine["sha256"]:
        hashes = f"{its['source']} with sha256 {its['sha256'][:12]}, not {mine['sha256'][:12]}"
        raise InputError(f"{component}: {name} was made with another FMU, {hashes}; {remedy}")
    if its["adapter"] != mine["adapter"]:
        hashes = f"sha256 {its['adapter'][:12] or 'none'}, not {mine['adapter'][:12] or 'none'}"
        raise InputError(f"{component}: {name} was made with another adapter, {hashes}; {remedy}")
    if its.get("shadow") != mine.get("shadow"):
        raise InputError(f"{component}: {name} was made with another shadow, or without; {remedy}")
    for key, word in _TIMING.items():
        if its[key] != mine[key]:
            times = f"{seconds_text(its[key])} s, not {seconds_text(mine[key])} s"
            raise InputError(f"{component}: {name} was made with another {word}, {times}; {remedy}")
    if its["kind"] != mine["kind"]:
        raise InputError(f"{component}: is {its['kind']} in {name}, and {mine['kind']} here; {remedy}")


def _same_connections(
    there: Mapping[str, list[Any]], here: Mapping[str, list[Any]], reinitialised: Collection[str], name: str
) -> None:
    for key in [*here, *there]:
        mine, its = here.get(key), there.get(key)
        if mine == its or {*(mine or its or [])[:2]} & set(reinitialised):
            continue
        if mine is None or its is None:
            where = f"in {name}" if mine is None else "here"
            raise InputError(f"{key}: is connected {where} only; use the connections that the checkpoint was made with")
        if mine[2] != its[2]:
            raise InputError(f"{key}: {name} was made with a delay of {its[2]} ticks, not {mine[2]}; give the same")
        raise InputError(f"{key}: {name} was made with another conversion on this connection; give the same")


def changes(
    there: Mapping[str, Any], plan: Plan, reinitialised: Collection[str], name: str
) -> dict[str, dict[str, Value]]:
    """Return the values to set at the checkpoint, by component and variable: those given otherwise than there.

    Raises
    ------
    InputError
        If a parameter differs that cannot change while the FMU runs.
    """
    found: dict[str, dict[str, Value]] = {}
    for component, parameter, before, now in _differing(there, plan, reinitialised):
        variable = plan.descriptions[component].variables.get(parameter)
        what = f"{component}.{parameter}"
        if now is None:
            raise InputError(f"{what}: has the value {before!r} in {name} and none here; give it")
        if variable is None or not (variable.causality == "input" or variable.variability == "tunable"):
            said = "was not set" if before is None else f"is {before!r}"
            remedy = f"give no other, or --reinitialise {component}"
            raise InputError(f"{what}: {said} in {name} and cannot change while the FMU runs; {remedy}")
        found.setdefault(component, {})[parameter] = now
    return found


def _differing(
    there: Mapping[str, Any], plan: Plan, reinitialised: Collection[str]
) -> Iterator[tuple[str, str, Value | None, Value | None]]:
    for component, mine in plan.wiring.parameters.items():
        if component in reinitialised:
            continue
        its = there["components"][component]["parameters"]
        for parameter in [*mine, *(key for key in its if key not in mine)]:
            if its.get(parameter) != mine.get(parameter):
                yield component, parameter, its.get(parameter), mine.get(parameter)
