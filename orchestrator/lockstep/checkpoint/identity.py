"""Compare a run with that of a checkpoint: FMUs, adapters, timing, connections and fixed parameters must agree."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from lockstep.errors import InputError, compact
from lockstep.plan.plan import Plan
from lockstep.system.clock import read_nanoseconds, seconds_text, stored_nanoseconds
from lockstep.system.component import Component, Value
from lockstep.system.system import Connection

_REMEDY = "give the same, or --reinitialise {name}"
_TIMING = {"period": "period", "offset": "offset"}


def identity(plan: Plan) -> dict[str, Any]:
    """Return what identifies a run, for JSON."""
    system = plan.system
    return {
        "tick": stored_nanoseconds(system.tick),
        "start_time": stored_nanoseconds(system.start_time),
        "components": {
            c.name: {
                "source": str(c.source),
                "sha256": plan.descriptions[c.name].sha256,
                "adapter": c.adapter.sha256 if c.adapter else "",
                "period": stored_nanoseconds(c.period),
                "offset": stored_nanoseconds(c.offset),
                "kind": c.kind,
                **_shadow(c, plan),
                "tolerance": plan.tolerances.get(c.name),
                "parameters": dict(plan.wiring.parameters[c.name]),
            }
            for c in system.components
        },
        "connections": {str(c): [c.from_component, c.to_component, *_way(c)] for c in system.connections},
    }


def _shadow(component: Component, plan: Plan) -> dict[str, Any]:
    """Return which shadow runs beside the component. The switchover may differ until it has happened."""
    if component.shadow is None:
        return {}
    shadow = component.shadow.component
    adapter = shadow.adapter.sha256 if shadow.adapter else ""
    periods = [stored_nanoseconds(period) for period in (shadow.period, component.shadow.period)]
    return {
        "shadow": [plan.shadows[shadow.name].sha256, adapter, *periods],
        "shadow_tolerance": plan.tolerances.get(shadow.name),
    }


def _way(connection: Connection) -> list[Any]:
    c = connection
    return [c.delay, c.factor, c.offset, c.convert_units, repr(c.table), repr(c.via)]


def refuse_other(there: Mapping[str, Any], plan: Plan, reinitialised: Collection[str], name: str) -> None:
    """Refuse, by name, a run that differs from that of a checkpoint. Components that are reinitialised may differ.

    Parameters that may change while an FMU runs are left to `changes`.
    """
    here = identity(plan)
    for component in reinitialised:
        plan.system.component(component)
    for key, what in (("tick", "tick"), ("start_time", "start time")):
        before, now = (read_nanoseconds(each.get(key, 0), f"{name}: {key}") for each in (there, here))
        if now != before:
            raise InputError(
                f"{name}: was made with another {what}: {seconds_text(before)} s there, {seconds_text(now)} s here"
            )
    missing = sorted(there["components"].keys() - here["components"].keys() - set(reinitialised))
    if missing:
        raise InputError(
            f"{name}: holds {compact(missing)}, which the system lacks; use the system that it was made of"
        )
    for component, present in here["components"].items():
        if component not in reinitialised:
            _same_component(component, there["components"].get(component), present, name)
    _same_connections(there["connections"], here["connections"], reinitialised, name)


def _same_component(component: str, saved: Mapping[str, Any] | None, present: Mapping[str, Any], name: str) -> None:
    remedy = _REMEDY.format(name=component)
    if saved is None:
        raise InputError(f"{component}: is not in {name}; give --reinitialise {component}")
    if saved["sha256"] != present["sha256"]:
        hashes = f"{saved['source']} with sha256 {saved['sha256'][:12]}, not {present['sha256'][:12]}"
        raise InputError(f"{component}: {name} was made with another FMU, {hashes}; {remedy}")
    if saved["adapter"] != present["adapter"]:
        hashes = f"sha256 {saved['adapter'][:12] or 'none'}, not {present['adapter'][:12] or 'none'}"
        raise InputError(f"{component}: {name} was made with another adapter, {hashes}; {remedy}")
    if saved.get("shadow") != present.get("shadow"):
        raise InputError(f"{component}: {name} was made with another shadow, or without; {remedy}")
    for key, word in _TIMING.items():
        if saved[key] != present[key]:
            before, now = (read_nanoseconds(each[key], f"{name}: {key}") for each in (saved, present))
            times = f"{seconds_text(before)} s, not {seconds_text(now)} s"
            raise InputError(f"{component}: {name} was made with another {word}, {times}; {remedy}")
    for key, whose in (("tolerance", ""), ("shadow_tolerance", " of the shadow")):
        if key in saved and saved[key] != present.get(key):  # older checkpoints lack it
            tolerances = f"{saved[key] or 'none'}, not {present.get(key) or 'none'}"
            raise InputError(f"{component}: {name} was made with another tolerance{whose}, {tolerances}; {remedy}")
    if saved["kind"] != present["kind"]:
        raise InputError(f"{component}: is {saved['kind']} in {name}, and {present['kind']} here; {remedy}")


def _same_connections(
    there: Mapping[str, list[Any]], here: Mapping[str, list[Any]], reinitialised: Collection[str], name: str
) -> None:
    for key in [*here, *there]:
        present, saved = here.get(key), there.get(key)
        if present == saved or {*(present or saved or [])[:2]} & set(reinitialised):
            continue
        if present is None or saved is None:
            where = f"in {name}" if present is None else "here"
            raise InputError(f"{key}: is connected {where} only; use the connections that the checkpoint was made with")
        if present[2] != saved[2]:
            raise InputError(
                f"{key}: {name} was made with a delay of {saved[2]} ticks, not {present[2]}; give the same"
            )
        raise InputError(f"{key}: {name} was made with another conversion on this connection; give the same")


def changes(
    there: Mapping[str, Any], plan: Plan, reinitialised: Collection[str], name: str
) -> dict[str, dict[str, Value]]:
    """Return the values to set at the checkpoint, by component and variable: those that differ from the checkpoint.

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
    for component, present in plan.wiring.parameters.items():
        if component in reinitialised:
            continue
        saved = there["components"][component]["parameters"]
        fed = {column.variable.name for f in plan.input_files for column in f.columns if column.component == component}
        for parameter in [*present, *(key for key in saved if key not in present and key not in fed)]:
            if saved.get(parameter) != present.get(parameter):
                yield component, parameter, saved.get(parameter), present.get(parameter)
