"""Write simulation resource meta data (SSP Traceability 1.0): kind, origin and checksum of a file."""

import hashlib
from collections.abc import Mapping

from lockstep.ssp.documents.xml import add, document_bytes, new_root

SRMD = "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData"
STC = "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"


def srmd_bytes(
    name: str,
    data: str,
    content: bytes,
    classifications: Mapping[str, Mapping[str, str]],
    head: Mapping[str, str] | None = None,
) -> bytes:
    """Return the meta data of one file.

    Parameters
    ----------
    name : for display
    data : URI of the file, relative to the folder of the meta data
    content : the file's bytes; their SHA3-256, the one checksum that the standard allows, is included
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
    root = new_root(SRMD, "SimulationResourceMetaData", {"srmd": SRMD, "stc": STC}, **attributes, **(head or {}))
    for kind, entries in classifications.items():
        group = add(root, STC, "Classification", type=kind)
        for keyword, text in entries.items():
            add(group, STC, "ClassificationEntry", keyword=keyword).text = text
    return document_bytes(root)
