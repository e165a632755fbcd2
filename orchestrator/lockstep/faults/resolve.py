"""Resolve scenarios against a plan: the variables, ticks and numbers of each fault; or refuse it by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from lockstep.arrays import Array
from lockstep.errors import InputError, compact, suggestion
from lockstep.faults import effects
from lockstep.faults.effects import Effect
from lockstep.faults.scenario import Fault, Scenario
from lockstep.faults.targets import Target, fed_inputs, tunables
from lockstep.fmi.parameter_values import parse_value
from lockstep.fmi.slave import DTYPES, Scalar
from lockstep.plan.plan import Plan
from lockstep.system.clock import Time, seconds, seconds_text
from lockstep.system.component import Value
from lockstep.system.system import System
from lockstep.system.unit_table import UNITS, gain_between

_ARITHMETIC = ("bias", "scale", "noise", "quantisation", "spike", "nan")  # these need numbers
_ABSOLUTE = ("stuck",)  # amounts that are values and not differences: the unit's offset counts


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """One fault on variables of one type of one component that are transferred together, in [begin, end) ticks."""

    component: str
    scalar: Scalar
    references: tuple[int, ...]
    names: tuple[str, ...]  # of the variables
    begin: int
    end: int
    effect: Effect
    originals: tuple[Value, ...] = ()  # of parameters: the values to set back to


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultEvent:
    """The begin or the end of a fault at this tick."""

    tick: int
    details: Mapping[str, object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolved:
    """All faults of a run, in the order in which they act, and their events in the order of time."""

    transfers: tuple[Group, ...]
    settings: tuple[Group, ...]  # of parameters
    events: tuple[FaultEvent, ...]
    tick: Time  # [ns]
    start: Time  # of the run [ns]


def resolve(scenarios: Sequence[Scenario], plan: Plan) -> Resolved:
    """Resolve every fault, or raise InputError."""
    transfers: list[Group] = []
    settings: list[Group] = []
    events: list[FaultEvent] = []
    for fault in (fault for scenario in scenarios for fault in scenario.faults):
        tick, start = plan.system.tick, plan.system.start_time
        if fault.begin < start:
            begins = f"begins at {seconds_text(fault.begin)} s, and the run at {seconds_text(start)} s"
            raise InputError(f"{fault.location}: {begins}; choose a window inside the run")
        begin = -(-(fault.begin - start) // tick)
        if begin >= plan.ticks:
            times = f"{seconds_text(fault.begin)} s, and the run ends at {seconds_text(plan.stop_time)} s"
            raise InputError(f"{fault.location}: begins at {times}; choose a window inside the run")
        after = plan.ticks + 1  # samples at the stop time are part of the run
        end = after if fault.end is None else min(after, -(-(fault.end - start) // tick))
        window = (begin, end)
        groups = _of_parameters(fault, plan, window) if fault.parameters else _of_connections(fault, plan, window)
        (settings if fault.parameters else transfers).extend(groups)
        events += _events(fault, groups)
    events.sort(key=lambda event: event.tick)
    return Resolved(
        transfers=tuple(transfers),
        settings=tuple(settings),
        events=tuple(events),
        tick=plan.system.tick,
        start=plan.system.start_time,
    )


def _of_connections(fault: Fault, plan: Plan, window: tuple[int, int]) -> list[Group]:
    system, descriptions = plan.system, plan.descriptions
    targets = fed_inputs(fault.connections, "connection", fault, system, descriptions)
    flags = fed_inputs(fault.validity, "validity", fault, system, descriptions)
    if fault.kind != "dropout":
        return _groups(fault, targets, _amounts(fault, targets, system), plan, window)
    named = {flag.name for flag in flags}
    flags += [t for t in targets if t.scalar == "Boolean" and t.name not in named]
    if not flags:
        raise InputError(f'{fault.location}: no validity flag among {compact(t.name for t in targets)}; add validity = '
                         '"component.input", or hold the values alone with kind = "stuck"')  # fmt: skip
    text = [flag.name for flag in flags if flag.scalar == "String"]
    if text:
        raise InputError(f"{fault.location}: validity: {text[0]} is a String; name a Boolean or a number")
    if fault.invalid and all(flag.scalar == "Boolean" for flag in flags):
        raise InputError(f"{fault.location}: invalid = {fault.invalid}: has no effect on {flags[0].name}, which becomes"
                         " false; leave it out")  # fmt: skip
    named = {flag.name for flag in flags}
    held = [t for t in targets if t.name not in named]
    stuck = replace(fault, kind="stuck")
    off = [_amount(stuck, flag, False if flag.scalar == "Boolean" else fault.invalid, system) for flag in flags]
    return [*_groups(stuck, held, [], plan, window), *_groups(stuck, flags, off, plan, window)]


def _groups(
    fault: Fault, targets: Sequence[Target], amounts: Sequence[Value], plan: Plan, window: tuple[int, int]
) -> list[Group]:
    """Split into variables that are transferred together: of one consumer, type, producer and delay."""
    together: dict[tuple[str, Scalar, str, int], list[int]] = {}
    for position, target in enumerate(targets):
        way = target.connection
        assert way is not None
        together.setdefault((target.component, target.scalar, way.from_component, way.delay), []).append(position)
    groups = []
    for (consumer, _, producer, delay), positions in together.items():
        mine = [targets[position] for position in positions]
        first = _first_transfer(fault, mine, plan, (producer, consumer, delay), window)
        groups.append(_group(fault, mine, [amounts[p] for p in positions if amounts], window, first))
    return groups


def _first_transfer(
    fault: Fault, targets: Sequence[Target], plan: Plan, way: tuple[str, str, int], window: tuple[int, int]
) -> int:
    producer, reader, delay = plan.schedule.task(way[0]), plan.schedule.task(way[1]), way[2]
    tick = window[0]
    while not reader.steps_at(tick) or producer.seen(tick, delay) == producer.seen(tick - reader.period, delay):
        tick += 1
    _refuse_empty(fault, [str(target.connection) for target in targets], tick, window, plan)
    return tick


def _refuse_empty(fault: Fault, names: Sequence[str], tick: int, window: tuple[int, int], plan: Plan) -> None:
    """Refuse a fault whose first action, at this tick, lies after its window or at the end of the run."""
    last = min(window[1], plan.ticks)
    if tick < last:
        return
    begin, end, next_ = (seconds_text(plan.schedule.time(t)) for t in (window[0], last, tick))
    others = f" and {len(names) - 1} more" if len(names) > 1 else ""
    raise InputError(f"{fault.location}: no value of {names[0]}{others} is transferred in [{begin}, {end}) s; "
                     f"the next is at {next_} s")  # fmt: skip


def _of_parameters(fault: Fault, plan: Plan, window: tuple[int, int]) -> list[Group]:
    targets = tunables(fault, plan.system, plan.descriptions)
    amounts = _amounts(fault, targets, plan.system)
    together: dict[tuple[str, Scalar], list[int]] = {}
    for position, target in enumerate(targets):
        together.setdefault((target.component, target.scalar), []).append(position)
    groups = []
    for (component, _), positions in together.items():
        task = plan.schedule.task(component)
        first = window[0] + (task.offset - window[0]) % task.period
        mine = [targets[position] for position in positions]
        _refuse_empty(fault, [f"{t.name} at a step of {component}" for t in mine], first, window, plan)
        group = _group(fault, mine, [amounts[p] for p in positions if amounts], window, first)
        groups.append(replace(group, originals=tuple(_original(target, plan) for target in mine)))
    return groups


def _original(target: Target, plan: Plan) -> Value:
    """Return the value of a parameter without the fault."""
    component, name = plan.system.component(target.component), target.variable.name
    given = plan.wiring.parameters[target.component].get(name)
    if given is None and component.adapter is not None:
        given = component.adapter.parameters.get(name)
    if given is None:
        given = target.variable.start
    if given is None:
        return "" if target.scalar == "String" else 0
    return parse_value(given, target.variable, target.name)


def _group(
    fault: Fault, targets: Sequence[Target], amounts: Sequence[Value], window: tuple[int, int], first: int
) -> Group:
    begin, end = window
    return Group(
        component=targets[0].component,
        scalar=targets[0].scalar,
        references=tuple(target.variable.reference for target in targets),
        names=tuple(target.variable.name for target in targets),
        begin=begin,
        end=first + 1 if _once(fault) else end,
        effect=_effect(fault, targets, amounts, begin),
    )


def _effect(fault: Fault, targets: Sequence[Target], amounts: Sequence[Value], begin: int) -> Effect:
    scalar = targets[0].scalar
    if fault.kind == "stuck":
        return effects.Stuck(begin, np.array(amounts, DTYPES[scalar]) if amounts else None)
    if fault.kind == "delay":
        return effects.Delay(fault.ticks)
    limits = None
    if scalar != "Real":
        limits = effects.limits_of(*zip(*(target.variable.limits for target in targets), strict=True))
    numbers = np.array(amounts, np.float64)
    kinds: dict[str, effects.Linear] = {"bias": "add", "scale": "multiply"}
    linear = (kinds[fault.kind], numbers) if fault.kind in kinds and limits is None else None
    change = effects.Change(_function(fault, numbers, [target.name for target in targets]), limits, linear)
    return effects.SingleSpike(begin, change) if _once(fault) else change


def _once(fault: Fault) -> bool:
    return fault.kind == "spike" and fault.probability is None


def _function(fault: Fault, numbers: Array, names: Sequence[str]) -> effects.Function:
    match fault.kind:
        case "nan":
            return effects.not_a_number()
        case "scale":
            return effects.scale(numbers)
        case "quantisation":
            return effects.quantisation(numbers)
        case "noise":
            return effects.noise(numbers, fault.seed, names)
        case "spike" if fault.probability is not None:
            return effects.random_spikes(numbers, fault.probability, fault.seed, names)
    return effects.bias(numbers)  # also that of a single spike


def _amounts(fault: Fault, targets: Sequence[Target], system: System) -> list[Value]:
    """Return one amount for each target in the unit of its FMU, or none where the kind has none."""
    for target in targets:
        if target.scalar in ("Boolean", "String") and fault.kind in _ARITHMETIC:
            raise InputError(
                f"{fault.location}: {target.name} is {target.variable.type}: {fault.kind} acts on numbers; "
                "use stuck, dropout or delay"
            )
        if fault.kind == "nan" and target.scalar != "Real":
            raise InputError(f"{fault.location}: {target.name} is {target.variable.type}; only a Real can be nan")
    if not fault.amount:
        return []
    given = list(fault.amount) * (len(targets) if len(fault.amount) == 1 else 1)
    if len(given) != len(targets):
        there = compact(target.name for target in targets)
        raise InputError(
            f"{fault.location}: {len(given)} numbers for {len(targets)} values, {there}; give one, or each"
        )
    return [_amount(fault, target, value, system) for target, value in zip(targets, given, strict=True)]


def _amount(fault: Fault, target: Target, value: Value, system: System) -> Value:
    if fault.unit is not None:
        if isinstance(value, str):
            raise InputError(f"{fault.location}: value = {value!r} is a text, and unit = {fault.unit!r} is for numbers")
        value = _converted(fault, target, float(value), system)
    if fault.kind not in _ABSOLUTE:
        return value
    variable = target.variable
    if target.connection is not None:  # a broken sensor need not stay in the range that the FMU declares
        variable = replace(variable, minimum=None, maximum=None)
    return parse_value(value, variable, f"{fault.location}: {target.name}")


def _converted(fault: Fault, target: Target, value: float, system: System) -> float:
    what = f"{fault.location}: unit = {fault.unit!r}"
    declared = target.variable.unit or system.component(target.component).units.get(target.variable.name)
    if declared is None:
        raise InputError(
            f"{what}: {target.name} has no unit; leave unit out, and give the numbers in the unit that it expects"
        )
    named = declared if fault.unit == declared.name else UNITS.get(str(fault.unit))
    if named is None:
        raise InputError(f"{what}: no such unit; {target.name} is in {declared.name!r}; there are {', '.join(UNITS)}"
                         f"{suggestion(str(fault.unit), UNITS)}")  # fmt: skip
    try:
        gain, bias = gain_between(named, declared, target.variable.relative)
    except ValueError as error:
        raise InputError(f"{what}: {target.name}: {error}") from None
    converted = gain * value + (bias if fault.kind in _ABSOLUTE else 0.0)
    if not isfinite(converted):
        raise InputError(f"{what}: {value!r} is {converted} in {declared.name!r}; give a smaller number")
    return converted


def _events(fault: Fault, groups: Sequence[Group]) -> list[FaultEvent]:
    """Return the events of a fault: begin and end, for each component that it acts on."""
    key = {"stuck": "value", "scale": "factor", "noise": "deviation", "quantisation": "step"}.get(fault.kind, "value")
    values: dict[str, object] = {}
    if fault.amount:
        values[key] = fault.amount[0] if len(fault.amount) == 1 else list(fault.amount)
    values |= {"unit": fault.unit} if fault.unit is not None else {}
    values |= {"ticks": fault.ticks} if fault.kind == "delay" else {}
    values |= {"probability": fault.probability} if fault.probability is not None else {}
    values |= {"seed": fault.seed} if fault.kind == "noise" or fault.probability is not None else {}
    values |= {"invalid": fault.invalid} if fault.kind == "dropout" and fault.invalid else {}
    window: dict[str, object] = {"from": seconds(fault.begin)}
    window |= {"to": seconds(fault.end)} if fault.end is not None else {}
    events = []
    for component in dict.fromkeys(group.component for group in groups):
        mine = [group for group in groups if group.component == component]
        details = {
            "name": fault.name,
            "kind": fault.kind,
            "component": component,
            "variables": [name for group in mine for name in group.names],
            "values": values,
        }
        events.append(FaultEvent(tick=mine[0].begin, details={"state": "begin", **details, **window}))
        events.append(FaultEvent(tick=max(group.end for group in mine), details={"state": "end", **details}))
    return events
