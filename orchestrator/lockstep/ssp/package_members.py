"""Collect a system description and every file that it names as the members of an SSP package."""

from pathlib import Path
from urllib.parse import quote, unquote

from lockstep.errors import InputError
from lockstep.ssp.annotations import flag
from lockstep.ssp.documents.parse import parse
from lockstep.ssp.documents.xml import ANNOTATION, DESCRIPTION, MAIN, NS, Element, document_bytes
from lockstep.ssp.native_fmu import NATIVE

_NAMED = "//ssd:Component | //ssd:ParameterBinding | //ssd:ParameterMapping | //ssd:SignalDictionary"


def package_entries(path: Path) -> dict[str, bytes]:
    """Return the members of the .ssp of a .ssd file by name: `SystemStructure.ssd`, and `resources/...`.

    Files are named by their last part; two of one name get numbers. In the description only `source` attributes change,
    and a component that asks for a native FMU has that as its source.

    Raises
    ------
    InputError
        If the description, or a file that it names, cannot be read.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot read the system description ({error.strerror})") from None
    root = parse(text, str(path), DESCRIPTION)
    members: dict[Path, str] = {}
    for element in root.xpath(_NAMED, namespaces=NS):
        source = element.get("source")
        if source is None or ":" in source.partition("/")[0]:  # inline, or a URI with a scheme
            continue
        if element.get("sourceBase", "SSD") != "SSD":  # inside a component
            continue
        if element.get("type") in ("application/x-ssp-definition", "application/x-ssp-package"):
            raise InputError(
                f"{path}: {element.get('name')}: refers to another system; package it by hand, or flatten it"
            )
        file = _named_file(element, path.parent / unquote(source))
        if file not in members:
            members[file] = _free_name(file.name, set(members.values()))
        element.set("source", quote(members[file]))
    entries = {}
    for file, member in members.items():
        try:
            entries[member] = file.read_bytes()
        except OSError as error:
            raise InputError(f"{path}: cannot read {file}, which it names ({error.strerror})") from None
    entries[MAIN] = document_bytes(root)
    return entries


def _named_file(element: Element, source: Path) -> Path:
    """Return the file that an element names, or the native FMU beside it if it asks for that; then it asks no more."""
    own = element.find(f"ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']/lockstep:Component[@native]", NS)
    if own is None:
        return source.resolve()
    native = flag(own, "native", str(element.get("name")))
    del own.attrib["native"]
    return (source.parent / NATIVE / source.name if native else source).resolve()


def _free_name(name: str, taken: set[str]) -> str:
    stem, dot, suffix = name.partition(".")
    member, number = f"resources/{name}", 1
    while member in taken:
        number += 1
        member = f"resources/{stem}_{number}{dot}{suffix}"
    return member
