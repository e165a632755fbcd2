"""Read model descriptions of FMI 1.0 and 3.0 into the terms of FMI 2.0, in which the checks are written.

FMI 3.0 names variables by value reference where FMI 2.0 counts them; what it names and no variable has stays as it is
written. FMI 1.0 has parameters as internal variables, and no structure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from lxml import etree  # type: ignore[import-untyped]

from lockstep.check.static.model import (
    DEFAULT_INITIAL,
    Model,
    ScalarVariable,
    UnitDefinition,
    Unknown,
    read_model,
    words,
)
from lockstep.system.units import Unit

_REALS = ("Float32", "Float64")
_SAME = ("Boolean", "String", "Enumeration")  # of the types of FMI 3.0
_BOUNDS = ("min", "max", "nominal")
_FLAGS3 = {  # of FMI 3.0, as FMI 2.0 writes them
    "canGetAndSetFMUState": "canGetAndSetFMUstate",
    "canSerializeFMUState": "canSerializeFMUstate",
    "providesDirectionalDerivatives": "providesDirectionalDerivative",
}


def read_model_of(root: etree._Element) -> Model:
    """Read a model description of any version as far as the checks use it."""
    match root.get("fmiVersion", "")[:3]:
        case "3.0":
            return _read3(root)
        case "1.0":
            return _read1(root)
    return read_model(root)


def _read3(root: etree._Element) -> Model:
    base = read_model(root)
    types = {str(t.get("name", "")): t for t in root.iterfind("TypeDefinitions/*")}
    elements = list(root.iterfind("ModelVariables/*"))
    numbers = {str(element.get("valueReference")): str(k) for k, element in enumerate(elements, start=1)}
    flags = {_FLAGS3.get(name, name): value for name, value in (base.capabilities or {}).items()}
    return replace(
        base,
        capabilities=None if base.capabilities is None else flags,
        variables=tuple(_variable3(element, k, types, numbers) for k, element in enumerate(elements, start=1)),
        type_units={name: (t.get("unit", ""), t.get("displayUnit", "")) for name, t in types.items()},
        outputs=_unknowns3(root, "Output", numbers),
        derivatives=_unknowns3(root, "ContinuousStateDerivative", numbers),
        initial_unknowns=_unknowns3(root, "InitialUnknown", numbers),
    )


def _variable3(
    element: etree._Element, index: int, types: Mapping[str, etree._Element], numbers: Mapping[str, str]
) -> ScalarVariable:
    kind = etree.QName(element).localname
    declared = types.get(element.get("declaredType", ""))
    inherited: Mapping[str, str] = {} if declared is None else dict(declared.attrib)
    causality = element.get("causality", "local")
    usual = "fixed" if causality in ("parameter", "calculatedParameter", "structuralParameter") else "discrete"
    variability = element.get("variability") or ("continuous" if kind in _REALS and usual == "discrete" else usual)
    given = element.get("initial", "")
    if causality == "input" and given == "exact":  # the only one that FMI 3.0 has for an input
        given = ""
    clocked = kind == "Clock" or element.get("clocks") is not None  # unknown at initialization, and not listed there
    texts = [str(text.get("value", "")) for text in element.findall("Start")]
    derivative = element.get("derivative", "")
    # a size is set before initialization, like a parameter
    role = "parameter" if causality == "structuralParameter" else causality
    return ScalarVariable(
        index=index,
        line=element.sourceline,
        name=element.get("name", ""),
        reference=element.get("valueReference", ""),
        description=element.get("description", ""),
        causality=role,
        variability=variability,
        variability_given=True,  # FMI 3.0 has a default for each type
        initial="" if clocked else given or DEFAULT_INITIAL.get((variability, role), ""),
        initial_given=given,
        type="Real" if kind in _REALS else kind if kind in _SAME else "Integer" if "Int" in kind else "",
        start=_start3(element, texts),
        unit=element.get("unit") or inherited.get("unit", ""),
        display_unit=element.get("displayUnit") or inherited.get("displayUnit", ""),
        declared_type=element.get("declaredType", ""),
        derivative=numbers.get(derivative, derivative),
        bounds={n: text for n in _BOUNDS if (text := element.get(n) or inherited.get(n)) is not None},
    )


def _start3(element: etree._Element, texts: list[str]) -> str | None:
    """Return the first start value: the others of an array have the same range."""
    if texts:
        return texts[0]
    given = element.get("start")
    return given if given is None or not given.split() else str(given.split()[0])


def _unknowns3(root: etree._Element, tag: str, numbers: Mapping[str, str]) -> tuple[Unknown, ...]:
    found = []
    for element in root.iterfind(f"ModelStructure/{tag}"):
        reference, fed = element.get("valueReference", ""), words(element, "dependencies")
        found.append(
            Unknown(
                index=numbers.get(reference, f"valueReference {reference}"),
                line=element.sourceline,
                dependencies=None if fed is None else tuple(numbers.get(r, f"valueReference {r}") for r in fed),
                kinds=words(element, "dependenciesKind"),
            )
        )
    return tuple(found)


def _read1(root: etree._Element) -> Model:
    base = read_model(root)
    types = {str(t.get("name", "")): t[0] for t in root.iterfind("TypeDefinitions/Type") if len(t)}
    kinds = ("CoSimulation_StandAlone", "CoSimulation_Tool")
    simulation = next((s for kind in kinds if (s := root.find(f"Implementation/{kind}")) is not None), None)
    given = None if simulation is None else simulation.find("Capabilities")
    flags = {} if given is None else {str(name): str(value) for name, value in given.attrib.items()}
    return replace(
        base,
        capabilities=None if simulation is None else {**flags, "modelIdentifier": root.get("modelIdentifier", "")},
        variables=tuple(
            _variable1(v, element, types) for v, element in zip(base.variables, _scalars(root), strict=True)
        ),
        units=tuple(
            UnitDefinition(
                unit=Unit(name=unit.get("unit", "")),
                line=unit.sourceline,
                display=tuple(
                    (shown.get("displayUnit", ""), shown.get("gain", "1"), shown.get("offset", "0"))
                    for shown in unit.iterfind("DisplayUnitDefinition")
                ),
            )
            for unit in root.iterfind("UnitDefinitions/BaseUnit")
        ),
        type_units={name: (t.get("unit", ""), t.get("displayUnit", "")) for name, t in types.items()},
    )


def _scalars(root: etree._Element) -> list[etree._Element]:
    return list(root.iterfind("ModelVariables/*"))


def _variable1(v: ScalarVariable, element: etree._Element, types: Mapping[str, etree._Element]) -> ScalarVariable:
    causality, variability = element.get("causality", "internal"), v.variability
    if variability == "parameter":
        causality, variability = "parameter", "fixed"
    elif causality in ("internal", "none"):
        causality = "local"
    declared = types.get(v.declared_type)
    inherited: Mapping[str, str] = {} if declared is None else dict(declared.attrib)
    bounds = {name: text for name in _BOUNDS if (text := inherited.get(name)) is not None}
    return replace(
        v,
        causality=causality,
        variability=variability,
        variability_given=True,
        initial="exact" if causality == "parameter" else "",
        initial_given="",  # FMI 1.0 has `fixed` instead
        unit=v.unit or inherited.get("unit", ""),
        display_unit=v.display_unit or inherited.get("displayUnit", ""),
        bounds=bounds | dict(v.bounds),
    )
