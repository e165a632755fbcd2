"""Check whether a bundle can carry a system, and collect what it is made of: ports, wiring, and a memory layout."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from lockstep.bundle.platforms import VERSIONS
from lockstep.bundle.ports import Choice, Port, carried, choose, components_of
from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import Scalar
from lockstep.plan.bus_layout import Layout, Reference
from lockstep.plan.overrides import Override, unfed
from lockstep.plan.schedule import Schedule, Task, build_schedule, whole_ticks
from lockstep.plan.transfer import linear
from lockstep.plan.wiring import Link, Wiring, wire
from lockstep.shadow.component import described
from lockstep.system.clock import Time
from lockstep.system.component import Component, Value
from lockstep.system.system import System

CARRIED: tuple[Scalar, ...] = ("Real", "Integer", "Boolean")  # what connections transfer


@dataclass(frozen=True, slots=True, kw_only=True)
class Contents:
    """All that a bundle is made of.

    `initial` is the schedule in which components are initialised, that of the master; the one of `layout` has those
    first whose samples are taken before the outputs of a communication point are read.
    """

    system: System
    descriptions: Mapping[str, Description]
    wiring: Wiring
    ports: tuple[Port, ...]
    initial: Schedule
    layout: Layout
    step_ticks: int  # steps of the bundle are multiples of so many ticks
    notes: tuple[str, ...]  # what is different from the system

    @property
    def early(self) -> Collection[str]:
        """The sampled components that no input reaches: their sample at a communication point is taken there."""
        return {t.name for t in self.layout.schedule.tasks if not (t.continuous or t.after_row)}

    def starts(self, name: str) -> dict[Scalar, dict[int, Value]]:
        """Return a component's values by type and reference, as the system gives them."""
        return self.wiring.starts(name, self.descriptions[name])


def contents(system: System, overrides: Mapping[str, Override], choice: Choice, step: Time | None = None) -> Contents:
    """Collect the contents of a bundle.

    Parameters
    ----------
    system : to be bundled
    overrides : values that replace those of the system, as `--set` gives them
    choice : of the ports
    step : steps of the bundle are multiples of it [ns]; None: the tick

    Raises
    ------
    InputError
        If anything in the input is wrong, or a bundle cannot carry it.
    """
    for component in system.components:
        _refuse_component(component)
    descriptions = {component.name: described(component) for component in system.components}
    for component in system.components:
        _refuse_fmu(component, descriptions[component.name])
    wiring = wire(replace(system, strict_inputs=False), descriptions, overrides)
    for link in wiring.links:
        _refuse_link(link, system, descriptions)
    _refuse_other_types(system, descriptions, wiring)
    ports = choose(system, descriptions, wiring, choice)
    if system.strict_inputs:
        _refuse_unfed(system, wiring, ports)
    schedule = build_schedule(system)
    ports, notes = _without_future_texts(ports, schedule, choice)
    arranged = _arranged(schedule, system, components_of(ports, "input"))
    ticks = 1 if step is None else whole_ticks(step, system.tick, "step size of the bundle")
    layout = Layout(schedule=arranged, links=wiring.links, recorded=_recorded(ports), record_ticks=ticks)
    layout.cycle  # noqa: B018 (refuses a plan that would be too long)
    return Contents(
        system=system,
        descriptions=descriptions,
        wiring=wiring,
        ports=ports,
        initial=schedule,
        layout=layout,
        step_ticks=ticks,
        notes=(*notes, *_notes(system)),
    )


def _notes(system: System) -> tuple[str, ...]:
    isolated = [component.name for component in system.components if component.isolated]
    return (
        (f"{compact(isolated)}: isolated in the system; in a bundle all FMUs are in one process",) if isolated else ()
    )


def _arranged(schedule: Schedule, system: System, fed: Collection[str]) -> Schedule:
    """Return the schedule with sampled components first that no input of the bundle reaches within a tick.

    The others take their sample after the outputs at a communication point have been read: inputs are set there.
    """
    sampled = {task.name for task in schedule.tasks if not task.continuous}
    late = sampled & set(fed)
    reached = True
    while reached:
        now = {c.to_component for c in system.connections if c.delay == 0 and c.from_component in late} & sampled - late
        late |= now
        reached = bool(now)
    tasks = [replace(task, after_row=task.name in late) for task in schedule.tasks]

    def comes_later(task: Task) -> bool:
        return task.continuous or task.after_row

    return replace(schedule, tasks=tuple(sorted(tasks, key=comes_later)))


def _recorded(ports: tuple[Port, ...]) -> dict[str, tuple[Reference, ...]]:
    found: dict[str, dict[Reference, None]] = {}
    for port in ports:
        scalar = port.variable.scalar
        if port.kind == "output" and scalar in CARRIED:
            found.setdefault(port.ends[0].component, {})[scalar, port.variable.reference] = None
    return {name: tuple(references) for name, references in found.items()}


def _refuse_component(component: Component) -> None:
    what = f"{component.name}: a bundle cannot carry"
    if component.sums is not None:
        raise InputError(f"{what} sums of an OSP system; add the signals in an FMU, or write the system without them")
    if component.shadow is not None:
        raise InputError(f"{what} a shadow; bundle the system without --shadow")
    if component.adapter is not None:
        raise InputError(
            f"{what} an adapter; write its connections as SSP first: write-ssp SYSTEM --replace {component.name}=FMU "
            "--adapter FILE --out adapted.ssp"
        )


def _refuse_fmu(component: Component, description: Description) -> None:
    if description.version not in VERSIONS:
        raise InputError(
            f"{component.name}: {component.source.name} is an FMU of FMI {description.version}; a bundle holds FMUs of "
            f"FMI {' and '.join(VERSIONS)}; export it for one of them"
        )


def _refuse_link(link: Link, system: System, descriptions: Mapping[str, Description]) -> None:
    target = link.target_scalar or link.scalar
    plain = target == "Real" and linear(link.ways, target)
    if plain or (target == link.scalar and target in CARRIED and all(way.function is None for way in link.ways)):
        return
    names = {v.reference: v.name for v in descriptions[link.consumer].variables.values() if v.scalar == target}
    wrong = (n for n, way in zip(link.targets, link.ways, strict=True) if target not in CARRIED or way.function)
    name = names[next(wrong)]
    connection = next(c for c in system.connections if (c.to_component, c.input) == (link.consumer, name))
    if target not in CARRIED:
        raise InputError(
            f"{connection}: a bundle cannot carry a connection of {target}s; remove it, and give the value by "
            f"--set {link.consumer}.{name}=VALUE"
        )
    raise InputError(
        f"{connection}: a bundle carries linear conversions of Reals only, neither mapping tables nor transformations "
        "of Integers; convert in an FMU, or connect ports of equal meaning"
    )


def _refuse_other_types(system: System, descriptions: Mapping[str, Description], wiring: Wiring) -> None:
    """Refuse connections, connectors and values of types of FMI 3.0 that a bundle does not carry."""
    used = [(c.from_component, c.output, f"{c}") for c in system.connections]
    used += [(c.to_component, c.input, f"{c}") for c in system.connections]
    used += [(port.component, port.variable, f"connector {port.name}") for port in system.ports]
    used += [(f.component, f.input, f"connector {one.name}") for one in system.inputs for f in one.feeds]
    for name, values in wiring.parameters.items():
        used += [(name, key, f"value of {name}.{key}") for key in values]
    for name, key, what in used:
        variable = descriptions[name].variables[key]
        if not carried(variable):
            raise InputError(
                f"{what}: {name}.{key} is {variable.native or variable.type}; a bundle carries Float64, Int32, Boolean "
                "and String of FMI 3.0; convert in an FMU, or leave it out"
            )


def _refuse_unfed(system: System, wiring: Wiring, ports: tuple[Port, ...]) -> None:
    fed = {(end.component, end.variable.name) for port in ports if port.kind == "input" for end in port.ends}
    for name, loose in wiring.unconnected.items():
        rest = tuple(one for one in loose if (name, one) not in fed)
        if rest:
            raise InputError(f"{unfed(name, rest, system)}; or make it an input of the bundle by --input "
                             f"{name}.{rest[0]}")  # fmt: skip


def _without_future_texts(
    ports: tuple[Port, ...], schedule: Schedule, choice: Choice
) -> tuple[tuple[Port, ...], tuple[str, ...]]:
    """Leave out Strings of continuous components whose step is longer than the tick, and return what to say of them.

    Strings are read from the FMU itself, which has those of the end of the step. One that is chosen by its name is
    refused.
    """
    late = []
    for port in ports:
        if port.kind == "output" and port.variable.scalar == "String":
            task = schedule.task(port.ends[0].component)
            late += [port.name] if task.continuous and task.period > 1 else []
    reason = "a bundle shows Strings of components that step at each tick, or are sampled"
    for name in late:
        if name in (choice.outputs or ()):
            raise InputError(f"--output {name}: {reason}; choose other outputs")
    notes = (f"left out: {compact(late)}: {reason}",) if late else ()
    return tuple(port for port in ports if port.name not in late), notes
