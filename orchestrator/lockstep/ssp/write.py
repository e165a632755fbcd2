"""Write a system as an SSP 1.0 system structure description, with schedule and delays in annotations."""

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import read_description
from lockstep.fmi.parameter_values import parse_value, settable
from lockstep.ssp.documents.xml import ANNOTATION, LOCKSTEP, OSP, SSC, SSD, SSV, Element, add, document_bytes, new_root
from lockstep.ssp.typed_values import literal, write_transformation, write_units
from lockstep.ssp.write_outside import outside_of, units_of, write_outside, write_outside_connections
from lockstep.system.clock import seconds_text
from lockstep.system.component import Component, Connector
from lockstep.system.system import Connection, System
from lockstep.system.transformation import End, convert
from lockstep.system.units import known_unit
from lockstep.whole_file import write_whole

PARAMETER_SET = "initialValues"  # for every component: ecos applies the sets of one name, which its user gives


def write_ssd(system: System, path: Path | str) -> None:
    """Write `system` to a .ssd file, its FMUs relative to it.

    Connectors that no component declares are filled in from the connections, their types from the FMUs. Of the
    connectors of the whole system those in `System.ports` are written; other inputs are left out: without them, the
    inputs that they feed need values.

    Raises
    ------
    InputError
        If an FMU cannot be read, lacks a variable that is set, or a path has several mapping transformations.
    """
    sums = [component.name for component in system.components if component.sums is not None]
    if sums:
        raise InputError(f"{compact(sums)}: sums of an OspSystemStructure.xml, which SSP cannot express")
    path = Path(path).absolute()
    prefixes = {"ssd": SSD, "ssc": SSC, "ssv": SSV, "lockstep": LOCKSTEP, "osp": OSP}
    root = new_root(SSD, "SystemStructureDescription", prefixes, version="1.0", name=system.name)
    top = add(root, SSD, "System", name=system.name)
    outside = outside_of(system)
    write_outside(top, outside, PARAMETER_SET)
    elements = add(top, SSD, "Elements")
    enumerations: dict[tuple[tuple[str, int], ...], str] = {}
    for component in system.components:
        # start values of connected inputs are left out: in a file with annotations they are refused
        kept = {k: v for k, v in component.parameters.items() if f"{component.name}.{k}" not in system.start_values}
        component = replace(component, parameters=kept)
        _write_component(elements, component, _connectors(component, system), path.parent, enumerations)
    if system.connections or outside:
        connections = add(top, SSD, "Connections")
        for connection in system.connections:
            _write_connection(connections, connection if not connection.via else _at_once(connection, system))
        write_outside_connections(connections, outside)
    timing = {"tick": seconds_text(system.tick)}
    if system.record_period is not None:
        timing["recordPeriod"] = seconds_text(system.record_period)
    if system.strict_inputs:
        timing["strictInputs"] = "true"
    own = _annotate(top, "System", **timing)
    for pattern in system.record:
        add(own, LOCKSTEP, "Record", pattern=pattern)
    if enumerations:
        group = add(root, SSD, "Enumerations")
        for items, name in enumerations.items():
            enumeration = add(group, SSC, "Enumeration", name=name)
            for item, number in items:
                add(enumeration, SSC, "Item", name=item, value=str(number))
    write_units(root, SSD, units_of(outside) | {u.name: u for c in system.components for u in c.units.values()})
    start = seconds_text(system.start_time)
    if system.stop_time is not None:
        add(root, SSD, "DefaultExperiment", startTime=start, stopTime=seconds_text(system.stop_time))
    elif system.start_time:
        add(root, SSD, "DefaultExperiment", startTime=start)
    write_whole(path, document_bytes(root))


def _write_component(
    parent: Element,
    component: Component,
    ports: Iterable[Connector],
    folder: Path,
    enumerations: dict[tuple[tuple[str, int], ...], str],
) -> None:
    source = component.source
    if component.archive is None:
        source = Path(os.path.relpath(source.absolute(), folder))
    element = add(
        parent,
        SSD,
        "Component",
        name=component.name,
        type="application/x-fmu-sharedlibrary",
        source=quote(source.as_posix()),
        implementation="CoSimulation",
    )
    listed = list(ports)
    if listed:
        connectors = add(element, SSD, "Connectors")
        for port in listed:
            connector = add(connectors, SSD, "Connector", name=port.name, kind=port.kind)
            if port.type == "Enumeration" and port.items:
                items = tuple(port.items.items())
                name = enumerations.setdefault(items, f"Enumeration{len(enumerations) + 1}")
                add(connector, SSC, "Enumeration", name=name)
            elif port.type not in (None, "Enumeration"):
                unit = component.units.get(port.name) if port.type == "Real" else None
                add(connector, SSC, port.type, **({"unit": unit.name} if unit else {}))
    if component.parameters:
        bindings = add(element, SSD, "ParameterBindings")
        values = add(add(bindings, SSD, "ParameterBinding"), SSD, "ParameterValues")
        parameters = add(add(values, SSV, "ParameterSet", version="1.0", name=PARAMETER_SET), SSV, "Parameters")
        description = read_description(component)  # a value is written in the declared type of its variable
        for name, value in component.parameters.items():
            what = f"{component.name}.{name}"
            variable = replace(settable(component.name, name, description), minimum=None, maximum=None)
            kind, text = literal(parse_value(value, variable, what), variable.items)
            parameter = add(add(parameters, SSV, "Parameter", name=name), SSV, kind, value=text)
            if kind == "Real" and name in component.units:
                parameter.set("unit", component.units[name].name)
        used = {u.name: u for n, u in component.units.items() if n in component.parameters}
        write_units(parameters.getparent(), SSV, used)
    timing = {"period": seconds_text(component.period), "offset": seconds_text(component.offset)}
    if component.isolated is not None:
        timing["isolated"] = str(component.isolated).lower()
    if component.tolerance is not None:
        timing["tolerance"] = repr(component.tolerance)
    own = _annotate(element, "Component", **timing, kind=component.kind)
    # the step size of a component for libcosim and ecos
    other = add(own.getparent().getparent(), SSC, "Annotation", type="com.opensimulationplatform")
    add(other, OSP, "StepSizeHint", value=seconds_text(component.period))


def _connectors(component: Component, system: System) -> list[Connector]:
    if component.connectors is not None:
        return list(component.connectors)
    ends = {c.input: "input" for c in system.connections if c.to_component == component.name}
    ends |= {c.output: "output" for c in system.connections if c.from_component == component.name}
    ends |= {port.variable: port.kind for port in system.ports if port.component == component.name}
    if not ends:
        return []
    variables = read_description(component).variables
    return [
        Connector(name=name, kind=variables[name].causality, type=variables[name].type, items=variables[name].items)
        if name in variables
        else Connector(name=name, kind=kind)
        for name, kind in ends.items()
    ]


def _at_once(connection: Connection, system: System) -> Connection:
    """Return one direct connection equal to a path through connectors of systems, or raise InputError."""
    ends = []
    for name, port in (
        (connection.from_component, connection.output),
        (connection.to_component, connection.input),
    ):
        component = system.component(name)
        description = read_description(component)
        if port not in description.variables:
            raise InputError(description.lacks(name, port, "port"))
        variable = description.variables[port]
        unit = known_unit(variable.unit, component.units.get(port))
        ends.append(End(type=variable.type, unit=unit, relative=variable.relative, items=variable.items))
    conversion = convert(ends[0], ends[1], connection.hops, str(connection))
    if conversion.function is None:  # of Reals, or without any change
        return replace(connection, via=(), factor=conversion.gain, offset=conversion.bias, convert_units=False)
    acting = [hop for hop in connection.hops if not hop.converts_units_only]
    if len(acting) != 1:
        raise InputError(
            f"{connection}: {len(acting)} transformations of a {ends[0].type} cannot be combined; keep one of them"
        )
    one = acting[0]
    return replace(connection, via=(), factor=one.factor, offset=one.offset, table=one.table)


def _write_connection(parent: Element, connection: Connection) -> None:
    element = add(
        parent,
        SSD,
        "Connection",
        startElement=connection.from_component,
        startConnector=connection.output,
        endElement=connection.to_component,
        endConnector=connection.input,
    )
    if not connection.convert_units:
        element.set("suppressUnitConversion", "true")
    write_transformation(element, connection.factor, connection.offset, connection.table)
    if connection.delay:
        _annotate(element, "Connection", delay=str(connection.delay))


def _annotate(parent: Element, tag: str, **attributes: str) -> Element:
    holder = add(add(parent, SSD, "Annotations"), SSC, "Annotation", type=ANNOTATION)
    return add(holder, LOCKSTEP, tag, **attributes)
