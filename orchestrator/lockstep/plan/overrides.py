"""Resolve overrides, as `--set` gives them, to variables of FMUs and values in their units."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, cast

from lockstep.array_names import elements_of
from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.parameter_values import in_unit, parse_value, settable, with_unit
from lockstep.plain_values import plain_value
from lockstep.shadow.component import described
from lockstep.system.component import Value
from lockstep.system.system import System
from lockstep.system.transformation import transferred

Override = Value | Sequence[Value]


def resolve_overrides(
    key: str, value: Override, system: System, descriptions: Mapping[str, Description]
) -> list[tuple[str, Variable, Value]]:
    """Resolve an override: the components and variables that it sets, and to what, in the FMUs' units.

    The key is `component.variable`, or the name of a connector of the whole system that nothing feeds; its value is
    in the connector's unit. Raises InputError.
    """
    value = plain_value(value, key)
    inputs = {one.name: one for one in system.inputs}
    chosen = [inputs[name] for name in ([key] if key in inputs else elements_of(key, inputs))]
    if not chosen:
        name, variables, values = resolve_override(key, value, system, descriptions)
        parsed = ((v, parse_value(item, v, f"{name}.{v.name}")) for v, item in zip(variables, values, strict=True))
        return [(name, variable, item) for variable, item in parsed]
    found = []
    for one, item in zip(chosen, _spread(key, value, [one.name for one in chosen], chosen[0].name == key), strict=True):
        for feed in one.feeds:
            variable = settable(feed.component, feed.input, descriptions[feed.component])
            what = f"{one.name} -> {feed.component}.{feed.input}"
            target = variable.end(variable.unit)
            given = parse_value(item, in_unit(variable, one.unit), what)
            sent = transferred(given, one.unit, feed.hops, target, what)[0]
            found.append((feed.component, variable, parse_value(sent, variable, what)))
    return found


def refuse_unknown(overrides: Mapping[str, Override], system: System) -> None:
    """Raise InputError for an override of a variable that is not there, or with a value that it does not take."""
    descriptions = {component.name: described(component) for component in system.components}
    for key, value in overrides.items():
        resolve_overrides(key, value, system, descriptions)


def unfed(component: str, names: Sequence[str], system: System) -> str:
    """Return a message for inputs of a component that are neither connected nor have a value."""
    what = f"{component}.{compact(names)}: not connected and without a value"
    feeding = {one.name for one in system.inputs for f in one.feeds if f.component == component and f.input in names}
    if feeding:
        first = next(one.name for one in system.inputs if one.name in feeding)
        return f"{what}; the input {compact(sorted(feeding))} of the system feeds it: give --set {first}=VALUE"
    return f"{what}; connect it or give a value in the parameter bindings, or by --set {component}.{names[0]}=VALUE"


def resolve_override(
    key: str, value: Override, system: System, descriptions: Mapping[str, Description]
) -> tuple[str, list[Variable], list[Value]]:
    """Resolve an override; the name of an array takes one value for all, or one for each element.

    The values are a sequence, or a text with commas, in brackets or not, in the order of the indices, the last one
    running fastest.
    """
    component, dot, name = key.partition(".")
    if not dot:
        inputs = [one.name for one in system.inputs]
        more = f"; inputs of the system are {compact(inputs)}{suggestion(key, inputs)}" if inputs else ""
        example = f"{system.components[0].name}.{key or 'seed'}"
        raise InputError(
            f"{key or '(empty)'}: no parameter to set; write component.parameter, for example {example}{more}"
        )
    description = descriptions[system.component(component).name]
    elements = elements_of(name, description.variables)
    single = name in description.variables or not elements
    if single:
        elements = [name]
    values = _spread(key, value, elements, single)
    return component, [settable(component, element, description) for element in elements], values


def _without_brackets(text: str) -> str:
    """Return the inside of a list written in brackets, such as [1, 2] or [[1, 2], [3, 4]]; other texts as they are."""
    inside = text.strip()
    if not (inside.startswith("[") and inside.endswith("]")):
        return text
    inside = inside[1:-1].strip()
    return re.sub(r"\]\s*,\s*\[", ",", inside[1:-1]) if inside.startswith("[") and inside.endswith("]") else inside


def _spread(key: str, value: Override, elements: Sequence[str], single: bool) -> list[Value]:
    """Return a value for each element of an array, or the one of a `single` variable."""
    if single:
        if isinstance(value, list):
            raise InputError(f"{key}: got {len(value)} values for one parameter")
        return [cast(Value, value)]
    if isinstance(value, str):
        value = _without_brackets(value).split(",")
    values: list[Value] = _flat(value) if isinstance(value, list) else [cast(Value, value)]
    _refuse_mixed(key, values)
    if len(values) == 1:
        values *= len(elements)
    if len(values) != len(elements):
        raise InputError(f"{key}: got {len(values)} values for {compact(elements)}")
    return values


def _refuse_mixed(key: str, values: Sequence[Value]) -> None:
    """Refuse a list of which some numbers have a unit: 1,2,3deg would be taken as 1 rad, 2 rad, 3 deg."""
    units = [given[1] for given in map(with_unit, values) if given is not None]
    bare = [value for value in values if with_unit(value) is None and not _is_zero(value)]
    if units and bare:
        raise InputError(f"{key}: {bare[0]!r} has no unit, and others have {units[0]}; give each number its unit")


def _is_zero(value: Value) -> bool:
    try:
        return float(value) == 0.0
    except ValueError:
        return False


def _flat(values: Sequence[Any]) -> list[Value]:
    """Return the elements of lists in lists, the last index running fastest."""
    return [item for value in values for item in (_flat(value) if isinstance(value, list) else [value])]
