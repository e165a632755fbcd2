"""Write the model description of a bundle: FMI 3.0 for co-simulation, with arrays as variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
from lockstep.bundle.shown import Shown

_TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String", "Enumeration": "Enumeration"}
_FIRST = 1  # value reference of the first variable; that of the time is before it
_DENIED = (
    "providesDirectionalDerivatives",
    "providesAdjointDerivatives",
    "providesPerElementDependencies",
    "providesIntermediateUpdate",
    "mightReturnEarlyFromDoStep",
    "canReturnEarlyAfterIntermediateUpdate",
    "hasEventMode",
    "providesEvaluateDiscreteStates",
)


def model_description3(contents: Contents, token: str, variables: Sequence[Shown]) -> bytes:
    """Return modelDescription.xml; the ports of the contents are those of the variables, in their order."""
    system, ports = contents.system, contents.ports
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "3.0",
        "modelName": system.name,
        "instantiationToken": token,
        "description": summary(contents),
        "generationTool": "lockstep bundle",
        "variableNamingConvention": naming(variable.name for variable in variables),
    })  # fmt: skip
    denied = dict.fromkeys(_DENIED, FALSE)
    ET.SubElement(root, "CoSimulation", {"modelIdentifier": identifier(system.name)} | capabilities(contents) | denied)
    units, names = unit_names(ports)
    add_units(root, units, ports)
    types = enumerations(ports)
    _type_definitions(root, types)
    add_log_categories(root)
    add_experiment(root, contents)
    listed = ET.SubElement(root, "ModelVariables")
    _time(listed, variables)
    for number, variable in enumerate(variables, _FIRST):
        _variable(listed, number, variable, names.get(variable.first.name), types)
    _structure(root, contents, variables)
    return written(root)


def _type_definitions(root: ET.Element, types: Mapping[Items, str]) -> None:
    if types:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for items, name in types.items():
            element = ET.SubElement(definitions, "EnumerationType", name=name)
            for item, value in items:
                ET.SubElement(element, "Item", name=item, value=str(value))


def _time(listed: ET.Element, variables: Sequence[Shown]) -> None:
    name, taken = "time", {variable.name for variable in variables}
    while name in taken:
        name += "_"
    what = {"name": name, "valueReference": str(_FIRST - 1), "description": "time", "causality": "independent"}
    ET.SubElement(listed, "Float64", {**what, "variability": "continuous"})


def _variable(listed: ET.Element, number: int, variable: Shown, unit: str | None, types: Mapping[Items, str]) -> None:
    first = variable.first
    kind = first.variable.type
    attributes = {"name": variable.name, "valueReference": str(number)}
    if variable.description:
        attributes["description"] = variable.description
    attributes |= causality_attributes(first)
    if kind == "Enumeration":
        attributes["declaredType"] = types[items_of(first)]
    elif kind == "Real":
        attributes |= real_attributes(first, unit)
    elif kind == "Integer":
        attributes |= integer_attributes(first)
    starts = [start_text(port) for port in variable.ports] if first.start is not None else []
    if starts and kind != "String":
        attributes["start"] = " ".join(starts)
    element = ET.SubElement(listed, _TYPES[kind], attributes)
    for size in variable.dimensions:
        ET.SubElement(element, "Dimension", start=str(size))
    if kind == "String":
        for text in starts:
            ET.SubElement(element, "Start", value=text)


def _structure(root: ET.Element, contents: Contents, variables: Sequence[Shown]) -> None:
    """Outputs depend on the inputs that reach their component in the same tick: it takes them in the step."""
    structure = ET.SubElement(root, "ModelStructure")
    reaching = reaching_inputs(contents)
    references = [str(number) for number, variable in enumerate(variables, _FIRST) for _ in variable.ports]
    outputs = [(str(n), variable) for n, variable in enumerate(variables, _FIRST) if variable.first.kind == "output"]
    for number, variable in outputs:
        found = (references[port - 1] for one in variable.ports for port in reaching.get(one.ends[0].component, ()))
        ET.SubElement(structure, "Output", valueReference=number, dependencies=" ".join(dict.fromkeys(found)))
    for number, _ in outputs:
        ET.SubElement(structure, "InitialUnknown", valueReference=number)
