"""Find the targets of a fault: connections by patterns on their ends, tunable parameters, unconnected inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from lockstep.array_names import array_of, range_names, split_range
from lockstep.errors import InputError, compact, siblings, suggestion
from lockstep.faults.scenario import Fault
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.slave import Scalar
from lockstep.results.signal_patterns import matching
from lockstep.system.system import Connection, System


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """One scalar that a fault acts on; without a connection it is a parameter or an unconnected input."""

    component: str
    variable: Variable
    scalar: Scalar
    connection: Connection | None = None

    @property
    def name(self) -> str:
        """The name of the parameter, or of the input."""
        return f"{self.component}.{self.variable.name}"


def fed_inputs(
    patterns: Sequence[str], key: str, fault: Fault, system: System, descriptions: Mapping[str, Description]
) -> list[Target]:
    """Return the connections that match the patterns, each once, in the order of the patterns and of the system."""
    found: dict[str, Target] = {}
    for pattern in patterns:
        what = f"{fault.location}: {key} = {pattern!r}"
        start, arrow, end = (part.strip() for part in pattern.rpartition("->"))
        connections: Iterable[Connection] = system.connections
        if arrow:
            sources = _matched(start, [_source(c) for c in connections], what, "output that feeds an input")
            connections = [c for c in connections if _source(c) in sources]
        else:
            _check_is_fed(end, what, system, descriptions)
        by_input = {f"{c.to_component}.{c.input}": c for c in connections}
        for name in _matched(end, list(by_input), what, "connected input"):
            connection = by_input[name]
            variable = descriptions[connection.to_component].variables[connection.input]
            found[name] = _target(connection.to_component, variable, what, connection)
    return list(found.values())


def tunables(fault: Fault, system: System, descriptions: Mapping[str, Description]) -> list[Target]:
    """Return the parameters and unconnected inputs that a fault names."""
    fed = {(c.to_component, c.input) for c in system.connections}
    everything = {f"{c.name}.{v.name}": (c.name, v) for c in system.components
                  for v in descriptions[c.name].variables.values()}  # fmt: skip
    free = [
        name
        for name, (component, v) in everything.items()
        if (v.causality == "parameter" and v.variability == "tunable")
        or (v.causality == "input" and (component, v.name) not in fed)
    ]
    found: dict[str, Target] = {}
    for pattern in fault.parameters:
        what = f"{fault.location}: parameter = {pattern!r}"
        for each in _expanded(pattern, what):
            matched = matching(each, free)
            if not matched:
                why = _why_not(matching(each, everything), everything, fed)
                raise InputError(f"{what}: {why}; a run can change {compact(free)}{suggestion(each, free)}")
            for name in matched:
                component, variable = everything[name]
                found[name] = _target(component, variable, what)
    return list(found.values())


def _why_not(names: Sequence[str], everything: Mapping[str, tuple[str, Variable]], fed: set[tuple[str, str]]) -> str:
    if not names:
        return "no such parameter"
    component, variable = everything[names[0]]
    if (component, variable.name) in fed:
        return f"{names[0]} is connected: write connection instead"
    if variable.causality == "parameter":
        return f"{names[0]} is not tunable but {variable.variability}: the FMU takes it before the run only"
    return f"{names[0]} is the FMU's {variable.causality}, not a parameter"


def _target(component: str, variable: Variable, what: str, connection: Connection | None = None) -> Target:
    scalar = variable.scalar
    if scalar is None:
        raise InputError(f"{what}: {component}.{variable.name} is {variable.type}, on which no fault acts")
    return Target(component=component, variable=variable, scalar=scalar, connection=connection)


def _source(connection: Connection) -> str:
    return f"{connection.from_component}.{connection.output}"


def _check_is_fed(pattern: str, what: str, system: System, descriptions: Mapping[str, Description]) -> None:
    """Refuse a pattern that names an output, or an unconnected input."""
    fed = [f"{c.to_component}.{c.input}" for c in system.connections]
    for each in _expanded(pattern, what):
        if matching(each, fed):
            continue
        if matching(each, map(_source, system.connections)):
            raise InputError(f"{what}: is an output; write '{pattern} -> *' for all inputs that it feeds")
        loose = [f"{c.name}.{name}" for c in system.components for name in descriptions[c.name].names("input")]
        if matching(each, loose):
            raise InputError(f"{what}: nothing feeds this input; write parameter instead")


def _matched(pattern: str, names: Sequence[str], what: str, kind: str) -> list[str]:
    found: dict[str, None] = {}
    for each in _expanded(pattern, what):
        matched = matching(each, names)
        if not matched:
            stems = sorted({array_of(name) for name in names})
            raise InputError(f"{what}: {each}: no such {kind}; there are {compact(siblings(each, names))}"
                             f"{suggestion(each, stems)}")  # fmt: skip
        found.update(dict.fromkeys(matched))
    return list(found)


def _expanded(pattern: str, what: str) -> list[str]:
    """Return a range such as x[1..3] as x[1], x[2], x[3]."""
    found = split_range(pattern)
    if found is None:
        return [pattern]
    _, first, last = found
    if first > last:
        raise InputError(f"{what}: the range [{first}..{last}] is empty; its first number is the smaller one")
    return range_names(*found)
