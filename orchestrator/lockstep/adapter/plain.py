"""A system with an adapter as one without: their FMU in the component's place, connected by what SSP can say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from lockstep.adapter.bind import Binding, Bound, bind
from lockstep.adapter.expressible import Inexpressible, Pair, pairs, quaternion_pairs
from lockstep.array_names import array_of, range_names
from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Description, Variable, read_description
from lockstep.fmi.parameter_values import component_parameters
from lockstep.results.signal_patterns import matching
from lockstep.system.component import Component, Connector, Value
from lockstep.system.system import Connection, System
from lockstep.system.transformation import End, convert, family
from lockstep.system.unit_table import UNITS
from lockstep.system.units import Unit, conversion, known_unit

_TWICE = "has a transformation already, and a connection has one"


@dataclass(frozen=True, slots=True, kw_only=True)
class Mapped:
    """A value of ours, in the unit of our port, and the parameter or input of theirs that it reaches."""

    ours: str
    value: Value
    unit: Unit | None
    theirs: str
    type: str  # of theirs
    pair: Pair

    @property
    def resolved(self) -> Value:
        """What it is there."""
        if family(self.type) == "Real":
            return self.pair.factor * float(self.value) + self.pair.offset
        whole = int(self.value)
        if self.pair.table is None:
            whole = int(self.pair.factor * whole + self.pair.offset)
        else:
            whole = int(dict(self.pair.table.entries).get(whole, whole))
        return bool(whole) if self.type == "Boolean" else whole


@dataclass(slots=True, kw_only=True)
class Plain:
    """A component without its adapter. `problems` names, line by line, what SSP cannot say and so is left out."""

    system: System
    component: str
    values: dict[str, Value] = field(default_factory=dict)  # constants and parameters, by names of theirs
    mapped: list[Mapped] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def without_adapter(system: System, name: str, sources: Mapping[str, tuple[str, str]]) -> Plain:
    """Take a component out of its adapter.

    Parameters
    ----------
    system : where it is
    name : of the component
    sources : for an array of ours that holds an attitude as an MRP, component and array of outputs that hold the same
        attitude as a scalar-last quaternion, body from inertial

    Raises
    ------
    InputError
        If the adapter does not fit, or a source is not there.
    """
    return _Translation(system, name, sources).plain()


class _Translation:
    def __init__(self, system: System, name: str, sources: Mapping[str, tuple[str, str]]) -> None:
        self.system, self.name, self.sources = system, name, sources
        component = system.component(name)
        assert component.adapter is not None
        assert component.stands_for is not None
        self.component = component
        self.descriptions: dict[str, Description] = {}
        theirs = read_description(component)
        self.ours = read_description(component.stands_for)
        self.binding: Binding = bind(component.adapter, self.ours.variables, theirs.variables)
        shown = replace(theirs, variables=self.binding.variables)
        self.given = component_parameters(replace(component, units=dict(component.units)), shown)
        self.feeds = {c.input: c for c in system.connections if c.to_component == name}
        self.made: dict[str, list[Connection]] = {}
        for connection in system.connections:
            if connection.from_component == name:
                self.made.setdefault(connection.output, []).append(connection)
        self.connections = [c for c in system.connections if name not in (c.from_component, c.to_component)]
        self.names: dict[str, str] = {}  # of outputs: theirs by ours
        plain = Component(
            name=name,
            source=component.source,
            period=component.period,
            offset=component.offset,
            kind=component.kind,
            archive=component.archive,
            isolated=component.isolated,
            units=self._units(theirs),
        )
        self.result = Plain(system=system, component=name)
        self.new = plain

    def plain(self) -> Plain:
        """Translate everything."""
        binding, result = self.binding, self.result
        for key in self.sources:
            if not any(array_of(v.name) == key for b in binding.inputs if b.entry.attitude for v in b.ours):
                raise InputError(f"--source {key}: no attitude of ours in an [[input]] of {binding.adapter.path.name}")
        for bound in binding.inputs:
            self._input(bound)
        for bound in binding.outputs:
            self._output(bound)
        result.values |= {v.name: value for v, value in binding.starts.items()}
        theirs = {v.name for v in binding.parameters.values()}
        result.values |= {key: value for key, value in self.given.items() if key in theirs}
        self._substitute()
        result.system = replace(
            self.system,
            components=tuple(self.new if c.name == self.name else c for c in self.system.components),
            connections=tuple(self.connections),
            record=tuple(dict.fromkeys(self._record())) or ("all",),
        )
        return result

    def _units(self, theirs: Description) -> dict[str, Unit]:
        """Return the units that the adapter tells of ports whose FMU tells none: for whoever reads the file."""
        return {
            v.name: UNITS[b.entry.unit]
            for b in (*self.binding.inputs, *self.binding.outputs)
            if b.entry.unit
            for v in b.theirs
            if v.unit is None and v.type in ("Real", "Float64", "Float32") and v.name in theirs.variables
        }

    def _input(self, bound: Bound) -> None:
        place, array = bound.entry.place, array_of(bound.ours[0].name)
        if bound.hold is not None:
            self.result.problems.append(
                f"{place}: hold = {bound.hold.name!r}: SSP cannot hold a value; without it all values pass on"
            )
        try:
            if array in self.sources:
                self._from_source(bound, *self.sources[array])
                return
            found = pairs(bound)
        except Inexpressible as reason:
            remedy = ""
            if bound.entry.attitude == "quaternion" and len(bound.ours) == 3:
                remedy = (
                    f"; if an output has the attitude as a quaternion, --source {array}=COMPONENT.ARRAY connects it"
                )
            self.result.problems.append(f"{place}: {reason}{remedy}")
            return
        for pair in found:
            our, their = bound.ours[pair.ours], bound.theirs[pair.theirs]
            connection = self.feeds.get(our.name)
            if connection is not None:
                self._connect(connection, their, pair, place)
            elif our.name in self.given:
                mapped = Mapped(
                    ours=our.name,
                    value=self.given[our.name],
                    unit=our.unit,
                    theirs=their.name,
                    type=their.type,
                    pair=pair,
                )
                self.result.mapped.append(mapped)

    def _from_source(self, bound: Bound, component: str, array: str) -> None:
        description = self._description(component)
        outputs = range_names(array, 1, 4)
        lacking = [name for name in outputs if name not in description.names("output")]
        if lacking:
            raise InputError(description.lacks(component, lacking[0], "output"))
        before = self.feeds.get(bound.ours[0].name)
        if before is None:
            raise InputError(f"{self.name}.{bound.ours[0].name}: nothing is connected that --source could stand for")
        if before.from_component != component:
            raise InputError(
                f"--source {array_of(bound.ours[0].name)}={component}.{array}: it comes from {before.from_component}; "
                "only another output of that component has the same delay"
            )
        self._declare(component, [description.variables[name] for name in outputs])
        for pair in quaternion_pairs(bound):
            connection = replace(
                before, output=outputs[pair.ours], factor=1.0, offset=0.0, table=None, via=(), convert_units=True
            )
            self._connect(connection, bound.theirs[pair.theirs], pair, bound.entry.place)

    def _declare(self, name: str, outputs: list[Variable]) -> None:
        """Add outputs to the connectors of a component that declares what it has."""
        component = self.system.component(name)
        if component.connectors is not None:
            there = {port.name for port in component.connectors}
            more = (Connector(name=v.name, kind="output", type=v.type) for v in outputs if v.name not in there)
            self._change(replace(component, connectors=(*component.connectors, *more)))

    def _change(self, changed: Component) -> None:
        parts = (changed if c.name == changed.name else c for c in self.system.components)
        self.system = replace(self.system, components=tuple(parts))

    def _connect(self, old: Connection, their: Variable, pair: Pair, place: str) -> None:
        """Connect what fed a port of ours with theirs: through what happened on the way, then through the adapter."""
        source = self._end(old.from_component, old.output)
        new = replace(old, input=their.name)
        if pair.table is not None or source.type not in ("Real", "Float64", "Float32"):
            if any(not hop.plain for hop in old.hops):
                self.result.problems.append(f"{place}: {old} {_TWICE}")
                return
            self.connections.append(replace(new, factor=pair.factor, offset=pair.offset, table=pair.table, via=()))
            return
        ours = self.ours.variables.get(old.input)
        target = _end(ours, None) if ours is not None else source
        way = convert(source, target, old.hops, str(old))
        self.connections.append(
            _linear(new, pair.factor * way.gain, pair.factor * way.bias + pair.offset, source.unit, self._unit(their))
        )

    def _output(self, bound: Bound) -> None:
        place = bound.entry.place
        unfed = [c for v in bound.ours for c in self.made.get(v.name, ())]
        try:
            found = pairs(bound)
        except Inexpressible as reason:
            lost = compact(f"{c.to_component}.{c.input}" for c in unfed)
            self.result.problems.append(f"{place}: {reason}" + (f"; nothing feeds {lost}" if unfed else ""))
            return
        for pair in found:
            our, their = bound.ours[pair.ours], bound.theirs[pair.theirs]
            self.names[our.name] = their.name
            for old in self.made.get(our.name, ()):
                new = replace(old, output=their.name)
                if pair.table is not None or their.scalar != "Real":
                    if any(not hop.plain for hop in old.hops):
                        self.result.problems.append(f"{place}: {old} {_TWICE}")
                        continue
                    changed = replace(new, factor=pair.factor, offset=pair.offset, table=pair.table, via=())
                    self.connections.append(changed)
                    continue
                target = self._end(old.to_component, old.input)
                way = convert(_end(our, None), target, old.hops, str(old))
                gain, bias = way.gain * pair.factor, way.gain * pair.offset + way.bias
                self.connections.append(_linear(new, gain, bias, self._unit(their), target.unit))

    def _substitute(self) -> None:
        """Give what reads a substituted output of ours its value."""
        for name, value in self.binding.substitutes.items():
            for connection in self.made.get(name, ()):
                target = self._end(connection.to_component, connection.input)
                way = convert(_end(self.ours.variables[name], None), target, connection.hops, str(connection))
                given: Value = way.gain * value + way.bias
                if target.type not in ("Real", "Float64", "Float32"):
                    whole = int(value) if way.function is None else way.function(int(value))
                    given = bool(whole) if target.type == "Boolean" else whole
                self._set(connection.to_component, connection.input, given)

    def _set(self, name: str, variable: str, value: Value) -> None:
        component = self.system.component(name)
        units = {key: unit for key, unit in component.units.items() if key != variable}
        self._change(replace(component, parameters={**component.parameters, variable: value}, units=units))

    def _record(self) -> Iterator[str]:
        for pattern in self.system.record:
            if not pattern.startswith(f"{self.name}."):
                yield pattern
            else:
                for ours in matching(pattern.removeprefix(f"{self.name}."), self.names):
                    yield f"{self.name}.{self.names[ours]}"

    def _description(self, name: str) -> Description:
        if name not in self.descriptions:
            component = self.system.component(name)
            if component.adapter is not None:
                raise InputError(f"{name}: has an adapter too; write the system with one of them at a time")
            self.descriptions[name] = read_description(component)
        return self.descriptions[name]

    def _unit(self, their: Variable) -> Unit | None:
        return known_unit(their.unit, self.new.units.get(their.name))

    def _end(self, component: str, port: str) -> End:
        description = self._description(component)
        if port not in description.variables:
            raise InputError(description.lacks(component, port, "port"))
        return _end(description.variables[port], self.system.component(component).units.get(port))


def _end(variable: Variable, declared: Unit | None) -> End:
    unit = known_unit(variable.unit, declared)
    return End(type=variable.type, unit=unit, relative=variable.relative, items=variable.items)


def _linear(
    connection: Connection, factor: float, offset: float, source: Unit | None, target: Unit | None
) -> Connection:
    """Return a connection that does this and nothing else: many tools read the factor, few convert units."""
    try:
        silent = conversion(source, target) == (1.0, 0.0)
    except ValueError:
        silent = False
    return replace(connection, factor=factor, offset=offset, table=None, via=(), convert_units=silent)
