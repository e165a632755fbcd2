"""Choose the inputs, outputs and parameters of a bundle: connectors of the system, or variables of its components."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, cast

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.parameter_values import parse_value
from lockstep.plan.wiring import Wiring
from lockstep.results.signal_patterns import matching
from lockstep.system.component import Component, Value
from lockstep.system.system import Feed, System
from lockstep.system.transformation import convert
from lockstep.system.units import Unit, known_unit

ALL, NONE = "all", "none"
_NATIVE = ("Float64", "Int32", "Boolean", "String")  # types of FMI 3.0
Patterns = Sequence[str] | None
Kind = Literal["input", "output", "parameter"]
_ZERO: Mapping[str, Value] = {"Real": 0.0, "Integer": 0, "Enumeration": 0, "Boolean": False, "String": ""}


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A variable of a component behind a port: it gets gain * value + bias."""

    component: str
    variable: Variable
    gain: float = 1.0
    bias: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """One variable of the bundle. An input may lead to several variables; all else stands for one."""

    name: str
    kind: Kind
    ends: tuple[Target, ...]
    unit: Unit | None
    start: Value | None = None  # of inputs and parameters
    given: bool = False  # whether the system gives the value, not the FMU

    @property
    def variable(self) -> Variable:
        """The variable that type, range and description are those of."""
        return self.ends[0].variable


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Patterns on names of ports; `all` is every one, `none` is none, and None what the system declares."""

    inputs: Patterns = None
    outputs: Patterns = None
    parameters: Patterns = None


@dataclass(slots=True)
class _Found:
    """What can be chosen, and what is without a choice, by name."""

    ports: dict[str, Port] = field(default_factory=dict)
    default: list[str] = field(default_factory=list)


def choose(system: System, descriptions: Mapping[str, Description], wiring: Wiring, choice: Choice) -> tuple[Port, ...]:
    """Return the ports of a bundle: inputs, outputs, then parameters, in the order of the system.

    Raises
    ------
    InputError
        If a pattern matches nothing, two inputs lead to one variable, or two ports have one name.
    """
    inputs = _inputs(system, descriptions, wiring)
    outputs = _outputs(system, descriptions)
    parameters = _parameters(system, descriptions, wiring)
    chosen = (
        *_chosen(inputs, choice.inputs, "input"),
        *_chosen(outputs, choice.outputs, "output"),
        *_chosen(parameters, choice.parameters, "parameter"),
    )
    _refuse_twice(chosen)
    return chosen


def _chosen(found: _Found, patterns: Patterns, kind: Kind) -> list[Port]:
    if patterns is None:
        return [found.ports[name] for name in found.default]
    names: set[str] = set()
    for pattern in patterns:
        if pattern == NONE:
            continue
        matched = list(found.ports) if pattern == ALL else matching(pattern, found.ports)
        if not matched and pattern != ALL:
            there = compact(found.ports) if found.ports else "none"
            raise InputError(
                f"--{kind} {pattern}: matches no {kind}; there are {there}{suggestion(pattern, found.ports)}"
            )
        names.update(matched)
    return [port for name, port in found.ports.items() if name in names]


def _inputs(system: System, descriptions: Mapping[str, Description], wiring: Wiring) -> _Found:
    found = _Found()
    feeds: dict[str, tuple[Unit | None, list[Target]]] = {}
    for one in system.inputs:
        unit = one.unit
        for feed in one.feeds:
            variable = descriptions[feed.component].variables[feed.input]
            unit = unit or variable.unit
        feeds[one.name] = (unit, [_fed(one.name, unit, feed, descriptions) for feed in one.feeds])
    for port in system.ports:
        if port.kind == "input" and not any(port.name == one.name for one in system.inputs):
            variable = descriptions[port.component].variables[port.variable]
            unit, ends = feeds.setdefault(port.name, (_unit_of(variable, system.component(port.component)), []))
            ends.append(Target(component=port.component, variable=variable))
    for name, (unit, ends) in feeds.items():
        found.ports[name] = _settable(name, "input", tuple(ends), unit, wiring)
        found.default.append(name)
    connected = {(c.to_component, c.input) for c in system.connections}
    for component in system.components:
        for variable in descriptions[component.name].variables.values():
            free = variable.causality == "input" and (component.name, variable.name) not in connected
            if free and carried(variable):
                name = f"{component.name}.{variable.name}"
                end = Target(component=component.name, variable=variable)
                found.ports.setdefault(name, _settable(name, "input", (end,), _unit_of(variable, component), wiring))
    return found


def _fed(name: str, unit: Unit | None, feed: Feed, descriptions: Mapping[str, Description]) -> Target:
    variable = descriptions[feed.component].variables[feed.input]
    what = f"{name} -> {feed.component}.{feed.input}"
    source = variable.end(unit)
    target = variable.end(variable.unit)
    conversion = convert(source, target, feed.hops, what)
    if conversion.function is not None:
        raise InputError(f"{what}: a bundle carries linear conversions of Reals only, no mapping; choose "
                         f"--input {feed.component}.{feed.input} instead, or --input none")  # fmt: skip
    return Target(component=feed.component, variable=variable, gain=conversion.gain, bias=conversion.bias)


def _outputs(system: System, descriptions: Mapping[str, Description]) -> _Found:
    found = _Found()
    for port in system.ports:
        if port.kind == "output":
            variable = descriptions[port.component].variables[port.variable]
            unit = _unit_of(variable, system.component(port.component))
            found.ports[port.name] = _output(port.name, port.component, variable, unit)
            found.default.append(port.name)
    connectors = bool(found.ports)
    for component in system.components:
        for variable in descriptions[component.name].variables.values():
            if variable.causality == "output" and carried(variable):
                name = f"{component.name}.{variable.name}"
                found.ports.setdefault(name, _output(name, component.name, variable, _unit_of(variable, component)))
                found.default += [] if connectors else [name]
    return found


def _output(name: str, component: str, variable: Variable, unit: Unit | None) -> Port:
    return Port(name=name, kind="output", ends=(Target(component=component, variable=variable),), unit=unit)


def _parameters(system: System, descriptions: Mapping[str, Description], wiring: Wiring) -> _Found:
    found = _Found()
    for component in system.components:
        for variable in descriptions[component.name].variables.values():
            if variable.causality == "parameter" and carried(variable) and variable.settable:
                name = f"{component.name}.{variable.name}"
                end = Target(component=component.name, variable=variable)
                found.ports[name] = _settable(name, "parameter", (end,), _unit_of(variable, component), wiring)
    found.default += found.ports
    return found


def _settable(name: str, kind: Kind, ends: tuple[Target, ...], unit: Unit | None, wiring: Wiring) -> Port:
    """Return an input or a parameter with its start value: the system's, else the FMU's."""
    first = ends[0]
    variable = first.variable
    value = wiring.parameters[first.component].get(variable.name)
    given = value is not None
    if value is None and variable.start is not None:
        try:
            value = parse_value(variable.start, variable, f"{first.component}.{variable.name}: start")
        except InputError:  # a start value outside of its own range is the FMU's offence, reported elsewhere
            value = _plain_start(variable)
    if value is None:
        value = _ZERO[variable.type]
    if variable.type == "Real" and (first.gain, first.bias) != (1.0, 0.0) and first.gain:
        value = (float(value) - first.bias) / first.gain
    return Port(name=name, kind=kind, ends=ends, unit=unit, start=value, given=given)


def _plain_start(variable: Variable) -> Value | None:
    try:
        text = cast(str, variable.start)
        return float(text) if variable.type == "Real" else int(text)
    except ValueError:
        return None


def _unit_of(variable: Variable, component: Component) -> Unit | None:
    return known_unit(variable.unit, component.units.get(variable.name))


def _refuse_twice(ports: Iterable[Port]) -> None:
    names: set[str] = set()
    fed: dict[tuple[str, str], str] = {}
    for port in ports:
        if port.name in names:
            raise InputError(
                f"{port.name}: two variables of the bundle would have this name; choose others by --input, --output or "
                "--parameter"
            )
        names.add(port.name)
        for end in port.ends if port.kind == "input" else ():
            key = (end.component, end.variable.name)
            first = fed.setdefault(key, port.name)
            if first != port.name:
                raise InputError(
                    f"--input {port.name}: leads to {key[0]}.{key[1]}, as {first} does; choose one of them"
                )


def carried(variable: Variable) -> bool:
    """Return whether a bundle carries the values of a variable: of FMI 3.0 those of four types."""
    return variable.scalar is not None and (not variable.native or variable.native in _NATIVE)


def components_of(ports: Iterable[Port], kind: Kind) -> Collection[str]:
    """Return the components that ports of a kind lead to."""
    return {end.component for port in ports if port.kind == kind for end in port.ends}
