"""Check a system against the model descriptions of its FMUs; resolve names, types and units."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from lockstep.array_names import name_and_arrays
from lockstep.errors import InputError
from lockstep.fmi.model_description import Description, Variable
from lockstep.fmi.parameter_values import component_parameters
from lockstep.fmi.slave import Scalar
from lockstep.plan.overrides import Override, resolve_overrides, unfed
from lockstep.plan.transfer import Way
from lockstep.system.component import Component, Value
from lockstep.system.system import Connection, System
from lockstep.system.transformation import Conversion, End, Function, convert
from lockstep.system.units import checked_conversion, known_unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """All scalars of one type from one producer to one consumer with one delay, by reference.

    A target receives gain * source + bias, where only Reals have other gains and biases than 1 and 0, or the result of
    a function.
    """

    producer: str
    consumer: str
    delay: int  # [ticks]
    scalar: Scalar
    sources: tuple[int, ...]
    targets: tuple[int, ...]
    gains: tuple[float, ...]
    biases: tuple[float, ...]
    target_scalar: Scalar | None = None  # the type of the targets; None: that of the sources
    functions: tuple[Function | None, ...] = ()  # one a value; (): none

    @property
    def ways(self) -> list[Way]:
        """The conversion of each value."""
        functions = self.functions or (None,) * len(self.sources)
        rows = zip(self.gains, self.biases, functions, strict=True)
        return [Way(source=self.scalar, gain=gain, bias=bias, function=function) for gain, bias, function in rows]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """A checked system.

    `parameters` are the values set, in the FMUs' units, by component and variable; `unconnected` are the inputs that
    have neither a connection nor a value, by component: they keep their FMUs' start values.
    """

    links: tuple[Link, ...]
    parameters: Mapping[str, Mapping[str, Value]]
    unconnected: Mapping[str, tuple[str, ...]]

    def starts(self, name: str, description: Description) -> dict[Scalar, dict[int, Value]]:
        """Return a component's parameters and start values by type and reference."""
        starts: dict[Scalar, dict[int, Value]] = {}
        for key, value in self.parameters[name].items():
            variable = description.variables[key]
            if variable.scalar is not None:  # a value of another type is refused before
                starts.setdefault(variable.scalar, {})[variable.reference] = value
        return starts


def wire(
    system: System,
    descriptions: Mapping[str, Description],
    overrides: Mapping[str, Override],
    strict_inputs: bool = False,
    fed: Mapping[tuple[str, str], str] = MappingProxyType({}),
) -> Wiring:
    """Check everything that can be checked without running, or raise InputError.

    With `strict_inputs`, or where the system asks for it, an input without connection and value is refused. `fed` are
    the inputs that files feed, by component and variable, and the names of their sources.
    """
    for component in system.components:
        _check_connectors(component, descriptions[component.name])
    _check_single_instances(system, descriptions)
    parameters = {
        component.name: component_parameters(component, descriptions[component.name]) for component in system.components
    }
    links = _links(system, descriptions)
    feeding = {(c.to_component, c.input): c for c in system.connections}
    for name, values in parameters.items():
        for port in values:
            if f"{name}.{port}" not in system.start_values:
                _refuse_fed(name, port, feeding, "remove it from the system's parameters")
    given: dict[tuple[str, str], str] = {}
    for key, value in overrides.items():
        for name, variable, item in resolve_overrides(key, value, system, descriptions):
            _refuse_fed(name, variable.name, feeding, f"leave {key} out")
            first = given.setdefault((name, variable.name), key)
            if first not in name_and_arrays(key):  # one element may differ from the array that is given before it
                raise InputError(f"{name}.{variable.name}: has a value by {first} and by {key}; give one of them")
            parameters[name][variable.name] = item
    for (name, variable_name), source in fed.items():
        connection = feeding.get((name, variable_name))
        if connection is not None:
            connected = f"{name}.{variable_name} is connected to {connection.from_component}.{connection.output}"
            raise InputError(f"{source}: {connected}; remove the column, or the connection")
        if (name, variable_name) in given:
            raise InputError(f"{source}: {name}.{variable_name} has a value by {given[name, variable_name]}; give one")
        parameters[name].pop(variable_name, None)  # a start value of the system
    for name, values in parameters.items():
        _check_aliases(name, values, descriptions[name])
    unconnected = _unconnected(system, descriptions, parameters, fed)
    if strict_inputs or system.strict_inputs:
        for name, loose in unconnected.items():
            raise InputError(unfed(name, loose, system))
    return Wiring(links=links, parameters=parameters, unconnected=unconnected)


def _refuse_fed(component: str, variable: str, feeding: Mapping[tuple[str, str], Connection], remedy: str) -> None:
    """Refuse a value for a connected input, which the first transfer would replace."""
    connection = feeding.get((component, variable))
    if connection is not None:
        raise InputError(
            f"{component}.{variable}: is connected to {connection.from_component}.{connection.output}, so that a value "
            f"for it has no effect; {remedy}, remove the connection, or inject a fault of kind stuck"
        )


def _check_aliases(component: str, values: Mapping[str, Value], description: Description) -> None:
    """Refuse two values for one variable that has two names."""
    known: dict[tuple[Scalar | None, int], str] = {}
    for name, value in values.items():
        variable = description.variables[name]
        first = known.setdefault((variable.scalar, variable.reference), name)
        if values[first] != value:
            raise InputError(
                f"{component}.{name}: is {value!r}, and {first}, another name of the same variable, {values[first]!r}; "
                "give one of them"
            )


def _check_connectors(component: Component, description: Description) -> None:
    for port in component.connectors or ():
        what = f"{component.name}.{port.name}"
        variable = description.variables.get(port.name)
        if variable is None:
            raise InputError(description.lacks(component.name, port.name, port.kind))
        if variable.causality != port.kind:
            raise InputError(f"{what}: declared as {port.kind}, but it is the FMU's {variable.causality}")
        if port.type is not None and variable.type != port.type:
            raise InputError(f"{what}: declared as {port.type}, but the FMU says {variable.type}")
        declared = component.units.get(port.name)
        if any(variable.items.get(item, number) != number for item, number in port.items.items()):
            raise InputError(f"{what}: the file numbers the items of its Enumeration differently from the FMU")
        if declared is None or variable.unit is None or declared.name == variable.unit.name:
            continue
        if variable.unit.exponents is None:
            continue  # the FMU gives a name only: the file defines the unit
        if checked_conversion(declared, variable.unit, False, what) != (1.0, 0.0):
            raise InputError(f"{what}: declared in '{declared.name}', but the FMU's unit is '{variable.unit.name}'")


def _check_single_instances(system: System, descriptions: Mapping[str, Description]) -> None:
    seen: dict[str, str] = {}
    for component in system.components:
        description = descriptions[component.name]
        if component.isolated:
            continue
        first = seen.setdefault(description.sha256, component.name)
        if first != component.name and description.once_per_process:
            raise InputError(f"{component.name}: the FMU allows one instance per process, and {first} is it already")


def _links(system: System, descriptions: Mapping[str, Description]) -> tuple[Link, ...]:
    components = {component.name: component for component in system.components}
    groups: dict[tuple[str, str, int, Scalar, Scalar], list[tuple[int, int, Conversion]]] = {}
    for connection in system.connections:
        source = _port(connection, "output", descriptions)
        target = _port(connection, "input", descriptions)
        if source.scalar is None or target.scalar is None:
            raise InputError(f"{connection}: values of type {source.type} are not exchanged; remove the connection")
        ends = _end(source, components[connection.from_component]), _end(target, components[connection.to_component])
        conversion = convert(*ends, connection.hops, str(connection))
        key = (connection.from_component, connection.to_component, connection.delay, source.scalar, target.scalar)
        groups.setdefault(key, []).append((source.reference, target.reference, conversion))
    return tuple(
        Link(
            producer=key[0],
            consumer=key[1],
            delay=key[2],
            scalar=key[3],
            target_scalar=key[4],
            sources=tuple(entry[0] for entry in entries),
            targets=tuple(entry[1] for entry in entries),
            gains=tuple(entry[2].gain for entry in entries),
            biases=tuple(entry[2].bias for entry in entries),
            functions=tuple(entry[2].function for entry in entries),
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
        raise InputError(description.lacks(component, name, causality))
    # what is calculated of parameters is known from initialization on, and SSP and OSP may connect it
    if variable.causality != causality and not (outward and variable.causality == "calculatedParameter"):
        raise InputError(
            f"{connection}: {component}.{name} is the FMU's {variable.causality}, an {causality} is needed"
        )
    return variable


def _end(variable: Variable, component: Component) -> End:
    unit = known_unit(variable.unit, component.units.get(variable.name))
    return End(type=variable.native or variable.type, unit=unit, relative=variable.relative, items=variable.items)


def _unconnected(
    system: System,
    descriptions: Mapping[str, Description],
    parameters: Mapping[str, Mapping[str, Value]],
    files: Collection[tuple[str, str]],
) -> dict[str, tuple[str, ...]]:
    """Return the inputs without connection and value by component; variables without a scalar type are no inputs."""
    fed = {(connection.to_component, connection.input) for connection in system.connections} | set(files)
    found = {}
    for component in system.components:
        variables = descriptions[component.name].variables.values()
        inputs = [v.name for v in variables if v.causality == "input" and v.scalar is not None]
        loose = [n for n in inputs if (component.name, n) not in fed and n not in parameters[component.name]]
        if loose:
            found[component.name] = tuple(loose)
    return found
