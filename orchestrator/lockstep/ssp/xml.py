"""The XML of SSP: namespaces, schemas, units, enumerations, values and transformations."""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any
from xml.parsers import expat

from lxml import etree  # type: ignore[import-untyped]

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import SSP_SCHEMAS
from lockstep.system.component import Value
from lockstep.system.transformation import Entry, Hop, Table
from lockstep.system.units import BASES, Unit

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SSB = "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
LOCKSTEP = "urn:lockstep:1"
ANNOTATION = "lockstep"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
MAIN = "SystemStructure.ssd"  # of a folder or an archive
DESCRIPTION = "SystemStructureDescription.xsd"
PARAMETERS = "SystemStructureParameterValues.xsd"
MAPPING = "SystemStructureParameterMapping.xsd"
DICTIONARY = "SystemStructureSignalDictionary.xsd"
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
NS = {"ssd": SSD, "ssc": SSC, "ssv": SSV, "ssm": SSM, "ssb": SSB, "lockstep": LOCKSTEP, "osp": OSP}

Element = Any  # lxml declares no types


def parse(text: bytes, where: str, schema: str) -> Element:
    """Parse and validate a document, or raise InputError. Nothing is fetched, and no entity can be declared."""
    _refuse_entities(text, where)
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True)
    try:
        root = etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"{where}: not readable XML: {error.msg}") from None
    validate(root, where, schema)
    return root


def validate(element: Element, where: str, schema: str) -> None:
    """Raise InputError with the line of the first thing that the schema refuses."""
    name = schema.partition(".")[0]
    tag, version = etree.QName(element), element.get("version", "")
    if not tag.namespace or not tag.namespace.endswith(f"/SSP1/{name}"):
        raise InputError(
            f"{where}: its root {tag.localname} in namespace {tag.namespace} is not one of SSP 1.0's {name}"
        )
    if not version.startswith("1."):
        raise InputError(f"{where}: version {version!r} is not supported; write it as SSP 1.0")
    rules = _schema(schema)
    if not rules.validate(element):
        first = rules.error_log[0]
        raise InputError(f"{where}, line {first.line}: not valid SSP 1.0: {_short(first.message)}")


@cache
def _schema(name: str) -> etree.XMLSchema:
    return etree.XMLSchema(etree.parse(SSP_SCHEMAS / name))


def _short(text: str) -> str:
    for namespace in (SSD, SSC, SSV, SSM, SSB):
        text = text.replace(f"{{{namespace}}}", "")
    return text


class _DocumentType(Exception):  # no error: it stops the parser
    pass


def _refuse_entities(text: bytes, where: str) -> None:
    """Refuse a document type: SSP has none, and entities in attributes would be expanded, a billion laughs included."""
    scan = expat.ParserCreate()

    def found(*_: object) -> None:
        raise _DocumentType

    scan.StartDoctypeDeclHandler = found
    try:
        scan.Parse(text, True)
    except _DocumentType:
        raise InputError(f"{where}: holds a document type, which may declare entities; remove <!DOCTYPE ...>") from None
    except expat.ExpatError as error:
        raise InputError(f"{where}: not readable XML: {error}") from None


def unique(names: Iterable[str], what: str) -> None:
    """Raise InputError for a name that is there twice; `what` comes before it in the message."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"{what}{name}: declared twice; names must be unique")
        seen.add(name)


def read_units(element: Element, where: str) -> dict[str, Unit]:
    """Read the Units of an SSD document or of a parameter set."""
    found = {}
    entries = _top_level(element, "Units", "Unit")
    unique((str(unit.get("name")) for unit in entries), f"{where}: unit ")
    for unit in entries:
        base = unit.find("ssc:BaseUnit", NS)
        assert base is not None  # the schema demands it
        name, factor = str(unit.get("name")), float(base.get("factor", "1"))
        if factor == 0.0:
            raise InputError(f"{where}: unit {name}: its factor must not be 0")
        found[name] = Unit(
            name=name,
            exponents=tuple(int(base.get(symbol, "0")) for symbol in BASES),
            factor=factor,
            offset=float(base.get("offset", "0")),
        )
    return found


def read_enumerations(element: Element, where: str) -> dict[str, dict[str, int]]:
    """Read the Enumerations of an SSD document or of a parameter set: value by item, by enumeration."""
    entries = _top_level(element, "Enumerations", "Enumeration")
    unique((str(entry.get("name")) for entry in entries), f"{where}: enumeration ")
    found = {}
    for entry in entries:
        items = entry.findall("ssc:Item", NS)
        unique((str(item.get("name")) for item in items), f"{where}: enumeration {entry.get('name')}: item ")
        found[str(entry.get("name"))] = {str(item.get("name")): int(item.get("value")) for item in items}
    return found


def _top_level(element: Element, group: str, tag: str) -> list[Element]:
    namespace = etree.QName(element).namespace
    return list(element.iterfind(f"{{{namespace}}}{group}/{{{SSC}}}{tag}"))


def unit_named(name: str, units: Mapping[str, Unit], what: str) -> Unit:
    """Look a unit up, or raise InputError."""
    if name not in units:
        raise InputError(f"{what}: unit {name!r} is not defined; the file defines {compact(units)}")
    return units[name]


def read_value(
    element: Element, units: Mapping[str, Unit], enumerations: Mapping[str, Mapping[str, int]], what: str
) -> tuple[Value, Unit | None]:
    """Read a typed value and its unit, if it has one. An Enumeration's value is the name of its item."""
    kind, text = local_name(element), str(element.get("value"))
    unit = element.get("unit")
    match kind:
        case "Real":
            return _number(text), None if unit is None else unit_named(unit, units, what)
        case "Integer":
            return int(text), None
        case "Boolean":
            return boolean(text), None
        case "String":
            return text, None
        case "Enumeration":
            items = items_of(element, enumerations, what)
            if items and text not in items:
                raise InputError(f"{what}: no item {text}; there are {compact(items)}{suggestion(text, items)}")
            return text, None
    raise InputError(f"{what}: type {kind} is not supported; use one of {', '.join(TYPES)}")


def items_of(element: Element, enumerations: Mapping[str, Mapping[str, int]], what: str) -> Mapping[str, int]:
    """Return the items of the enumeration that a type names; nothing if it names none."""
    name = element.get("name")
    if name is None:
        return {}
    if name not in enumerations:
        raise InputError(f"{what}: enumeration {name!r} is not defined; the file defines {compact(enumerations)}")
    return enumerations[name]


def read_hop(element: Element) -> Hop:
    """Read the transformation of a Connection or MappingEntry, and whether it converts units."""
    converts = not boolean(element.get("suppressUnitConversion", "false"))
    for child in element:
        tag = local_name(child)
        if tag == "LinearTransformation":
            factor, offset = _number(child.get("factor", "1")), _number(child.get("offset", "0"))
            return Hop(factor=factor, offset=offset, convert_units=converts)
        if tag.endswith("MappingTransformation"):
            kind = tag.removesuffix("MappingTransformation")
            entries = ((_entry(kind, e.get("source")), _entry(kind, e.get("target"))) for e in child)
            return Hop(table=Table(kind=kind, entries=tuple(entries)), convert_units=converts)  # type: ignore[arg-type]
    return Hop(convert_units=converts)


def _entry(kind: str, text: str) -> Entry:
    match kind:
        case "Boolean":
            return boolean(text)
        case "Integer":
            return int(text)
    return text


def boolean(text: str) -> bool:
    """Read an xs:boolean that the schema has accepted."""
    return text.strip() in ("true", "1")


def _number(text: str) -> float:
    return float(text.replace("INF", "inf"))  # xs:double


def local_name(element: Element) -> str:
    """Return a tag without its namespace."""
    return str(etree.QName(element).localname)
