"""Write the model description of a bundle: FMI 2.0 for co-simulation."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from xml.etree import ElementTree as ET

from lockstep.bundle.contents import Contents
from lockstep.bundle.ports import Port
from lockstep.fmi.declared_units import DisplayUnit
from lockstep.system.clock import seconds, seconds_text
from lockstep.system.units import BASES, Unit

_IDENTIFIER = r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?"
_STRUCTURED = re.compile(rf"{_IDENTIFIER}(\.{_IDENTIFIER})*", re.ASCII)
_TRUE, _FALSE = "true", "false"


def identifier(name: str) -> str:
    """Return the name of a system as an identifier of C, which names the library."""
    text = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return text if text and not text[0].isdigit() else f"system_{text}".rstrip("_")


def model_description(contents: Contents, guid: str) -> bytes:
    """Return modelDescription.xml."""
    system, ports = contents.system, contents.ports
    structured = all(_STRUCTURED.fullmatch(port.name) for port in ports)
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "2.0",
        "modelName": system.name,
        "guid": guid,
        "description": _summary(contents),
        "generationTool": "lockstep bundle",
        "variableNamingConvention": "structured" if structured else "flat",
    })  # fmt: skip
    _co_simulation(root, contents)
    units, names = _units(ports)
    _unit_definitions(root, units, ports)
    types = _type_definitions(root, ports)
    categories = ET.SubElement(root, "LogCategories")
    for category in ("logStatusError", "logStatusDiscard"):
        ET.SubElement(categories, "Category", name=category)
    _experiment(root, contents)
    variables = ET.SubElement(root, "ModelVariables")
    for number, port in enumerate(ports):
        _variable(variables, number, port, names.get(port.name), types)
    _structure(root, contents)
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'.encode()


def _summary(contents: Contents) -> str:
    names = [component.name for component in contents.system.components]
    step = seconds_text(contents.system.tick * contents.step_ticks)
    return f"System of {len(names)} FMUs ({', '.join(names)}); its steps are multiples of {step} s"


def _co_simulation(root: ET.Element, contents: Contents) -> None:
    inner = [contents.descriptions[component.name] for component in contents.system.components]
    flags = {
        "needsExecutionTool": any(one.needs_tool for one in inner),
        "canHandleVariableCommunicationStepSize": False,
        "canInterpolateInputs": False,
        "canRunAsynchronuously": False,
        "canBeInstantiatedOnlyOncePerProcess": any(one.once_per_process for one in inner),
        "canNotUseMemoryManagementFunctions": False,
        "canGetAndSetFMUstate": all(one.keeps_state for one in inner),
        "canSerializeFMUstate": all(one.saves_state for one in inner),
        "providesDirectionalDerivative": False,
    }
    written = {name: _TRUE if value else _FALSE for name, value in flags.items()}
    ET.SubElement(root, "CoSimulation", {"modelIdentifier": identifier(contents.system.name), **written})


def _units(ports: Iterable[Port]) -> tuple[dict[str, Unit], dict[str, str]]:
    """Return units by the names that they have in the bundle, and the names by port.

    Units of one name that differ get the name of the component too.
    """
    units: dict[str, Unit] = {}
    names: dict[str, str] = {}
    for port in ports:
        unit = port.unit
        if unit is None or not unit.name or port.variable.type != "Real":
            continue
        name = unit.name
        if units.setdefault(name, unit) != unit:
            name = f"{unit.name} ({port.ends[0].component})"
            units.setdefault(name, unit)
        names[port.name] = name
    return units, names


def _unit_definitions(root: ET.Element, units: Mapping[str, Unit], ports: Iterable[Port]) -> None:
    shown: dict[str, dict[str, DisplayUnit]] = {}
    for port in ports:
        display = _display(port)
        if display is not None and port.unit is not None:
            shown.setdefault(port.unit.name, {})[port.variable.display_unit] = display
    if not units:
        return
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name, unit in units.items():
        element = ET.SubElement(definitions, "Unit", name=name)
        if unit.exponents is not None:
            base = {b: str(e) for b, e in zip(BASES, unit.exponents, strict=True) if e}
            base |= {"factor": repr(unit.factor)} if unit.factor != 1.0 else {}
            base |= {"offset": repr(unit.offset)} if unit.offset else {}
            ET.SubElement(element, "BaseUnit", base)
        for text, display in shown.get(name, {}).items():
            factor = 1.0 / display.gain
            more = {"offset": repr(-display.bias * factor)} if display.bias else {}
            ET.SubElement(element, "DisplayUnit", {"name": text, "factor": repr(factor), **more})


def _display(port: Port) -> DisplayUnit | None:
    """Return the display unit of a port; None where it has none, or another unit than its variable."""
    variable = port.variable
    if port.unit is None or variable.unit is None or port.unit != variable.unit:
        return None
    return variable.declared_units.display.get(variable.unit.name, {}).get(variable.display_unit)


def _type_definitions(root: ET.Element, ports: Iterable[Port]) -> dict[tuple[tuple[str, int], ...], str]:
    types: dict[tuple[tuple[str, int], ...], str] = {}
    for port in ports:
        if port.variable.type == "Enumeration":
            types.setdefault(_items(port), f"enumeration{len(types) + 1}")
    if types:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for items, name in types.items():
            simple = ET.SubElement(ET.SubElement(definitions, "SimpleType", name=name), "Enumeration")
            for item, value in items:
                ET.SubElement(simple, "Item", name=item, value=str(value))
    return types


def _items(port: Port) -> tuple[tuple[str, int], ...]:
    return tuple(port.variable.items.items())


def _experiment(root: ET.Element, contents: Contents) -> None:
    system = contents.system
    times = {"startTime": repr(seconds(system.start_time))}
    if system.stop_time is not None:
        times["stopTime"] = repr(seconds(system.stop_time))
    times["stepSize"] = repr(seconds(system.tick * contents.step_ticks))
    ET.SubElement(root, "DefaultExperiment", times)


def _variable(
    variables: ET.Element,
    number: int,
    port: Port,
    unit: str | None,
    types: Mapping[tuple[tuple[str, int], ...], str],
) -> None:
    variable = port.variable
    attributes = {"name": port.name, "valueReference": str(number)}
    if variable.description:
        attributes["description"] = variable.description
    attributes |= {"causality": port.kind, "variability": _variability(port)}
    if port.kind != "input":
        attributes["initial"] = "exact" if port.kind == "parameter" else "calculated"
    element = ET.SubElement(variables, "ScalarVariable", attributes)
    typed: dict[str, str] = {}
    if variable.type == "Enumeration":
        typed["declaredType"] = types[_items(port)]
    if variable.type == "Real":
        typed |= _real(port, unit)
    elif variable.type == "Integer":
        limits = {"min": variable.minimum, "max": variable.maximum}
        typed |= {key: str(int(value)) for key, value in limits.items() if value is not None}
    if port.start is not None:
        typed["start"] = _text(port)
    ET.SubElement(element, variable.type, typed)


def _real(port: Port, unit: str | None) -> dict[str, str]:
    variable = port.variable
    typed = {} if unit is None else {"unit": unit}
    if _display(port) is not None:
        typed["displayUnit"] = variable.display_unit
    if variable.relative:
        typed["relativeQuantity"] = _TRUE
    if (port.ends[0].gain, port.ends[0].bias) == (1.0, 0.0):
        limits = {"min": variable.minimum, "max": variable.maximum}
        typed |= {key: repr(value) for key, value in limits.items() if value is not None}
        typed |= {"nominal": repr(variable.nominal)} if variable.nominal != 1.0 else {}
    return typed


def _text(port: Port) -> str:
    if port.variable.type == "Boolean":
        return _TRUE if port.start else _FALSE
    if port.variable.type == "String":
        return str(port.start)
    number = port.start
    assert isinstance(number, int | float)
    return repr(float(number)) if port.variable.type == "Real" else str(int(number))


def _variability(port: Port) -> str:
    if port.kind == "parameter":
        return "tunable" if port.variable.variability == "tunable" else "fixed"
    return "continuous" if port.variable.type == "Real" and port.variable.variability == "continuous" else "discrete"


def _structure(root: ET.Element, contents: Contents) -> None:
    """Outputs depend on the inputs that reach their component in the same tick: it takes them in the step."""
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [(str(k + 1), port) for k, port in enumerate(contents.ports) if port.kind == "output"]
    if not outputs:
        return
    reaching = _reaching(contents)
    listed, initial = ET.SubElement(structure, "Outputs"), ET.SubElement(structure, "InitialUnknowns")
    for number, port in outputs:
        inputs = " ".join(map(str, reaching.get(port.ends[0].component, ())))
        ET.SubElement(listed, "Unknown", index=number, dependencies=inputs)
        ET.SubElement(initial, "Unknown", index=number)


def _reaching(contents: Contents) -> dict[str, list[int]]:
    """Return, by sampled component, the inputs, from 1, that reach it in the tick of a sample."""
    late = {task.name for task in contents.layout.schedule.tasks if task.after_row}
    found: dict[str, set[int]] = {name: set() for name in late}
    for number, port in enumerate(contents.ports):
        reached = {end.component for end in port.ends} & late if port.kind == "input" else set()
        while reached:
            name = reached.pop()
            found[name].add(number + 1)
            reached |= {
                c.to_component
                for c in contents.system.connections
                if c.delay == 0 and c.from_component == name and c.to_component in late
                and number + 1 not in found[c.to_component]
            }  # fmt: skip
    return {name: sorted(numbers) for name, numbers in found.items()}
