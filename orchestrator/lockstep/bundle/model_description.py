"""Write the model description of a bundle: FMI 2.0 for co-simulation."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree as ET

from lockstep.bundle.contents import Contents
from lockstep.bundle.declared import (
    FALSE,
    Items,
    add_experiment,
    add_log_categories,
    add_units,
    capabilities,
    causality_attributes,
    enumerations,
    identifier,
    integer_attributes,
    items_of,
    naming,
    reaching_inputs,
    real_attributes,
    start_text,
    summary,
    unit_names,
    written,
)
from lockstep.bundle.ports import Port


def model_description(contents: Contents, guid: str) -> bytes:
    """Return modelDescription.xml."""
    system, ports = contents.system, contents.ports
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "2.0",
        "modelName": system.name,
        "guid": guid,
        "description": summary(contents),
        "generationTool": "lockstep bundle",
        "variableNamingConvention": naming(port.name for port in ports),
    })  # fmt: skip
    _co_simulation(root, contents)
    units, names = unit_names(ports)
    add_units(root, units, ports)
    types = enumerations(ports)
    _type_definitions(root, types)
    add_log_categories(root)
    add_experiment(root, contents)
    variables = ET.SubElement(root, "ModelVariables")
    for number, port in enumerate(ports):
        _variable(variables, number, port, names.get(port.name), types)
    _structure(root, contents)
    return written(root)


def _co_simulation(root: ET.Element, contents: Contents) -> None:
    able = capabilities(contents)
    flags = {
        "needsExecutionTool": able["needsExecutionTool"],
        "canHandleVariableCommunicationStepSize": able["canHandleVariableCommunicationStepSize"],
        "canInterpolateInputs": FALSE,
        "canRunAsynchronuously": FALSE,
        "canBeInstantiatedOnlyOncePerProcess": able["canBeInstantiatedOnlyOncePerProcess"],
        "canNotUseMemoryManagementFunctions": FALSE,
        "canGetAndSetFMUstate": able["canGetAndSetFMUState"],
        "canSerializeFMUstate": able["canSerializeFMUState"],
        "providesDirectionalDerivative": FALSE,
    }
    ET.SubElement(root, "CoSimulation", {"modelIdentifier": identifier(contents.system.name), **flags})


def _type_definitions(root: ET.Element, types: Mapping[Items, str]) -> None:
    if types:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for items, name in types.items():
            simple = ET.SubElement(ET.SubElement(definitions, "SimpleType", name=name), "Enumeration")
            for item, value in items:
                ET.SubElement(simple, "Item", name=item, value=str(value))


def _variable(variables: ET.Element, number: int, port: Port, unit: str | None, types: Mapping[Items, str]) -> None:
    variable = port.variable
    attributes = {"name": port.name, "valueReference": str(number)}
    if variable.description:
        attributes["description"] = variable.description
    element = ET.SubElement(variables, "ScalarVariable", attributes | causality_attributes(port))
    typed: dict[str, str] = {}
    if variable.type == "Enumeration":
        typed["declaredType"] = types[items_of(port)]
    if variable.type == "Real":
        typed |= real_attributes(port, unit)
    elif variable.type == "Integer":
        typed |= integer_attributes(port)
    if port.start is not None:
        typed["start"] = start_text(port)
    ET.SubElement(element, variable.type, typed)


def _structure(root: ET.Element, contents: Contents) -> None:
    """Outputs depend on the inputs that reach their component in the same tick: it takes them in the step."""
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [(str(k + 1), port) for k, port in enumerate(contents.ports) if port.kind == "output"]
    if not outputs:
        return
    reaching = reaching_inputs(contents)
    listed, initial = ET.SubElement(structure, "Outputs"), ET.SubElement(structure, "InitialUnknowns")
    for number, port in outputs:
        inputs = " ".join(map(str, reaching.get(port.ends[0].component, ())))
        ET.SubElement(listed, "Unknown", index=number, dependencies=inputs)
        ET.SubElement(initial, "Unknown", index=number)
