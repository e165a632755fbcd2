"""Bind an adapter to the interface ports and the variables of the FMU, or refuse it by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase

from lockstep.adapter.conversion import EntryConversion, convert, flag
from lockstep.array_names import array_of, elements_of, range_names, split_element, split_range
from lockstep.errors import InputError, compact, siblings, suggestion
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.parameter_values import parse_value
from lockstep.results.signal_patterns import matching
from lockstep.system.adapter_file import Adapter, AdapterEntry
from lockstep.system.component import Value
from lockstep.system.unit_table import UNITS, gain_between

_OF_NUMBERS = ("unit", "scale", "offset", "sign", "order", "frame", "attitude")  # keys of entries
_OF_FLAGS = ("true", "false")

Variables = Mapping[str, Variable]  # interface ports of a component, or variables of an FMU, by name


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """An entry with its ports, FMU variables and arithmetic; `hold` is the port with the flag."""

    entry: AdapterEntry
    ports: tuple[Variable, ...]
    variables: tuple[Variable, ...]
    conversion: EntryConversion
    hold: Variable | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Binding:
    """A resolved adapter. `shown` is what the adapted component has: interface ports, and parameters of the FMU.

    The value references in it are new ones, counted from 0 over all types.
    """

    adapter: Adapter
    inputs: tuple[Bound, ...]
    outputs: tuple[Bound, ...]
    shown: Variables
    parameters: Mapping[int, Variable]  # of the FMU, by the new reference
    starts: Mapping[Variable, Value]  # of FMU variables: constants and parameters that the file gives
    substitutes: Mapping[str, float]  # by interface port


def bind(adapter: Adapter, ports: Variables, fmu: Variables) -> Binding:
    """Resolve names, numbers, units and types, or raise InputError. Every port of the FMU must be accounted for."""
    where = adapter.path.name
    bound = [_bound(entry, ports, fmu) for entry in adapter.entries]
    inputs = tuple(b for b in bound if b.entry.direction == "input")
    outputs = tuple(b for b in bound if b.entry.direction == "output")
    _once(((b, v) for b in inputs for v in b.variables), "is fed")
    _once(((b, v) for b in outputs for v in b.ports), "is made")
    starts = _starts(adapter, fmu, {v.name for b in inputs for v in b.variables})
    substitutes = _substitutes(adapter, ports, {v.name for b in outputs for v in b.ports})
    _complete(where, fmu, {v.name for b in bound for v in b.variables} | {v.name for v in starts}, adapter.ignore)
    served = [v for b in bound for v in b.ports] + [b.hold for b in bound if b.hold] + [ports[n] for n in substitutes]
    names = {v.name for v in served}
    shown = {v.name: replace(v, reference=k) for k, v in enumerate(v for v in ports.values() if v.name in names)}
    parameters = {}
    for variable in fmu.values():
        if variable.causality == "parameter" and variable.name not in shown:
            reference = len(shown)
            shown[variable.name] = replace(variable, reference=reference)
            parameters[reference] = variable
    return Binding(
        adapter=adapter,
        inputs=inputs,
        outputs=outputs,
        shown=shown,
        parameters=parameters,
        starts=starts,
        substitutes=substitutes,
    )


def adapted(binding: Binding, fmu: Description) -> Description:
    """Return the description of the adapted component: the FMU's, with the interface ports."""
    return replace(fmu, variables=binding.shown)


def _bound(entry: AdapterEntry, ports: Variables, fmu: Variables) -> Bound:
    mine = [ports[name] for text in entry.ports for name in _port_names(text, ports, entry)]
    count = len(mine)
    if entry.attitude is not None:
        if count not in (3, 4):
            there = compact(v.name for v in mine)
            raise InputError(
                f"{entry.location}: port = {there}: an attitude is an MRP of 3 or a quaternion of 4 elements"
            )
        count = 4 if entry.attitude == "quaternion" else 3
    names = _variable_names(entry, count, fmu)
    if len(names) != count:
        raise InputError(
            f"{entry.location}: variable has {len(names)} elements, and the port makes {count}; name as many"
        )
    variables = [_variable(name, entry, fmu) for name in names]
    for key, values in (("scale", entry.scale), ("offset", entry.offset), ("sign", entry.sign)):
        if len(values) not in (1, count):
            raise InputError(
                f"{entry.location}: {key} = {list(values)} must be one number or {count}, one for each element"
            )
    if entry.order is not None and len(entry.order) != count:
        raise InputError(f"{entry.location}: order = {list(entry.order)} must have {count} elements")
    if entry.frame is not None and count != 3:
        raise InputError(f"{entry.location}: frame turns vectors of 3 elements, and this has {count}")
    for variable in (*mine, *variables):
        if variable.scalar in (None, "String"):
            raise InputError(f"{entry.location}: {variable.name} is {variable.type}; numbers and Booleans are adapted")
    return Bound(
        entry=entry,
        ports=tuple(mine),
        variables=tuple(variables),
        conversion=_conversion(entry, mine, variables),
        hold=_hold(entry, ports),
    )


def _conversion(entry: AdapterEntry, ports: Sequence[Variable], variables: Sequence[Variable]) -> EntryConversion:
    if all(v.type == "Boolean" for v in ports):
        _refuse_idle(entry, _OF_NUMBERS, "on Booleans; true and false give the numbers of the FMU")
        return flag(entry)
    if any(v.type == "Boolean" for v in ports):
        raise InputError(f"{entry.location}: port mixes Booleans and numbers; make two entries of it")
    _refuse_idle(entry, _OF_FLAGS, "on numbers; scale, sign and offset convert them")
    gains, biases = [1.0] * len(variables), [0.0] * len(variables)
    if entry.attitude is None:  # an attitude has no unit
        order = entry.order or range(1, len(ports) + 1)
        for k, (position, variable) in enumerate(zip(order, variables, strict=True)):
            port = ports[position - 1]
            unit = UNITS[entry.unit] if entry.unit else variable.unit
            relative = port.relative and (variable.relative or entry.unit is not None)
            try:
                gains[k], biases[k] = gain_between(port.unit, unit, relative)
            except ValueError as error:
                raise InputError(f"{entry.location}: {port.name}: {error}; correct unit") from None
    return convert(entry, len(ports), len(variables), gains, biases)


def _refuse_idle(entry: AdapterEntry, keys: Sequence[str], reason: str) -> None:
    """Refuse keys of an entry that its arithmetic leaves out: a sign that is ignored is a wrong sign."""
    defaults = {item.name: item.default for item in fields(entry)}
    for key in keys:
        if (value := getattr(entry, key)) != defaults[key]:
            given = value if isinstance(value, tuple) else (value,)
            text = ", ".join(f"{one:g}" if isinstance(one, float) else str(one) for one in given)
            raise InputError(f"{entry.location}: {key} = {text}: has no effect {reason}")


def _hold(entry: AdapterEntry, ports: Variables) -> Variable | None:
    if entry.hold is None:
        return None
    held = ports.get(entry.hold)
    if held is None or held.type != "Boolean" or held.causality != "input":
        flags = [v.name for v in ports.values() if v.type == "Boolean" and v.causality == "input"]
        raise InputError(
            f"{entry.location}: hold = {entry.hold!r} must be a Boolean input of the interface: {compact(flags)}"
        )
    return held


def _port_names(text: str, ports: Variables, entry: AdapterEntry) -> list[str]:
    """Return the scalar names of a port, a whole array, or a range of one."""
    names = [v.name for v in ports.values() if v.causality == entry.direction]
    ranged = split_range(text)
    if ranged is not None:
        found = range_names(*ranged)
    elif text in ports:
        found = [text]
    else:
        found = elements_of(text, names)
    lacking = [name for name in found if name not in names]
    if lacking or not found:
        there = compact(siblings(text, names))
        raise InputError(f"{entry.location}: port = {text!r}: no such {entry.direction}; there are {there}"
                         f"{suggestion(text, sorted({array_of(n) for n in names}))}")  # fmt: skip
    return found


def _variable_names(entry: AdapterEntry, count: int, fmu: Variables) -> list[str]:
    pattern = entry.variables[0]
    grid = elements_of(pattern.removesuffix("[*]"), fmu) if pattern.endswith("[*]") else []
    of_matrix = bool(grid) and len(split_element(grid[0])[1]) > 1
    if of_matrix or "*" not in pattern:
        _refuse_idle(entry, ("index_base",), "here; it is the first number of an array written with a star")
        return grid if of_matrix else list(entry.variables)
    names = [pattern.replace("*", str(entry.index_base + k)) for k in range(count)]
    more = pattern.replace("*", str(entry.index_base + count))
    if more in fmu and names[-1] in fmu:
        raise InputError(f"{entry.location}: the FMU also has {more}, and the port makes {count} elements only")
    return names


def _variable(name: str, entry: AdapterEntry, fmu: Variables) -> Variable:
    variable = fmu.get(name)
    if variable is None or variable.causality != entry.direction:
        names = [v.name for v in fmu.values() if v.causality == entry.direction]
        remedy = "; is index_base right?" if "*" in entry.variables[0] else ""
        raise InputError(
            f"{entry.location}: variable = {name!r}: no such {entry.direction} of the FMU; "
            f"there are {compact(names)}{remedy or suggestion(name, names)}"
        )
    return variable


def _once(pairs: Iterable[tuple[Bound, Variable]], verb: str) -> None:
    seen: dict[str, Bound] = {}
    for bound, variable in pairs:
        if variable.name in seen:
            other = seen[variable.name].entry.location
            raise InputError(
                f"{bound.entry.location}: {variable.name} {verb} twice, also by {other}; remove one of them"
            )
        seen[variable.name] = bound


def _starts(adapter: Adapter, fmu: Variables, fed: set[str]) -> dict[Variable, Value]:
    starts: dict[Variable, Value] = {}
    for section, causality, table in (
        ("constants", "input", adapter.constants),
        ("parameters", "parameter", adapter.parameters),
    ):
        for name, value in table.items():
            what = f"{adapter.path.name}: {section}: {name}"
            variable = fmu.get(name)
            if variable is None or variable.causality != causality:
                names = [v.name for v in fmu.values() if v.causality == causality]
                raise InputError(f"{what} = {value!r}: no such {causality} of the FMU; there are {compact(names)}")
            if name in fed:
                raise InputError(f"{what} = {value!r}: an [[input]] feeds it already; remove one of them")
            starts[variable] = parse_value(value, variable, what)
    return starts


def _substitutes(adapter: Adapter, ports: Variables, made: set[str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for text, value in adapter.substitutes.items():
        what = f"{adapter.path.name}: substitutes: {text} = {value!r}"
        outputs = [v.name for v in ports.values() if v.causality == "output"]
        names = matching(text, outputs)
        if not names:
            raise InputError(f"{what}: no such output port; there are {compact(siblings(text, outputs))}")
        if made & set(names):
            raise InputError(f"{what}: an [[output]] makes it already; remove one of them")
        for name in names:
            if name in found:
                raise InputError(f"{what}: {name} has one already; remove one of them")
            found[name] = float(parse_value(value, ports[name], what))
    return found


def _complete(where: str, fmu: Variables, known: set[str], ignore: Sequence[str]) -> None:
    def loose(causality: str) -> list[str]:
        return [v.name for v in fmu.values() if v.causality == causality and v.name not in known]

    made = [v.name for v in fmu.values() if v.causality == "output"]
    for pattern in ignore:
        if not any(_matches(name, pattern) for name in made):
            raise InputError(f"{where}: ignore: {pattern!r}: no such output of the FMU; there are {compact(made)}"
                             f"{suggestion(pattern, made)}")  # fmt: skip
    inputs = loose("input")
    if inputs:
        raise InputError(f"{where}: nothing feeds {compact(inputs)} of the FMU; add an [[input]], or a constant")
    outputs = [name for name in loose("output") if not any(_matches(name, pattern) for pattern in ignore)]
    if outputs:
        raise InputError(f"{where}: nothing takes {compact(outputs)} of the FMU; add an [[output]], or ignore it")


def _matches(name: str, pattern: str) -> bool:
    return fnmatchcase(name, pattern.replace("[", "[[]"))
