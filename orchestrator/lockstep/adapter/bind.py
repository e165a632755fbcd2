"""Resolve an adapter against the ports of ours and the variables of the FMU, or refuse it by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

from lockstep.adapter.conversion import Conversion, convert, flag
from lockstep.array_names import array_of, elements_of, range_names, split_element, split_range
from lockstep.errors import InputError, compact, siblings, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.parameter_values import parse_value
from lockstep.results.signal_patterns import matching
from lockstep.system.adapter_file import Adapter, Entry
from lockstep.system.component import Value
from lockstep.system.unit_table import UNITS, gain_between

Ports = Mapping[str, Variable]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """An entry with its variables and its arithmetic; `hold` is the place of the flag among the ports of ours."""

    entry: Entry
    ours: tuple[Variable, ...]
    theirs: tuple[Variable, ...]
    conversion: Conversion
    hold: Variable | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Binding:
    """A resolved adapter. `variables` are what the adapted component shows: ports of ours, parameters of theirs.

    Their value references are new ones, counted from 0 over all types.
    """

    adapter: Adapter
    inputs: tuple[Bound, ...]
    outputs: tuple[Bound, ...]
    variables: Mapping[str, Variable]
    parameters: Mapping[int, Variable]  # of theirs, by the new reference
    starts: Mapping[Variable, Value]  # of theirs: constants and parameters that the file gives
    substitutes: Mapping[str, float]  # by port of ours


def bind(adapter: Adapter, ours: Ports, theirs: Ports) -> Binding:
    """Resolve names, numbers, units and types, or raise InputError. Every port of theirs must be accounted for."""
    where = adapter.path.name
    bound = [_bound(entry, ours, theirs) for entry in adapter.entries]
    inputs = tuple(b for b in bound if b.entry.direction == "input")
    outputs = tuple(b for b in bound if b.entry.direction == "output")
    _once(((b, v) for b in inputs for v in b.theirs), "is fed")
    _once(((b, v) for b in outputs for v in b.ours), "is made")
    starts = _starts(adapter, theirs, {v.name for b in inputs for v in b.theirs})
    substitutes = _substitutes(adapter, ours, {v.name for b in outputs for v in b.ours})
    _complete(where, theirs, {v.name for b in bound for v in b.theirs} | {v.name for v in starts}, adapter.ignore)
    shown = [v for b in bound for v in b.ours] + [b.hold for b in bound if b.hold] + [ours[n] for n in substitutes]
    names = {v.name: v for v in shown}
    variables = {
        v.name: replace(v, reference=number) for number, v in enumerate(v for v in ours.values() if v.name in names)
    }
    parameters = {}
    for variable in theirs.values():
        if variable.causality == "parameter" and variable.name not in variables:
            reference = len(variables)
            variables[variable.name] = replace(variable, reference=reference)
            parameters[reference] = variable
    return Binding(
        adapter=adapter,
        inputs=inputs,
        outputs=outputs,
        variables=variables,
        parameters=parameters,
        starts=starts,
        substitutes=substitutes,
    )


def adapted(binding: Binding, theirs: Description) -> Description:
    """Return the description of the adapted component: the FMU's, with the ports of ours."""
    return replace(theirs, variables=binding.variables)


def _bound(entry: Entry, ours: Ports, theirs: Ports) -> Bound:
    mine = [ours[name] for text in entry.ours for name in _expand_ours(text, ours, entry)]
    count = len(mine)
    if entry.attitude is not None:
        if count not in (3, 4):
            there = compact(v.name for v in mine)
            raise InputError(f"{entry.place}: ours = {there}: an attitude is an MRP of 3 or a quaternion of 4 elements")
        count = 4 if entry.attitude == "quaternion" else 3
    names = _expand_theirs(entry, count, theirs)
    if len(names) != count:
        raise InputError(f"{entry.place}: theirs has {len(names)} elements, and ours makes {count}; name as many")
    other = [_theirs(name, entry, theirs) for name in names]
    for key, values in (("scale", entry.scale), ("offset", entry.offset), ("sign", entry.sign)):
        if len(values) not in (1, count):
            raise InputError(
                f"{entry.place}: {key} = {list(values)} must be one number or {count}, one for each element"
            )
    if entry.order is not None and len(entry.order) != count:
        raise InputError(f"{entry.place}: order = {list(entry.order)} must have {count} elements")
    if entry.frame is not None and count != 3:
        raise InputError(f"{entry.place}: frame turns vectors of 3 elements, and this has {count}")
    for variable in (*mine, *other):
        if variable.scalar in (None, "String"):
            raise InputError(f"{entry.place}: {variable.name} is {variable.type}; numbers and Booleans are adapted")
    return Bound(
        entry=entry,
        ours=tuple(mine),
        theirs=tuple(other),
        conversion=_conversion(entry, mine, other),
        hold=_hold(entry, ours),
    )


def _conversion(entry: Entry, ours: Sequence[Variable], theirs: Sequence[Variable]) -> Conversion:
    if all(v.type == "Boolean" for v in ours):
        return flag(entry)
    if any(v.type == "Boolean" for v in ours):
        raise InputError(f"{entry.place}: ours mixes Booleans and numbers; make two entries of it")
    gains, biases = [1.0] * len(theirs), [0.0] * len(theirs)
    if entry.attitude is None:  # an attitude has no unit
        order = entry.order or range(1, len(ours) + 1)
        for k, (position, their) in enumerate(zip(order, theirs, strict=True)):
            our = ours[position - 1]
            unit = UNITS[entry.unit] if entry.unit else their.unit
            try:
                gains[k], biases[k] = gain_between(our.unit, unit)
            except ValueError as error:
                raise InputError(f"{entry.place}: {our.name}: {error}; correct unit") from None
    return convert(entry, len(ours), len(theirs), gains, biases)


def _hold(entry: Entry, ours: Ports) -> Variable | None:
    if entry.hold is None:
        return None
    held = ours.get(entry.hold)
    if held is None or held.type != "Boolean" or held.causality != "input":
        flags = [v.name for v in ours.values() if v.type == "Boolean" and v.causality == "input"]
        raise InputError(f"{entry.place}: hold = {entry.hold!r} must be a Boolean input of ours: {compact(flags)}")
    return held


def _expand_ours(text: str, ours: Ports, entry: Entry) -> list[str]:
    """Return the scalar names of a port, a whole array, or a range of one."""
    names = [v.name for v in ours.values() if v.causality == entry.direction]
    ranged = split_range(text)
    if ranged is not None:
        found = range_names(*ranged)
    elif text in ours:
        found = [text]
    else:
        found = elements_of(text, names)
    lacking = [name for name in found if name not in names]
    if lacking or not found:
        there = compact(siblings(text, names))
        raise InputError(f"{entry.place}: ours = {text!r}: no such {entry.direction}; there are {there}"
                         f"{suggestion(text, sorted({array_of(n) for n in names}))}")  # fmt: skip
    return found


def _expand_theirs(entry: Entry, count: int, theirs: Ports) -> list[str]:
    if len(entry.theirs) > 1 or "*" not in entry.theirs[0]:
        return list(entry.theirs)
    pattern = entry.theirs[0]
    if pattern.endswith("[*]"):
        grid = elements_of(pattern.removesuffix("[*]"), theirs)
        if grid and len(split_element(grid[0])[1]) > 1:
            return grid
    names = [pattern.replace("*", str(entry.index_base + k)) for k in range(count)]
    more = pattern.replace("*", str(entry.index_base + count))
    if more in theirs and names[-1] in theirs:
        raise InputError(f"{entry.place}: the FMU also has {more}, and ours makes {count} elements only")
    return names


def _theirs(name: str, entry: Entry, theirs: Ports) -> Variable:
    variable = theirs.get(name)
    if variable is None or variable.causality != entry.direction:
        names = [v.name for v in theirs.values() if v.causality == entry.direction]
        remedy = "; is index_base right?" if "*" in entry.theirs[0] else ""
        raise InputError(
            f"{entry.place}: theirs = {name!r}: no such {entry.direction} of the FMU; "
            f"there are {compact(names)}{remedy or suggestion(name, names)}"
        )
    return variable


def _once(pairs: Iterable[tuple[Bound, Variable]], verb: str) -> None:
    seen: dict[str, Bound] = {}
    for bound, variable in pairs:
        if variable.name in seen:
            other = seen[variable.name].entry.place
            raise InputError(f"{bound.entry.place}: {variable.name} {verb} twice, also by {other}; remove one of them")
        seen[variable.name] = bound


def _starts(adapter: Adapter, theirs: Ports, fed: set[str]) -> dict[Variable, Value]:
    starts: dict[Variable, Value] = {}
    for section, causality, table in (
        ("constants", "input", adapter.constants),
        ("parameters", "parameter", adapter.parameters),
    ):
        for name, value in table.items():
            what = f"{adapter.path.name}: {section}: {name}"
            variable = theirs.get(name)
            if variable is None or variable.causality != causality:
                names = [v.name for v in theirs.values() if v.causality == causality]
                raise InputError(f"{what} = {value!r}: no such {causality} of the FMU; there are {compact(names)}")
            if name in fed:
                raise InputError(f"{what} = {value!r}: an [[input]] feeds it already; remove one of them")
            starts[variable] = parse_value(value, variable, what)
    return starts


def _substitutes(adapter: Adapter, ours: Ports, made: set[str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for text, value in adapter.substitutes.items():
        what = f"{adapter.path.name}: substitutes: {text} = {value!r}"
        outputs = [v.name for v in ours.values() if v.causality == "output"]
        names = matching(text, outputs)
        if not names:
            raise InputError(f"{what}: no such output of ours; there are {compact(siblings(text, outputs))}")
        if made & set(names):
            raise InputError(f"{what}: an [[output]] makes it already; remove one of them")
        for name in names:
            found[name] = float(parse_value(value, ours[name], what))
    return found


def _complete(where: str, theirs: Ports, known: set[str], ignore: Sequence[str]) -> None:
    def loose(causality: str) -> list[str]:
        return [v.name for v in theirs.values() if v.causality == causality and v.name not in known]

    inputs = loose("input")
    if inputs:
        raise InputError(f"{where}: nothing feeds {compact(inputs)} of the FMU; add an [[input]], or a constant")
    outputs = [name for name in loose("output") if not any(_matches(name, pattern) for pattern in ignore)]
    if outputs:
        raise InputError(f"{where}: nothing takes {compact(outputs)} of the FMU; add an [[output]], or ignore it")


def _matches(name: str, pattern: str) -> bool:
    return fnmatchcase(name, pattern.replace("[", "[[]"))
