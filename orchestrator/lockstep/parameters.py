"""Values of parameters and start values: their names, types, units and ranges, checked against the FMU."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

from lockstep.errors import InputError, compact
from lockstep.fmu import Description, Variable
from lockstep.system import Component, System, Value
from lockstep.units import checked_conversion

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
    if variable.causality not in ("parameter", "input"):
        raise InputError(
            f"{component}.{name}: is the FMU's {variable.causality}; only parameters and inputs can be set"
        )
    return variable


def resolve_override(
    key: str, value: Override, system: System, descriptions: Mapping[str, Description]
) -> tuple[str, list[Variable], list[Value]]:
    """Resolve an override; the name of an array takes a sequence, its values separated by commas, or one for all."""
    component, dot, name = key.partition(".")
    if not dot:
        raise InputError(f"{key}: write component.parameter, for example {system.components[0].name}.{key}")
    description = descriptions[system.component(component).name]
    elements = [v for v in description.variables if re.fullmatch(re.escape(name) + r"\[\d+\]", v)]
    if name in description.variables or not elements:
        if not isinstance(value, str) and hasattr(value, "__len__"):
            raise InputError(f"{key}: got {len(value)} values for one parameter")
        return component, [settable(component, name, description)], [value]
    if isinstance(value, str):
        value = value.split(",")
    values: list[Value] = [*value] if hasattr(value, "__iter__") else [value]
    if len(values) == 1:
        values *= len(elements)
    if len(values) != len(elements):
        raise InputError(f"{key}: got {len(values)} values for {compact(elements)}")
    return component, [settable(component, element, description) for element in elements], values


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
