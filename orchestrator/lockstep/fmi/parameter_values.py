"""Check values of parameters and start values against the FMU: their names, types, units and ranges."""

import math
import re
from dataclasses import replace
from typing import cast

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.declared_units import accepted, conversion_from
from lockstep.fmi.model_description import Description, Variable
from lockstep.plain_values import plain_value
from lockstep.system.component import Component, Value
from lockstep.system.units import Unit, checked_conversion

_NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
_WITH_UNIT = re.compile(rf"\s*{_NUMBER}(?:\s+(\S.*?)|([^\W\d_].*?|[%°µ].*?))\s*")  # a unit such as 1/s follows a blank


def component_parameters(component: Component, description: Description) -> dict[str, Value]:
    """Return what the system file sets, in the FMU's types and units, or raise InputError."""
    values: dict[str, Value] = {}
    for name, value in component.parameters.items():
        what = f"{component.name}.{name}"
        variable = settable(component.name, name, description)
        if name in component.units and variable.type == "Real":
            gain, bias = checked_conversion(component.units[name], variable.unit, variable.relative, what)
            given = parse_value(value, in_unit(variable, component.units[name]), what)
            value = gain * float(given) + bias  # the FMU's range is in the FMU's unit
        values[name] = parse_value(value, variable, what)
    return values


def settable(component: str, name: str, description: Description) -> Variable:
    """Return the variable that a value may be given to, or raise InputError."""
    variable = description.variables.get(name)
    if variable is None:
        raise InputError(description.lacks(component, name, "parameter"))
    if variable.variability == "constant":
        raise InputError(f"{component}.{name}: is constant in the FMU; remove the value")
    if not variable.settable:
        what = f"{component}.{name}: is the FMU's {variable.causality}"
        raise InputError(f"{what}; only parameters and inputs can be set, and what has initial exact or approx")
    return variable


def in_unit(variable: Variable, unit: Unit | None) -> Variable:
    """Return a variable whose values are given in another unit: the FMU's range does not count for them."""
    return replace(variable, minimum=None, maximum=None, unit=unit or variable.unit)


def with_unit(text: object) -> tuple[str, str] | None:
    """Return number and unit of a text such as `0.1 arcsec`; None for what has no unit."""
    if not isinstance(text, str):
        return None
    try:
        float(text)
    except ValueError:
        found = _WITH_UNIT.fullmatch(text)
        return None if found is None else (found[1], found[2] or found[3])
    return None


def parse_value(value: Value, variable: Variable, what: str) -> Value:
    """Convert a value or its text to the declared type of a variable, or raise InputError.

    The text of a Real may end in a unit that converts to that of the variable: `0.1 arcsec`.
    """
    value = cast(Value, plain_value(value, what))
    wrong = InputError(f"{what}: {value!r} is not of its type {variable.native or variable.type}")
    parsed: Value
    if isinstance(value, list | dict):
        raise wrong
    match variable.type:
        case "String":
            if not isinstance(value, str):
                raise wrong
            if "\0" in value:
                raise InputError(f"{what}: {value!r} holds a null character, at which FMI ends a text; remove it")
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
                parsed = _real(value, variable, what) if variable.type == "Real" else _whole(value, variable)
            except InputError:
                raise
            except (ValueError, OverflowError):
                raise wrong from None
        case _:
            raise InputError(f"{what}: values of type {variable.type} cannot be set; remove it")
    if not math.isfinite(parsed):
        raise InputError(f"{what}: {value!r} must be finite")
    low, high = variable.minimum, variable.maximum
    if (low is not None and parsed < low) or (high is not None and parsed > high):
        limits = f"[{'-inf' if low is None else low}, {'inf' if high is None else high}]"
        raise InputError(f"{what}: {value!r} is outside {limits}{_unit_text(variable)}, which the FMU declares"
                         f"{_meant_in_display_unit(value, variable)}")  # fmt: skip
    return parsed


def _real(value: str | float | int, variable: Variable, what: str) -> float:
    """Return a number in the unit of a variable; raise ValueError for what is none."""
    given = with_unit(value)
    if given is None:
        return float(value)
    number, unit = given
    if variable.unit is None:
        raise InputError(f"{what}: {value!r} has a unit, and the variable has none; give the number alone")
    try:
        gain, bias = conversion_from(unit, variable.unit, variable.relative, variable.declared_units)
    except ValueError as error:
        raise InputError(f"{what} = {value!r}: unit {error}") from None
    return gain * float(number) + bias


def _unit_text(variable: Variable) -> str:
    return f" {variable.unit.name}" if variable.unit is not None and variable.unit.name not in ("", "1") else ""


def _meant_in_display_unit(value: Value, variable: Variable) -> str:
    """Return how a number is written that would be in the range if it was meant in the unit that tools show."""
    shown = variable.display_unit or ("%" if variable.unit is not None and variable.unit.name == "1" else "")
    if variable.unit is None or variable.type != "Real" or with_unit(value) or shown in ("", variable.unit.name):
        return ""
    if shown not in accepted(variable.unit, variable.declared_units):
        return ""
    try:
        parse_value(f"{value} {shown}", variable, "")
    except InputError:
        return ""
    return f"; if it is in {shown}, write {str(value).strip()}{shown}"


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
