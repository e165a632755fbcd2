"""Name the namespaces, schemas and files of SSP; find, make and write elements."""

from collections.abc import Iterable, Mapping
from typing import Any

from lxml import etree  # type: ignore[import-untyped]

from lockstep.errors import InputError

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
Warnings = list[str]  # what was amended or left out, in the order in which it was found


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
