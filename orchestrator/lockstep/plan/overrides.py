"""Values of parameters and start values: their names, types, units and ranges, checked against the FMU."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.system.component import Component, Value
from lockstep.system.system import System
from lockstep.system.transformation import End, transferred
from lockstep.system.units import checked_conversion

Override = Value | Sequence[Value]


def component_parameters(component: Component, description: Description) -> dict[str, Value]:
    """Return what the system file sets, in the FMU's types and units, or raise InputError."""
    values: dict[str, Value] = {}
    for name, value in component.parameters.items():
        what = f"{component.name}.{name}"
        variable = settable(component.name, name, description)
        if name in component.units and variable.type == "Real":
            gain, bias = checked_conversion(component.units[name], variable.unit, variable.relative, what)
            given = parse_value(value, replace(variable, minimum=None, maximum=None), what)
            value = gain * float(given) + bias  # the FMU's range is in the FMU's unit
        values[name] = parse_value(value, variable, what)
    return values


def settable(component: str, name: str, description: Description) -> Variable:
    """Return the variable that a value may be given to, or raise InputError."""
    variable = description.variables.get(name)
    if variable is None:
        raise InputError(description.lacks(component, name, "parameter"))
    if not variable.settable:
        what = f"{component}.{name}: is the FMU's {variable.causality}"
        raise InputError(f"{what}; only parameters and inputs can be set, and what has initial exact or approx")
    return variable


def resolve_overrides(
    key: str, value: Override, system: System, descriptions: Mapping[str, Description]
) -> list[tuple[str, Variable, Value]]:
    """Resolve an override: the components and variables that it sets, and to what, in the FMUs' units.

    The key is `component.variable`, or the name of a connector of the whole system that nothing feeds; its value is
    in the connector's unit. Raises InputError.
    """
    chosen = [one for one in system.inputs if one.name == key or re.fullmatch(re.escape(key) + r"\[\d+\]", one.name)]
    if not chosen:
        name, variables, values = resolve_override(key, value, system, descriptions)
        parsed = ((v, parse_value(item, v, f"{name}.{v.name}")) for v, item in zip(variables, values, strict=True))
        return [(name, variable, item) for variable, item in parsed]
    found = []
    for one, item in zip(chosen, _spread(key, value, [one.name for one in chosen], chosen[0].name == key), strict=True):
        for feed in one.feeds:
            variable = settable(feed.component, feed.input, descriptions[feed.component])
            what = f"{one.name} -> {feed.component}.{feed.input}"
            target = End(type=variable.type, unit=variable.unit, relative=variable.relative, items=variable.items)
            given = parse_value(item, replace(variable, minimum=None, maximum=None), what)
            sent = transferred(given, one.unit, feed.hops, target, what)[0]
            found.append((feed.component, variable, parse_value(sent, variable, what)))
    return found


def unfed(component: str, names: Sequence[str], system: System) -> str:
    """Say that inputs of a component are neither connected nor given a value, and what to do."""
    what = f"{component}.{compact(names)}: not connected and without a value"
    feeding = {one.name for one in system.inputs for f in one.feeds if f.component == component and f.input in names}
    if feeding:
        first = next(one.name for one in system.inputs if one.name in feeding)
        return f"{what}; the input {compact(sorted(feeding))} of the system feeds it: give --set {first}=VALUE"
    return f"{what}; connect it or give a value in the parameter bindings, or by --set {component}.{names[0]}=VALUE"


def resolve_override(
    key: str, value: Override, system: System, descriptions: Mapping[str, Description]
) -> tuple[str, list[Variable], list[Value]]:
    """Resolve an override; the name of an array takes a sequence, its values separated by commas, or one for all."""
    component, dot, name = key.partition(".")
    if not dot:
        inputs = [one.name for one in system.inputs]
        more = f"; inputs of the system are {compact(inputs)}{suggestion(key, inputs)}" if inputs else ""
        raise InputError(f"{key}: write component.parameter, for example {system.components[0].name}.{key}{more}")
    description = descriptions[system.component(component).name]
    elements = [v for v in description.variables if re.fullmatch(re.escape(name) + r"\[\d+(,\d+)*\]", v)]
    single = name in description.variables or not elements
    if single:
        elements = [name]
    values = _spread(key, value, elements, single)
    return component, [settable(component, element, description) for element in elements], values


def _spread(key: str, value: Override, elements: Sequence[str], single: bool) -> list[Value]:
    """Return a value for each element of an array, or the one of a `single` variable."""
    if single:
        if not isinstance(value, str) and hasattr(value, "__len__"):
            raise InputError(f"{key}: got {len(value)} values for one parameter")
        return [value]
    if isinstance(value, str):
        value = value.split(",")
    values: list[Value] = [*value] if hasattr(value, "__iter__") else [value]
    if len(values) == 1:
        values *= len(elements)
    if len(values) != len(elements):
        raise InputError(f"{key}: got {len(values)} values for {compact(elements)}")
    return values


def parse_value(value: Value, variable: Variable, what: str) -> Value:
    """Convert a value or its text to the declared type of a variable, or raise InputError."""
    if hasattr(value, "item"):
        value = cast(Value, value.item())  # a numpy scalar
    wrong = InputError(f"{what}: {value!r} is not of its type {variable.native or variable.type}")
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
        case "Enumeration":
            return _item(value, variable, what)
        case "Real" | "Integer":
            if isinstance(value, bool):
                raise wrong
            try:
                parsed = float(value) if variable.type == "Real" else _whole(value, variable)
            except ValueError:
                raise wrong from None
        case _:
            raise InputError(f"{what}: values of type {variable.type} cannot be set; remove it")
    if not math.isfinite(parsed):
        raise InputError(f"{what}: {value!r} must be finite")
    low, high = variable.minimum, variable.maximum
    if (low is not None and parsed < low) or (high is not None and parsed > high):
        limits = f"[{'-inf' if low is None else low}, {'inf' if high is None else high}]"
        raise InputError(f"{what}: {value!r} is outside {limits}, which the FMU declares")
    return parsed


def _item(value: Value, variable: Variable, what: str) -> int:
    """Return the number of an Enumeration's item, given by its name or number."""
    items = variable.items
    if isinstance(value, str) and value in items:
        return items[value]
    wrong = f"{what}: {value!r} is no item of its Enumeration; there are {compact(items)}"
    try:
        number = _whole(value, variable)
    except ValueError:
        raise InputError(wrong + suggestion(str(value), items)) from None
    if isinstance(value, bool) or (items and number not in items.values()):
        raise InputError(wrong)
    return number


def _whole(value: str | float | int, variable: Variable) -> int:
    if isinstance(value, float) and not value.is_integer():
        raise ValueError
    whole = int(value)
    low, high = variable.limits
    if not low <= whole <= high:
        raise ValueError
    return whole
