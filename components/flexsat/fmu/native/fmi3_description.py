"""Write what an FMU of FMI 3.0 declares: modelDescription.xml with a variable a port, and buildDescription.xml."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from ...ports.table import Kind, Port, PortTable
from ..python.model_description import About, add_defaults, add_units, description_root, value_text

TYPES: dict[Kind, str] = {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "string": "String"}
TIME = 0  # value reference of the independent variable
TIME_UNIT = "s"
LANGUAGE = "C99"
OPTIONS = "-O2 -ffp-contract=off"  # of gcc and clang, so that results are the same on every processor


def fmi3_model_description(table: PortTable, about: About) -> Element:
    """Describe a component completely: units, variables, feedthrough, initial unknowns, capabilities."""
    root = description_root(table, about, "3.0", token="instantiationToken")
    SubElement(root, "CoSimulation", _capabilities(about))
    add_units(root, {TIME_UNIT} | {port.unit for port in table if port.kind == "real"})
    add_defaults(root, about)
    variables = SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": str(TIME), "description": "time", "causality": "independent"}
    SubElement(variables, "Float64", {**time, "variability": "continuous", "unit": TIME_UNIT})
    for port in table:
        _add_variable(variables, table, port)
    _add_structure(root, table)
    return root


def build_description(about: About) -> Element:
    """Describe how the library is built from the C files of the folder sources/."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    build = SubElement(root, "BuildConfiguration", {"modelIdentifier": about.model_name})
    files = SubElement(build, "SourceFileSet", {"language": LANGUAGE, "compilerOptions": OPTIONS})
    for name in about.source_files:
        SubElement(files, "SourceFile", {"name": name})
    SubElement(build, "Library", {"name": "m", "external": "true", "description": "mathematics of the C library"})
    return root


def _capabilities(about: About) -> dict[str, str]:
    return {
        "modelIdentifier": about.model_name,
        "needsExecutionTool": value_text(about.execution_tool),
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": value_text(about.derivatives),
        "providesAdjointDerivatives": "false",
        "providesPerElementDependencies": "false",
        "canHandleVariableCommunicationStepSize": value_text(about.any_step),
        "maxOutputDerivativeOrder": "0",
        "providesIntermediateUpdate": "false",
        "mightReturnEarlyFromDoStep": "false",
        "canReturnEarlyAfterIntermediateUpdate": "false",
        "hasEventMode": "false",
        "providesEvaluateDiscreteStates": "false",
    }


def _add_variable(variables: Element, table: PortTable, port: Port) -> None:
    what = {
        "name": port.name,
        "valueReference": str(table.array_reference(port.name)),
        "description": port.description if port.frame is None else f"{port.description} (frame: {port.frame})",
        "causality": port.causality,
        "variability": str(port.variability),
    }
    if port.causality != "input":
        what["initial"] = "calculated" if port.causality == "output" else "exact"
    if port.kind == "real":
        what["unit"] = port.unit
        if port.display_unit is not None:
            what["displayUnit"] = port.display_unit
    number = int if port.kind == "integer" else float
    if port.minimum is not None:
        what["min"] = value_text(number(port.minimum))
    if port.maximum is not None:
        what["max"] = value_text(number(port.maximum))
    given = port.starts if port.causality != "output" else ()
    if given and port.kind != "string":
        what["start"] = " ".join(value_text(float(v) if port.kind == "real" else v) for v in given)
    element = SubElement(variables, TYPES[port.kind], what)
    if port.size is not None:
        SubElement(element, "Dimension", {"start": str(port.size)})
    if port.kind == "string":
        for value in given:
            SubElement(element, "Start", {"value": str(value)})


def _add_structure(root: Element, table: PortTable) -> None:
    structure = SubElement(root, "ModelStructure")
    outputs = [port for port in table if port.causality == "output"]
    for tag, initial in (("Output", False), ("InitialUnknown", True)):
        for port in outputs:
            known = [str(table.array_reference(name)) for name in table.array_dependencies(port, initial=initial)]
            what = {"valueReference": str(table.array_reference(port.name)), "dependencies": " ".join(known)}
            SubElement(structure, tag, {**what, "dependenciesKind": " ".join("dependent" for _ in known)})
