"""Write an adapted component as plain SSP: the foreign FMU itself, connected with transformations and parameters."""

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
    """Hold a value of an interface port, in the port's unit, and the FMU variable that it sets."""

    port: str
    value: Value
    unit: Unit | None
    variable: str
    type: str  # of the variable
    pair: Pair

    @property
    def resolved(self) -> Value:
        """The value of the variable."""
        if family(self.type) == "Real":
            return self.pair.factor * float(self.value) + self.pair.offset
        whole = int(self.value)
        if self.pair.table is None:
            whole = int(self.pair.factor * whole + self.pair.offset)
        else:
            whole = int(dict(self.pair.table.entries).get(whole, whole))
        return bool(whole) if self.type == "Boolean" else whole


@dataclass(slots=True, kw_only=True)
class AsSsp:
    """Hold a system in which a component has no adapter. `problems` lists what SSP cannot express and so is missing."""

    system: System
    component: str
    values: dict[str, Value] = field(default_factory=dict)  # constants and parameters, by FMU variable
    mapped: list[Mapped] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def without_adapter(system: System, name: str, sources: Mapping[str, tuple[str, str]]) -> AsSsp:
    """Replace the adapter of a component by connections, parameters and start values.

    Parameters
    ----------
    system : holds the component
    name : name of the component
    sources : for a port that is an MRP, the component and the array of outputs with the same attitude as a scalar-last
        quaternion, body from inertial

    Raises
    ------
    InputError
        If the adapter does not fit, or a source is not there.
    """
    return _Translation(system, name, sources).translate()


class _Translation:
    def __init__(self, system: System, name: str, sources: Mapping[str, tuple[str, str]]) -> None:
        self.system, self.name, self.sources = system, name, sources
        component = system.component(name)
        assert component.adapter is not None
        assert component.stands_for is not None
        self.component = component
        self.descriptions: dict[str, Description] = {}
        fmu = read_description(component)
        self.ports = read_description(component.stands_for)
        self.binding: Binding = bind(component.adapter, self.ports.variables, fmu.variables)
        shown = replace(fmu, variables=self.binding.shown)
        self.given = component_parameters(replace(component, units=dict(component.units)), shown)
        self.feeds = {c.input: c for c in system.connections if c.to_component == name}
        self.made: dict[str, list[Connection]] = {}
        for connection in system.connections:
            if connection.from_component == name:
                self.made.setdefault(connection.output, []).append(connection)
        self.connections = [c for c in system.connections if name not in (c.from_component, c.to_component)]
        self.names: dict[str, str] = {}  # FMU variable by interface port, of outputs
        self.new = Component(
            name=name,
            source=component.source,
            period=component.period,
            offset=component.offset,
            kind=component.kind,
            archive=component.archive,
            isolated=component.isolated,
            tolerance=component.tolerance,
            units=self._units(fmu),
        )
        self.result = AsSsp(system=system, component=name)

    def translate(self) -> AsSsp:
        """Translate everything."""
        binding, result = self.binding, self.result
        for key in self.sources:
            if not any(array_of(v.name) == key for b in binding.inputs if b.entry.attitude for v in b.ports):
                raise InputError(f"--source {key}: no attitude port of an [[input]] of {binding.adapter.path.name}")
        for bound in binding.inputs:
            self._input(bound)
        for bound in binding.outputs:
            self._output(bound)
        result.values |= {v.name: value for v, value in binding.starts.items()}
        parameters = {v.name for v in binding.parameters.values()}
        result.values |= {key: value for key, value in self.given.items() if key in parameters}
        self._substitute()
        result.system = replace(
            self.system,
            components=tuple(self.new if c.name == self.name else c for c in self.system.components),
            connections=tuple(self.connections),
            # those of the whole system that lead to ports which only the adapter has lead nowhere without it
            ports=tuple(port for port in self.system.ports if port.component != self.name),
            record=tuple(dict.fromkeys(self._record())) or ("all",),
        )
        return result

    def _units(self, fmu: Description) -> dict[str, Unit]:
        """Return the units that the adapter gives for variables whose FMU declares none, for readers of the file."""
        return {
            v.name: UNITS[b.entry.unit]
            for b in (*self.binding.inputs, *self.binding.outputs)
            if b.entry.unit
            for v in b.variables
            if v.unit is None and v.type in ("Real", "Float64", "Float32") and v.name in fmu.variables
        }

    def _input(self, bound: Bound) -> None:
        location, array = bound.entry.location, array_of(bound.ports[0].name)
        if bound.hold is not None:
            self.result.problems.append(
                f"{location}: hold = {bound.hold.name!r}: SSP cannot hold a value; without it every value is passed on"
            )
        try:
            if array in self.sources:
                self._from_source(bound, *self.sources[array])
                return
            found = pairs(bound)
        except Inexpressible as reason:
            remedy = ""
            if bound.entry.attitude == "quaternion" and len(bound.ports) == 3:
                remedy = (
                    f"; if an output has the attitude as a quaternion, --source {array}=COMPONENT.ARRAY connects it"
                )
            self.result.problems.append(f"{location}: {reason}{remedy}")
            return
        for pair in found:
            port, variable = bound.ports[pair.port], bound.variables[pair.variable]
            connection = self.feeds.get(port.name)
            if connection is not None:
                self._connect(connection, variable, pair, location)
            elif port.name in self.given:
                mapped = Mapped(
                    port=port.name,
                    value=self.given[port.name],
                    unit=port.unit,
                    variable=variable.name,
                    type=variable.type,
                    pair=pair,
                )
                self.result.mapped.append(mapped)

    def _from_source(self, bound: Bound, component: str, array: str) -> None:
        description = self._description(component)
        outputs = range_names(array, 1, 4)
        lacking = [name for name in outputs if name not in description.names("output")]
        if lacking:
            raise InputError(description.lacks(component, lacking[0], "output"))
        before = self.feeds.get(bound.ports[0].name)
        if before is None:
            raise InputError(f"{self.name}.{bound.ports[0].name}: nothing is connected that --source could replace")
        if before.from_component != component:
            raise InputError(
                f"--source {array_of(bound.ports[0].name)}={component}.{array}: it comes from {before.from_component}; "
                "only another output of that component has the same delay"
            )
        self._declare(component, [description.variables[name] for name in outputs])
        for pair in quaternion_pairs(bound):
            connection = replace(
                before, output=outputs[pair.port], factor=1.0, offset=0.0, table=None, via=(), convert_units=True
            )
            self._connect(connection, bound.variables[pair.variable], pair, bound.entry.location)

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

    def _connect(self, old: Connection, variable: Variable, pair: Pair, location: str) -> None:
        """Connect the source of an interface port with an FMU variable: old transformations first, then the adapter."""
        source = self._end(old.from_component, old.output)
        new = replace(old, input=variable.name)
        if pair.table is not None or source.type not in ("Real", "Float64", "Float32"):
            if any(not hop.converts_units_only for hop in old.hops):
                self.result.problems.append(f"{location}: {old} {_TWICE}")
                return
            self.connections.append(replace(new, factor=pair.factor, offset=pair.offset, table=pair.table, via=()))
            return
        port = self.ports.variables.get(old.input)
        target = port.end(port.unit) if port is not None else source
        way = convert(source, target, old.hops, str(old))
        self.connections.append(
            _linear(
                new, pair.factor * way.gain, pair.factor * way.bias + pair.offset, source.unit, self._unit(variable)
            )
        )

    def _output(self, bound: Bound) -> None:
        location = bound.entry.location
        unfed = [c for v in bound.ports for c in self.made.get(v.name, ())]
        try:
            found = pairs(bound)
        except Inexpressible as reason:
            lost = compact(f"{c.to_component}.{c.input}" for c in unfed)
            self.result.problems.append(f"{location}: {reason}" + (f"; nothing feeds {lost}" if unfed else ""))
            return
        for pair in found:
            port, variable = bound.ports[pair.port], bound.variables[pair.variable]
            self.names[port.name] = variable.name
            for old in self.made.get(port.name, ()):
                new = replace(old, output=variable.name)
                if pair.table is not None or variable.scalar != "Real":
                    if any(not hop.converts_units_only for hop in old.hops):
                        self.result.problems.append(f"{location}: {old} {_TWICE}")
                        continue
                    changed = replace(new, factor=pair.factor, offset=pair.offset, table=pair.table, via=())
                    self.connections.append(changed)
                    continue
                target = self._end(old.to_component, old.input)
                way = convert(port.end(port.unit), target, old.hops, str(old))
                gain, bias = way.gain * pair.factor, way.gain * pair.offset + way.bias
                self.connections.append(_linear(new, gain, bias, self._unit(variable), target.unit))

    def _substitute(self) -> None:
        """Set the value of a substituted output port in the components that read it."""
        for name, value in self.binding.substitutes.items():
            for connection in self.made.get(name, ()):
                target = self._end(connection.to_component, connection.input)
                variable = self.ports.variables[name]
                way = convert(variable.end(variable.unit), target, connection.hops, str(connection))
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
                for port in matching(pattern.removeprefix(f"{self.name}."), self.names):
                    yield f"{self.name}.{self.names[port]}"

    def _description(self, name: str) -> Description:
        if name not in self.descriptions:
            component = self.system.component(name)
            if component.adapter is not None:
                raise InputError(f"{name}: has an adapter too; write the system with one of them at a time")
            self.descriptions[name] = read_description(component)
        return self.descriptions[name]

    def _unit(self, variable: Variable) -> Unit | None:
        return known_unit(variable.unit, self.new.units.get(variable.name))

    def _end(self, component: str, port: str) -> End:
        description = self._description(component)
        if port not in description.variables:
            raise InputError(description.lacks(component, port, "port"))
        variable = description.variables[port]
        return variable.end(known_unit(variable.unit, self.system.component(component).units.get(port)))


def _linear(
    connection: Connection, factor: float, offset: float, source: Unit | None, target: Unit | None
) -> Connection:
    """Return a connection with all conversion in factor and offset: many tools read these, few convert units."""
    try:
        unchanged = conversion(source, target) == (1.0, 0.0)
    except ValueError:
        unchanged = False
    return replace(connection, factor=factor, offset=offset, table=None, via=(), convert_units=unchanged)
