"""The XML of SSP: namespaces, schemas, units and values."""

from collections.abc import Mapping
from functools import cache

from lxml import etree  # type: ignore[import-untyped]

from lockstep.errors import InputError, compact
from lockstep.fmu import SSP_SCHEMAS
from lockstep.system import Value
from lockstep.units import BASES, Unit

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
LOCKSTEP = "urn:lockstep:1"
ANNOTATION = "lockstep"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
MAIN = "SystemStructure.ssd"  # of a folder or an archive
PARAMETERS = "SystemStructureParameterValues.xsd"
TYPES = ("Real", "Integer", "Boolean", "String")
NS = {"ssd": SSD, "ssc": SSC, "ssv": SSV, "lockstep": LOCKSTEP}


def parse(text: bytes, where: str, schema: str) -> etree._Element:
    """Parse and validate a document, or raise InputError. Entities are not expanded, nothing is fetched."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True)
    try:
        root = etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"{where}: not readable XML: {error.msg}") from None
    validate(root, where, schema)
    return root


def validate(element: etree._Element, where: str, schema: str) -> None:
    """Raise InputError with the line of the first thing that the schema refuses."""
    rules = _schema(schema)
    if not rules.validate(element):
        first = rules.error_log[0]
        raise InputError(f"{where}, line {first.line}: not valid SSP 1.0: {_short(first.message)}")


@cache
def _schema(name: str) -> etree.XMLSchema:
    return etree.XMLSchema(etree.parse(SSP_SCHEMAS / name))


def _short(text: str) -> str:
    for namespace in (SSD, SSC, SSV):
        text = text.replace(f"{{{namespace}}}", "")
    return text


def read_units(element: etree._Element) -> dict[str, Unit]:
    """Read the Units of an SSD document or of a parameter set."""
    found = {}
    namespace = etree.QName(element).namespace
    for unit in element.iterfind(f"{{{namespace}}}Units/{{{SSC}}}Unit"):
        base = unit.find("ssc:BaseUnit", NS)
        assert base is not None  # the schema demands it
        name = str(unit.get("name"))
        found[name] = Unit(
            name=name,
            exponents=tuple(int(base.get(symbol, "0")) for symbol in BASES),
            factor=float(base.get("factor", "1")),
            offset=float(base.get("offset", "0")),
        )
    return found


def unit_named(name: str, units: Mapping[str, Unit], what: str) -> Unit:
    """Look a unit up, or raise InputError."""
    if name not in units:
        raise InputError(f"{what}: unit {name!r} is not defined; the file defines {compact(units)}")
    return units[name]


def read_value(element: etree._Element, units: Mapping[str, Unit], what: str) -> tuple[Value, Unit | None]:
    """Read a typed value and its unit, if it has one."""
    kind, text = etree.QName(element).localname, str(element.get("value"))
    unit = element.get("unit")
    match kind:
        case "Real":
            return float(text), None if unit is None else unit_named(unit, units, what)
        case "Integer":
            return int(text), None
        case "Boolean":
            return text.strip() in ("true", "1"), None
        case "String":
            return text, None
    raise InputError(f"{what}: type {kind} is not supported; use one of {', '.join(TYPES)}")
