"""Write simulation resource meta data (SSP Traceability 1.0): what a file is, where it comes from, and its checksum."""

import hashlib
from collections.abc import Mapping

from lxml import etree  # type: ignore[import-untyped]

SRMD = "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData"
STC = "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"


def srmd_bytes(
    name: str,
    data: str,
    content: bytes,
    classifications: Mapping[str, Mapping[str, str]],
    head: Mapping[str, str] | None = None,
) -> bytes:
    """Describe one file.

    Parameters
    ----------
    name : shown to people
    data : URI of the file, relative to where the meta data will lie
    content : the file's bytes; their SHA3-256, the one checksum that the standard allows, is written down
    classifications : keyword to text, by the reverse domain name of each classification
    head : attributes such as `description`, `license`, `generationTool`
    """
    attributes = {
        "version": "1.0.0",
        "name": name,
        "data": data,
        "checksum": hashlib.sha3_256(content).hexdigest(),
        "checksumType": "SHA3-256",
    }
    root = etree.Element(
        f"{{{SRMD}}}SimulationResourceMetaData",
        attrib={**attributes, **(head or {})},
        nsmap={"srmd": SRMD, "stc": STC},
    )
    for kind, entries in classifications.items():
        group = etree.SubElement(root, f"{{{STC}}}Classification", attrib={"type": kind})
        for keyword, text in entries.items():
            etree.SubElement(group, f"{{{STC}}}ClassificationEntry", attrib={"keyword": keyword}).text = text
    written: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return written
