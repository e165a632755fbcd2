"""Read and write the XML documents of SSP: namespaces, validation against the schemas, elements and bytes."""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any
from xml.parsers import expat

from lxml import etree  # type: ignore[import-untyped]

from lockstep.errors import InputError
from lockstep.fmi.model_description import SSP_SCHEMAS

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
    """Refuse a document type: SSP has none, and entities in attributes would be expanded without limit."""
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


def local_name(element: Element) -> str:
    """Return a tag without its namespace."""
    return str(etree.QName(element).localname)


def namespace_of(element: Element) -> str:
    """Return the namespace of an element."""
    return str(etree.QName(element).namespace)


def new_root(namespace: str, tag: str, prefixes: Mapping[str, str], **attributes: str) -> Element:
    """Return the root of a new document with namespaces by prefix."""
    return etree.Element(f"{{{namespace}}}{tag}", attrib=attributes, nsmap=dict(prefixes))


def add(parent: Element, namespace: str, tag: str, **attributes: str) -> Element:
    """Add an element below another one."""
    return etree.SubElement(parent, f"{{{namespace}}}{tag}", attrib=attributes)


def document_bytes(root: Element) -> bytes:
    """Return a whole document as UTF-8 text with a declaration."""
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
