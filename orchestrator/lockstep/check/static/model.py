"""Read a model description leniently, so that the checks can examine what a strict reader refuses."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from lxml import etree  # type: ignore[import-untyped]

from lockstep.system.units import BASES, Unit

TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
NUMBERS = ("Real", "Integer", "Enumeration")

# Default of `initial` by variability and causality; the combinations that are absent are forbidden. FMI 2.0.4, 2.2.7.
DEFAULT_INITIAL = {
    ("constant", "output"): "exact",
    ("constant", "local"): "exact",
    ("fixed", "parameter"): "exact",
    ("fixed", "calculatedParameter"): "calculated",
    ("fixed", "local"): "calculated",
    ("tunable", "parameter"): "exact",
    ("tunable", "calculatedParameter"): "calculated",
    ("tunable", "local"): "calculated",
    ("discrete", "input"): "",
    ("discrete", "output"): "calculated",
    ("discrete", "local"): "calculated",
    ("continuous", "input"): "",
    ("continuous", "output"): "calculated",
    ("continuous", "local"): "calculated",
    ("continuous", "independent"): "",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ScalarVariable:
    """One ScalarVariable; an attribute that is absent from the file is empty, unless FMI gives it a default."""

    index: int  # from 1, as ModelStructure counts
    line: int
    name: str
    reference: str
    description: str
    causality: str
    variability: str
    variability_given: bool
    initial: str  # with FMI's default
    initial_given: str
    type: str  # empty if there is no type element
    start: str | None
    unit: str
    display_unit: str
    declared_type: str
    derivative: str  # index of the state, as written
    bounds: Mapping[str, str]  # min, max and nominal, where given here or by the declared type

    @property
    def label(self) -> str:
        """Name the variable and its line."""
        return f"{self.name} (line {self.line})"


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitDefinition:
    """One Unit: `unit` has no exponents if there is no BaseUnit."""

    unit: Unit
    line: int
    display: tuple[tuple[str, str, str], ...]  # name, factor, offset, as written


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknown:
    """One entry of ModelStructure, as written; None where the attribute is absent."""

    index: str
    line: int
    dependencies: tuple[str, ...] | None
    kinds: tuple[str, ...] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model description."""

    root: etree._Element
    attributes: Mapping[str, str]
    capabilities: Mapping[str, str] | None  # of CoSimulation; None without it
    experiment: Mapping[str, str] | None
    variables: tuple[ScalarVariable, ...]
    units: tuple[UnitDefinition, ...]
    type_units: Mapping[str, tuple[str, str]]  # unit and display unit of each simple type
    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    initial_unknowns: tuple[Unknown, ...]

    @property
    def version(self) -> str:
        """Return the version of FMI: 1.0, 2.0 or 3.0."""
        return self.attributes.get("fmiVersion", "")[:3]

    @property
    def identifier(self) -> str:
        """Return the model identifier of the co-simulation part, which names the binary."""
        return (self.capabilities or {}).get("modelIdentifier", "")

    def can(self, flag: str) -> bool:
        """Return whether a capability flag is set; absent means false."""
        return (self.capabilities or {}).get(flag, "false").strip() in ("true", "1")

    def unit_named(self, name: str) -> Unit | None:
        """Return a unit by name: None without a name, known by its name alone if it is not defined."""
        if not name:
            return None
        return next((found.unit for found in self.units if found.unit.name == name), Unit(name=name))


def parse_xml(text: bytes) -> etree._Element:
    """Parse a document; raise ValueError with line and reason. Entities are not expanded, nothing is fetched."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True)
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise ValueError(f"line {error.lineno}: {error.msg}") from None


def read_model(root: etree._Element) -> Model:
    """Read the parts of a model description of FMI 2.0 that the checks use."""
    types = {str(t.get("name", "")): t[0] for t in root.iterfind("TypeDefinitions/SimpleType") if len(t)}
    simulation, experiment = root.find("CoSimulation"), root.find("DefaultExperiment")
    return Model(
        root=root,
        attributes=dict(root.attrib),
        capabilities=None if simulation is None else dict(simulation.attrib),
        experiment=None if experiment is None else dict(experiment.attrib),
        variables=tuple(
            _scalar(element, index, types) for index, element in enumerate(root.iterfind("ModelVariables/*"), start=1)
        ),
        units=tuple(_unit(element) for element in root.iterfind("UnitDefinitions/Unit")),
        type_units={name: (t.get("unit", ""), t.get("displayUnit", "")) for name, t in types.items()},
        outputs=_unknowns(root, "Outputs"),
        derivatives=_unknowns(root, "Derivatives"),
        initial_unknowns=_unknowns(root, "InitialUnknowns"),
    )


def _scalar(element: etree._Element, index: int, types: Mapping[str, etree._Element]) -> ScalarVariable:
    value = next((child for child in element if etree.QName(child).localname in TYPES), None)
    kind = "" if value is None else etree.QName(value).localname
    given: Mapping[str, str] = {} if value is None else dict(value.attrib)
    declared = types.get(given.get("declaredType", ""))
    inherited: Mapping[str, str] = {} if declared is None else dict(declared.attrib)
    causality = element.get("causality", "local")
    # FMI's default is continuous, but only a Real may be that: what the maker meant is discrete
    variability = element.get("variability") or ("continuous" if kind in ("Real", "") else "discrete")
    initial = element.get("initial", "")
    return ScalarVariable(
        index=index,
        line=element.sourceline,
        name=element.get("name", ""),
        reference=element.get("valueReference", ""),
        description=element.get("description", ""),
        causality=causality,
        variability=variability,
        variability_given="variability" in element.attrib,
        initial=initial or DEFAULT_INITIAL.get((variability, causality), ""),
        initial_given=initial,
        type=kind,
        start=given.get("start"),
        unit=given.get("unit") or inherited.get("unit", ""),
        display_unit=given.get("displayUnit") or inherited.get("displayUnit", ""),
        declared_type=given.get("declaredType", ""),
        derivative=given.get("derivative", ""),
        bounds={
            name: text
            for name in ("min", "max", "nominal")
            if (text := given.get(name) or inherited.get(name)) is not None
        },
    )


def _unit(element: etree._Element) -> UnitDefinition:
    name, base = element.get("name", ""), element.find("BaseUnit")
    unit = Unit(name=name)
    if base is not None:
        exponents = tuple(_whole(base.get(symbol, "0")) for symbol in BASES)
        factor, offset = number(base.get("factor", "1")), number(base.get("offset", "0"))
        unit = Unit(name=name, exponents=exponents, factor=factor, offset=offset)
    display = tuple(
        (shown.get("name", ""), shown.get("factor", "1"), shown.get("offset", "0"))
        for shown in element.iterfind("DisplayUnit")
    )
    return UnitDefinition(unit=unit, line=element.sourceline, display=display)


def words(element: etree._Element, name: str) -> tuple[str, ...] | None:
    """Return the words of an attribute, None if there is none."""
    text = element.get(name)
    return None if text is None else tuple(text.split())


def _unknowns(root: etree._Element, tag: str) -> tuple[Unknown, ...]:
    return tuple(
        Unknown(
            index=element.get("index", ""),
            line=element.sourceline,
            dependencies=words(element, "dependencies"),
            kinds=words(element, "dependenciesKind"),
        )
        for element in root.iterfind(f"ModelStructure/{tag}/Unknown")
    )


def _whole(text: str) -> int:
    value = number(text)
    return int(value) if math.isfinite(value) else 0


def number(text: str) -> float:
    """Read a number as XML writes it (INF is accepted); 0 for anything else, which the schema check reports."""
    try:
        return float(text)
    except ValueError:
        return 0.0


def duplicates(items: list[str]) -> list[str]:
    """Return what occurs more than once, in order."""
    return [item for item, count in Counter(items).items() if count > 1]
