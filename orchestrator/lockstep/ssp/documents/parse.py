"""Parse the XML documents of SSP, amend small offences, and validate them against the schemas of SSP 1.0."""

import re
from functools import cache
from xml.parsers import expat

from lxml import etree  # type: ignore[import-untyped]

from lockstep.errors import InputError
from lockstep.fmi.model_description import SSP_SCHEMAS
from lockstep.ssp.documents.amend import amend, mend_first
from lockstep.ssp.documents.expand_arrays import Shapes, no_shapes
from lockstep.ssp.documents.xml import NS, SSB, SSC, SSD, SSM, SSV, Element, Warnings

_PREFIXES = {prefix: namespace for prefix, namespace in NS.items() if prefix != "lockstep"}
_REMEDY = "give a file of SSP 1.0, or repair this one"
_ROOT = re.compile(rb"<[A-Za-z_][\w.:-]*")  # what begins the first element


def parse(
    text: bytes, where: str, schema: str, warnings: Warnings | None = None, shapes: Shapes = no_shapes
) -> Element:
    """Parse, amend and validate a document, or raise InputError. Nothing is fetched, and no entity can be declared.

    Amendments are added to the warnings; without a list for them nothing is amended, and the schema refuses more.
    `shapes` has the sizes of arrays that the file does not give.
    """
    root = secure_root(text, where, warnings)
    if warnings is not None:
        amend(root, where, warnings, shapes)
        while mend_first(root, _problem(root, schema), where, warnings):
            pass
    validate(root, where, schema)
    return root


def secure_root(text: bytes, where: str, warnings: Warnings | None = None) -> Element:
    """Return the root of any XML document, or raise InputError. Nothing is fetched, and no entity can be declared.

    With a list for warnings, prefixes of SSP's namespaces need no declaration.
    """
    _refuse_entities(text, where)
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True)
    while True:
        try:
            return etree.fromstring(text, parser)
        except etree.XMLSyntaxError as error:
            found = re.match(r"Namespace prefix (\w+) ", error.msg or "")
            prefix = found[1] if found else ""
            attribute = f'xmlns:{prefix}="{_PREFIXES.get(prefix)}"'
            if warnings is None or prefix not in _PREFIXES or attribute.encode() in text:
                raise InputError(f"{where}: not readable XML: {error.msg}; {_REMEDY}") from None
            text = _ROOT.sub(rb"\g<0> " + attribute.encode(), text, count=1)
            warnings.append(f"{where}: prefix {prefix} is not declared; {_PREFIXES[prefix]} is used")


def validate(element: Element, where: str, schema: str) -> None:
    """Raise InputError with the line of the first thing that the schema refuses."""
    name = schema.partition(".")[0]
    tag, version = etree.QName(element), element.get("version", "")
    if not tag.namespace or not tag.namespace.endswith(f"/SSP1/{name}"):
        raise InputError(
            f"{where}: its root {tag.localname} in namespace {tag.namespace} is not one of SSP 1.0's {name}"
        )
    if not version.startswith("1."):
        raise InputError(f"{where}: version {version!r} is not supported; write it as SSP 1.0 or 2.0")
    first = _problem(element, schema)
    if first is not None:
        raise InputError(f"{where}, line {first.line}: not valid SSP 1.0: {_short(first.message)}")


def _problem(element: Element, schema: str) -> Element | None:
    """Return the first entry of the error log of a validation; None for a valid document."""
    rules = _schema(schema)
    return None if rules.validate(element) else rules.error_log[0]


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
        raise InputError(f"{where}: not readable XML: {error}; {_REMEDY}") from None
