"""Write the connectors of the whole system: what a package shows to hosts that connect it to other systems."""

from collections.abc import Iterable, Mapping

from lockstep.fmi.model_description import Variable, read_description
from lockstep.fmi.parameter_values import parse_value
from lockstep.ssp.documents.xml import SSC, SSD, SSV, Element, add
from lockstep.ssp.typed_values import literal
from lockstep.system.component import Component, Value
from lockstep.system.system import System, SystemPort
from lockstep.system.units import Unit

Outside = tuple[SystemPort, Variable, Component]
_KINDS = ("Real", "Integer", "Boolean", "String")  # types that a connector declares


def outside_of(system: System) -> list[Outside]:
    """Return the connectors of the whole system whose variables the FMUs have: another FMU may stand in for one."""
    found = []
    components = {name: system.component(name) for name in {port.component for port in system.ports}}
    descriptions = {name: read_description(component) for name, component in components.items()}  # each file once
    for port in system.ports:
        component = components[port.component]
        variable = descriptions[port.component].variables.get(port.variable)
        if variable is not None and variable.type in _KINDS:
            found.append((port, variable, component))
    return found


def units_of(outside: Iterable[Outside]) -> dict[str, Unit]:
    """Return the units of connectors by name."""
    units = (_unit(variable, component) for _, variable, component in outside)
    return {unit.name: unit for unit in units if unit is not None}


def write_outside(top: Element, outside: Iterable[Outside], parameter_set: str) -> None:
    """Write the connectors, and the values of inputs: a host sends those, and not zero, where nothing is connected.

    Parameters
    ----------
    top : the whole system, still empty
    outside : from `outside_of`
    parameter_set : name of the set of values
    """
    by_name = {port.name: (port, variable, component) for port, variable, component in outside}
    if not by_name:
        return
    connectors = add(top, SSD, "Connectors")
    values: dict[str, tuple[Value, Variable]] = {}
    for name, (port, variable, component) in by_name.items():
        unit = _unit(variable, component)
        connector = add(connectors, SSD, "Connector", name=name, kind=port.kind)
        add(connector, SSC, variable.type, **({"unit": unit.name} if unit else {}))
        if port.kind == "input" and port.variable in component.parameters:
            values[name] = component.parameters[port.variable], variable
    if values:
        _write_values(top, values, parameter_set)


def _write_values(top: Element, values: Mapping[str, tuple[Value, Variable]], parameter_set: str) -> None:
    binding = add(add(add(top, SSD, "ParameterBindings"), SSD, "ParameterBinding"), SSD, "ParameterValues")
    parameters = add(add(binding, SSV, "ParameterSet", version="1.0", name=parameter_set), SSV, "Parameters")
    for name, (value, variable) in values.items():
        kind, text = literal(parse_value(value, variable, name), variable.items)
        add(add(parameters, SSV, "Parameter", name=name), SSV, kind, value=text)


def write_outside_connections(connections: Element, outside: Iterable[Outside]) -> None:
    """Write the connections between connectors of the whole system and components."""
    for port, _, _ in outside:
        inner = (("Element", port.component), ("Connector", port.variable))
        ends = {f"{'end' if port.kind == 'input' else 'start'}{what}": text for what, text in inner}
        ends[f"{'start' if port.kind == 'input' else 'end'}Connector"] = port.name
        order = ("startElement", "startConnector", "endElement", "endConnector")
        add(connections, SSD, "Connection", **{key: ends[key] for key in order if key in ends})


def _unit(variable: Variable, component: Component) -> Unit | None:
    unit = component.units.get(variable.name, variable.unit) if variable.type == "Real" else None
    return unit if unit is not None and unit.exponents is not None else None
