"""Check a system against the model descriptions of its FMUs; resolve names, types and units."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

from lockstep.errors import InputError, compact, siblings, suggestion
from lockstep.fmu import Description, Variable
from lockstep.slave import SCALARS, Scalar
from lockstep.system import Component, Connection, System, Value
from lockstep.units import Unit, conversion

Override = Value | Sequence[Value]


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """All scalars of one type from one producer to one consumer with one delay, by value reference.

    A target receives gain * source + bias; only Reals have other gains and biases than 1 and 0.
    """

    producer: str
    consumer: str
    delay: int  # [ticks]
    scalar: Scalar
    sources: tuple[int, ...]
    targets: tuple[int, ...]
    gains: tuple[float, ...]
    biases: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """One output to record."""

    component: str
    variable: Variable

    @property
    def name(self) -> str:
        """The name of its column."""
        return f"{self.component}.{self.variable.name}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """A checked system. `parameters` are the values set, in the FMUs' units, by component and variable."""

    links: tuple[Link, ...]
    parameters: Mapping[str, Mapping[str, Value]]


def wire(system: System, descriptions: Mapping[str, Description], overrides: Mapping[str, Override]) -> Wiring:
    """Check everything that can be checked without running, or raise InputError."""
    for component in system.components:
        _check_connectors(component, descriptions[component.name])
    _check_single_instances(system, descriptions)
    parameters = {
        component.name: _component_parameters(component, descriptions[component.name])
        for component in system.components
    }
    for key, value in overrides.items():
        name, variables, values = _override(key, value, system, descriptions)
        for variable, item in zip(variables, values, strict=True):
            parameters[name][variable.name] = parse_value(item, variable, f"{name}.{variable.name}")
    links = _links(system, descriptions)
    _check_fed(system, descriptions, parameters)
    return Wiring(links=links, parameters=parameters)


def select(system: System, descriptions: Mapping[str, Description], patterns: Iterable[str]) -> tuple[Signal, ...]:
    """Return the outputs that match any pattern, in the order of the system.

    In a pattern `*` and `?` are wild, brackets are plain; `all` is every output; the name of an array is
    all its elements.
    """
    outputs = [
        Signal(component=c.name, variable=variable)
        for c in system.components
        for variable in descriptions[c.name].variables.values()
        if variable.causality == "output" and variable.type in SCALARS
    ]
    names = [signal.name for signal in outputs]
    chosen: set[str] = set()
    for pattern in patterns:
        if pattern == "all":
            chosen.update(names)
            continue
        expression = "".join({"*": ".*", "?": "."}.get(letter, re.escape(letter)) for letter in pattern)
        rule = re.compile(rf"{expression}(\[\d+\])*")
        matched = [name for name in names if rule.fullmatch(name)]
        if not matched:
            raise InputError(
                f"record {pattern!r} matches no output; there are {compact(names)}{suggestion(pattern, names)}"
            )
        chosen.update(matched)
    return tuple(signal for signal in outputs if signal.name in chosen)


def parse_value(value: Value, variable: Variable, what: str) -> Value:
    """Convert a value or its text to the declared type of a variable, or raise InputError."""
    if hasattr(value, "item"):
        value = cast(Value, value.item())  # a numpy scalar
    wrong = InputError(f"{what}: {value!r} is not of its type {variable.type}")
    parsed: Value
    match variable.type:
        case "String":
            if not isinstance(value, str):
                raise wrong
            return value
        case "Boolean":
            if isinstance(value, str) and value.strip().lower() in ("true", "false", "1", "0"):
                return value.strip().lower() in ("true", "1")
            if not isinstance(value, bool):
                raise InputError(f"{wrong}; write true or false")
            return value
        case "Real" | "Integer":
            if isinstance(value, bool):
                raise wrong
            try:
                parsed = float(value) if variable.type == "Real" else _whole(value)
            except ValueError:
                raise wrong from None
        case _:
            raise InputError(f"{what}: type {variable.type} cannot be set; only Real, Integer, Boolean and String can")
    if not math.isfinite(parsed):
        raise InputError(f"{what}: {value!r} must be finite")
    low, high = variable.minimum, variable.maximum
    if (low is not None and parsed < low) or (high is not None and parsed > high):
        limits = f"[{'-inf' if low is None else low}, {'inf' if high is None else high}]"
        raise InputError(f"{what}: {value!r} is outside {limits}, which the FMU declares")
    return parsed


def _whole(value: str | float | int) -> int:
    if isinstance(value, float) and not value.is_integer():
        raise ValueError
    whole = int(value)
    if not -(2**31) <= whole < 2**31:  # fmi2Integer
        raise ValueError
    return whole


def _check_connectors(component: Component, description: Description) -> None:
    for port in component.connectors or ():
        what = f"{component.name}.{port.name}"
        variable = description.variables.get(port.name)
        if variable is None:
            raise InputError(_no_such(component.name, port.name, port.kind, description))
        if variable.causality != port.kind:
            raise InputError(f"{what}: declared as {port.kind}, but it is the FMU's {variable.causality}")
        if port.type is not None and variable.type != port.type:
            raise InputError(f"{what}: declared as {port.type}, but the FMU says {variable.type}")
        declared = component.units.get(port.name)
        if declared is None or variable.unit is None or declared.name == variable.unit.name:
            continue
        if _convert(declared, variable.unit, False, what) != (1.0, 0.0):
            raise InputError(f"{what}: declared in '{declared.name}', but the FMU's unit is '{variable.unit.name}'")


def _check_single_instances(system: System, descriptions: Mapping[str, Description]) -> None:
    seen: dict[str, str] = {}
    for component in system.components:
        description = descriptions[component.name]
        first = seen.setdefault(description.sha256, component.name)
        if first != component.name and description.once_per_process:
            raise InputError(f"{component.name}: the FMU allows one instance per process, and {first} is it already")


def _component_parameters(component: Component, description: Description) -> dict[str, Value]:
    values: dict[str, Value] = {}
    for name, value in component.parameters.items():
        what = f"{component.name}.{name}"
        variable = _settable(component.name, name, description)
        parsed = parse_value(value, variable, what)
        if name in component.units and variable.type == "Real":
            gain, bias = _convert(component.units[name], variable.unit, variable.relative, what)
            parsed = gain * float(parsed) + bias
        values[name] = parsed
    return values


def _settable(component: str, name: str, description: Description) -> Variable:
    variable = description.variables.get(name)
    if variable is None:
        raise InputError(_no_such(component, name, "parameter", description))
    if variable.causality not in ("parameter", "input"):
        raise InputError(
            f"{component}.{name}: is the FMU's {variable.causality}; only parameters and inputs can be set"
        )
    return variable


def _override(
    key: str, value: Override, system: System, descriptions: Mapping[str, Description]
) -> tuple[str, list[Variable], list[Value]]:
    """Resolve an override; the name of an array takes a sequence, or its values separated by commas."""
    component, dot, name = key.partition(".")
    if not dot:
        raise InputError(f"{key}: write component.parameter, for example {system.components[0].name}.{key}")
    description = descriptions[system.component(component).name]
    elements = [v for v in description.variables if re.fullmatch(re.escape(name) + r"\[\d+\]", v)]
    if name in description.variables or not elements:
        if not isinstance(value, str) and hasattr(value, "__len__"):
            raise InputError(f"{key}: got {len(value)} values for one parameter")
        return component, [_settable(component, name, description)], [value]
    if isinstance(value, str):
        value = value.split(",")
    values = list(cast(Iterable[Value], value)) if hasattr(value, "__iter__") else [value]
    if len(values) != len(elements):
        raise InputError(f"{key}: got {len(values)} value{'' if len(values) == 1 else 's'} for {compact(elements)}")
    return component, [_settable(component, element, description) for element in elements], values


def _links(system: System, descriptions: Mapping[str, Description]) -> tuple[Link, ...]:
    groups: dict[tuple[str, str, int, Scalar], list[tuple[int, int, float, float]]] = {}
    for connection in system.connections:
        source = _port(connection, "output", descriptions)
        target = _port(connection, "input", descriptions)
        if source.type != target.type:
            raise InputError(f"{connection}: connects {source.type} to {target.type}; types must be equal")
        if source.type not in SCALARS:
            raise InputError(f"{connection}: type {source.type} cannot be connected; use one of {', '.join(SCALARS)}")
        gain, bias = _gain(connection, source, target, system)
        key = (connection.from_component, connection.to_component, connection.delay, source.type)
        groups.setdefault(key, []).append((source.reference, target.reference, gain, bias))
    return tuple(
        Link(
            producer=key[0],
            consumer=key[1],
            delay=key[2],
            scalar=key[3],
            sources=tuple(entry[0] for entry in entries),
            targets=tuple(entry[1] for entry in entries),
            gains=tuple(entry[2] for entry in entries),
            biases=tuple(entry[3] for entry in entries),
        )
        for key, entries in groups.items()
    )


def _port(connection: Connection, causality: str, descriptions: Mapping[str, Description]) -> Variable:
    outward = causality == "output"
    component = connection.from_component if outward else connection.to_component
    name = connection.output if outward else connection.input
    description = descriptions[component]
    variable = description.variables.get(name)
    if variable is None:
        raise InputError(_no_such(component, name, causality, description))
    if variable.causality != causality:
        raise InputError(
            f"{connection}: {component}.{name} is the FMU's {variable.causality}, an {causality} is needed"
        )
    return variable


def _gain(connection: Connection, source: Variable, target: Variable, system: System) -> tuple[float, float]:
    gain, bias = 1.0, 0.0
    if source.type != "Real":
        if (connection.factor, connection.offset) != (1.0, 0.0):
            raise InputError(f"{connection}: a linear transformation of {source.type} is not supported")
        return gain, bias
    if connection.convert_units:
        start = source.unit or system.component(connection.from_component).units.get(source.name)
        end = target.unit or system.component(connection.to_component).units.get(target.name)
        gain, bias = _convert(start, end, source.relative and target.relative, str(connection))
    # SSP: units are converted first, the transformation works on the converted value
    return connection.factor * gain, connection.factor * bias + connection.offset


def _convert(source: Unit | None, target: Unit | None, relative: bool, what: str) -> tuple[float, float]:
    try:
        return conversion(source, target, relative)
    except ValueError as error:
        raise InputError(f"{what}: {error}; correct a unit, or set suppressUnitConversion") from None


def _check_fed(
    system: System, descriptions: Mapping[str, Description], parameters: Mapping[str, Mapping[str, Value]]
) -> None:
    fed = {(connection.to_component, connection.input) for connection in system.connections}
    for component in system.components:
        inputs = descriptions[component.name].names("input")
        loose = [n for n in inputs if (component.name, n) not in fed and n not in parameters[component.name]]
        if loose:
            raise InputError(
                f"{component.name}.{compact(loose)}: not connected and without a value; "
                "connect it or give a value in the parameter bindings"
            )


def _no_such(component: str, name: str, kind: str, description: Description) -> str:
    # an input may be given a start value like a parameter, so both are offered
    names = description.names(*(("parameter", "input") if kind == "parameter" else (kind,)))
    return (
        f"{component}.{name}: no such {kind}; {component} has {compact(siblings(name, names))}{suggestion(name, names)}"
    )
