"""Write the modelDescription.xml of a port table (FMI 2.0 co-simulation)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from ...ports.table import PortTable, Scalar, Variable
from ...ports.units import UNITS

_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}


@dataclass(frozen=True, slots=True, kw_only=True)
class About:
    """What a model description contains apart from the ports.

    Attributes
    ----------
    step_size : preferred, or only, communication step [s]
    any_step : whether other steps are accepted
    source_files : C files below sources/ that build the library; none for an FMU in Python
    derivatives : whether fmi2GetDirectionalDerivative gives those of outputs with respect to inputs
    execution_tool : whether a tool is declared to be needed, for a receiver that wants to be warned of Python
    date : ISO 8601, or None for builds that repeat byte by byte
    """

    model_name: str
    guid: str
    description: str
    version: str
    author: str
    license: str
    generation_tool: str
    step_size: float
    any_step: bool
    source_files: tuple[str, ...] = ()
    derivatives: bool = False
    execution_tool: bool = False
    stop_time: float | None = None
    date: str | None = None
    log_categories: Mapping[str, str] = field(default_factory=dict)


def about_component(shell: Any, build: Mapping[str, Any], generation_tool: str) -> About:
    """Return what the model description of a shell contains apart from its ports.

    Parameters
    ----------
    shell : whose class attributes describe it
    build : facts of the build, where it has them
    """
    kind = type(shell)
    return About(
        model_name=shell.modelName,
        guid=shell.guid,
        description=kind.description,
        version=str(build.get("version", kind.version)),
        author=kind.author,
        license=kind.license,
        generation_tool=generation_tool,
        step_size=shell.fixed_step or shell.preferred_step,
        any_step=shell.fixed_step is None and not shell.equal_steps,
        execution_tool=bool(build.get("needs_execution_tool", False)),
        stop_time=shell.stop_time,
        date=build_date(),
        log_categories=shell.log_categories,
    )


def build_date() -> str | None:
    """Return the date that SOURCE_DATE_EPOCH gives, as FMI writes it; None if the variable is not set."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    return datetime.fromtimestamp(int(epoch), UTC).strftime("%Y-%m-%dT%H:%M:%SZ") if epoch else None


def model_description(table: PortTable, about: About) -> Element:
    """Describe a component completely: units, variables, feedthrough, initial unknowns, capabilities."""
    root = description_root(table, about, "2.0", token="guid")
    kind = SubElement(root, "CoSimulation", _capabilities(about))
    if about.source_files:
        files = SubElement(kind, "SourceFiles")
        for name in about.source_files:
            SubElement(files, "File", {"name": name})
    add_units(root, {port.unit for port in table if port.kind == "real"})
    add_defaults(root, about)
    variables = SubElement(root, "ModelVariables")
    for variable in table.variables:
        _add_variable(variables, variable)
    _add_structure(root, table)
    return root


def description_root(table: PortTable, about: About, version: str, *, token: str) -> Element:
    """Return the empty description of a version of FMI, which names the attribute that identifies the FMU, `token`."""
    head = {
        "fmiVersion": version,
        "modelName": about.model_name,
        token: about.guid,
        "description": about.description,
        "author": about.author,
        "version": about.version,
        "license": about.license,
        "generationTool": about.generation_tool,
    }
    if about.date is not None:
        head["generationDateAndTime"] = about.date
    return Element("fmiModelDescription", head | {"variableNamingConvention": table.naming})


def add_defaults(root: Element, about: About) -> None:
    """Describe what can be logged, and the default experiment."""
    categories = SubElement(root, "LogCategories")
    for name, description in about.log_categories.items():
        SubElement(categories, "Category", {"name": name, "description": description})
    experiment = {"startTime": "0.0", "stepSize": value_text(about.step_size)}
    if about.stop_time is not None:
        experiment["stopTime"] = value_text(about.stop_time)
    SubElement(root, "DefaultExperiment", experiment)


def _capabilities(about: About) -> dict[str, str]:
    capabilities = {
        "modelIdentifier": about.model_name,
        # The model itself is in the FMU: Python is a library that it needs, as externalDependencies.txt says.
        "needsExecutionTool": value_text(about.execution_tool),
        "canHandleVariableCommunicationStepSize": value_text(about.any_step),
        "canInterpolateInputs": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": value_text(not about.source_files),
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    return capabilities | ({"providesDirectionalDerivative": "true"} if about.derivatives else {})


def add_units(root: Element, used: Set[str]) -> None:
    """Define the units in use; FMI 2.0 and 3.0 write them alike."""
    if not used:
        return
    definitions = SubElement(root, "UnitDefinitions")
    for name, unit in UNITS.items():
        if name in used:
            element = SubElement(definitions, "Unit", {"name": name})
            if unit.exponents is not None:
                SubElement(element, "BaseUnit", {base: str(exponent) for base, exponent in unit.exponents.items()})
            for shown, factor in unit.display.items():
                SubElement(element, "DisplayUnit", {"name": shown, "factor": value_text(factor)})


def _add_variable(variables: Element, variable: Variable) -> None:
    port = variable.port
    what = {
        "name": variable.name,
        "valueReference": str(variable.value_reference),
        "description": port.description if port.frame is None else f"{port.description} (frame: {port.frame})",
        "causality": port.causality,
        "variability": str(port.variability),
    }
    if port.causality != "input":  # FMI 2.0 forbids `initial` on inputs
        what["initial"] = "calculated" if port.causality == "output" else "exact"
    value = {}
    if port.kind == "real":
        value["unit"] = port.unit
        if port.display_unit is not None:
            value["displayUnit"] = port.display_unit
    number = int if port.kind == "integer" else float
    if port.minimum is not None:
        value["min"] = value_text(number(port.minimum))
    if port.maximum is not None:
        value["max"] = value_text(number(port.maximum))
    if port.causality != "output":
        start = port.starts[variable.element]
        value["start"] = value_text(float(start) if port.kind == "real" else start)
    SubElement(SubElement(variables, "ScalarVariable", what), _TAGS[port.kind], value)


def _add_structure(root: Element, table: PortTable) -> None:
    structure = SubElement(root, "ModelStructure")
    outputs = [variable for variable in table.variables if variable.port.causality == "output"]
    for tag, initial in (("Outputs", False), ("InitialUnknowns", True)) if outputs else ():
        unknowns = SubElement(structure, tag)
        for variable in outputs:
            known = table.dependencies(variable, initial=initial)
            SubElement(
                unknowns,
                "Unknown",
                {
                    "index": str(variable.index),
                    "dependencies": " ".join(map(str, known)),
                    "dependenciesKind": " ".join("dependent" for _ in known),
                },
            )


def value_text(value: Scalar) -> str:
    """Write a value so that reading it gives the same value again."""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)
