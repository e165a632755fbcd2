"""Amend SSP documents before they are read: small offences of other tools, and the parts of SSP 2.0 that 1.0 has too.

Each amendment is a warning that names its first place. What cannot be amended is left to the schema, which refuses it.
"""

from collections.abc import Iterator
from typing import Any

from lockstep.ssp.documents.expand_arrays import Shapes, expand_arrays, no_shapes
from lockstep.ssp.documents.xml import NS, SSC, SSV, Element, Warnings, local_name, namespace_of

_TYPES = {"Float64": "Real", "Float32": "Real"} | {
    f"{sign}Int{bits}": "Integer" for sign in ("", "U") for bits in (8, 16, 32, 64)
}
_SSP1 = "http://ssp-standard.org/SSP1/"
_SIZE = "structuralParameter"  # sizes of arrays, read before
_NOT_IN_1 = ("constant", "local", "unspecified")  # kinds of connectors
_VERSIONED = (
    "SystemStructureDescription",
    "ParameterSet",
    "ParameterMapping",
    "SignalDictionary",
)

_UNKNOWN_ATTRIBUTE, _UNEXPECTED = "SCHEMAV_CVC_COMPLEX_TYPE_3_2_1", "SCHEMAV_ELEMENT_CONTENT"
_ORDER = (  # of the children of systems, components and descriptions in SSP 1.0
    *("System", "Connectors", "ElementGeometry", "ParameterBindings", "Elements", "Connections", "SignalDictionaries"),
    *("SystemGeometry", "GraphicalElements", "Parameters", "Enumerations", "Units", "DefaultExperiment", "Annotations"),
)
_GROUPS = ("Connectors", "ParameterBindings", "Elements", "Connections", "Units", "Enumerations", "Annotations")


def amend(root: Element, where: str, warnings: Warnings, shapes: Shapes = no_shapes) -> None:
    """Amend a document in place; report each kind of amendment once, with its first place and the number of others."""
    if str(root.get("version", "")).startswith("2."):
        _reduce(root, where, warnings, shapes)
    _leave_out_empty(root, where, warnings)


def mend_first(root: Element, problem: Any, where: str, warnings: Warnings) -> bool:
    """Mend what a schema has objected to, if it can be left out or sorted; return whether it was."""
    if problem is None:
        return False
    found = root.getroottree().xpath(problem.path, namespaces=NS)
    if not found:
        return False
    element = found[0]
    at = f"{where}, line {problem.line}"
    if problem.type_name == _UNKNOWN_ATTRIBUTE:
        name = problem.message.split("attribute '")[1].split("'")[0]
        if name in element.attrib:
            del element.attrib[name]
            warnings.append(f"{at}: attribute {name} of {local_name(element)} is left out, as SSP has none")
            return True
    parent = element.getparent()
    if problem.type_name == _UNEXPECTED and parent is not None:
        if len(element) == 0 and local_name(element) in _GROUPS:
            parent.remove(element)
            warnings.append(f"{at}: {local_name(element)} of {local_name(parent)} is empty, and left out")
            return True
        first = parent.find(element.tag)
        if first is not element and local_name(element) in _GROUPS:
            first.extend(element)
            parent.remove(element)
            warnings.append(f"{at}: {local_name(element)} of {local_name(parent)} are there twice; both are read")
            return True
        order = {tag: number for number, tag in enumerate(_ORDER)}
        wanted = sorted(parent, key=lambda child: order.get(local_name(child), len(order)))
        if wanted != list(parent):
            parent[:] = wanted
            warnings.append(f"{at}: the children of {local_name(parent)} are not in the order of SSP")
            return True
    return False


def _leave_out_empty(root: Element, where: str, warnings: Warnings) -> None:
    """Remove empty attributes that mean: not given."""
    for attribute, meaning in (
        ("unit", "no unit"),
        ("startElement", "the system itself"),
        ("endElement", "the system itself"),
    ):
        found = [element for element in root.iter("{*}*") if element.get(attribute) == ""]
        for element in found:
            del element.attrib[attribute]
        _report(found, f'{attribute}="" is read as {meaning}', where, warnings)


def _reduce(root: Element, where: str, warnings: Warnings, shapes: Shapes) -> None:
    """Write the elements of SSP 2.0 as those of 1.0, as far as 1.0 has them."""
    for element in _of_ssp(root):
        if local_name(element) in _VERSIONED and str(element.get("version", "")).startswith("2."):
            element.set("version", "1.0")
    expand_arrays(root, where, shapes)
    scheduled = [e for e in _of_ssp(root) if e.get("implementation") == "ScheduledExecution"]
    for element in scheduled:
        element.set("implementation", "CoSimulation")
    _report(scheduled, "implementation ScheduledExecution is run as CoSimulation", where, warnings)
    _remove(root, ("MetaData", "Signature"), "", where, warnings)
    clocked = [clock for clock in root.iter("{*}Clock") if namespace_of(clock) != SSC]
    _detach(clocked)
    _report(clocked, "clocks are left out: connectors are exchanged at every step", where, warnings)
    connectors = [e for e in _of_ssp(root) if local_name(e) == "Connector"]
    ticking = [c for c in connectors if any(child.tag == f"{{{SSC}}}Clock" for child in c)]
    _detach(ticking)
    _report(ticking, "connectors of type Clock are left out", where, warnings)
    _detach([c for c in connectors if c.get("kind") == _SIZE])
    other = [c for c in connectors if c.get("kind") in _NOT_IN_1]
    _detach(other)
    _report(other, f"connectors of kind {', '.join(_NOT_IN_1)} are left out", where, warnings)
    for element in root.iter("{*}*"):
        for attribute in ("systemInnerX", "systemInnerY"):
            element.attrib.pop(attribute, None)
        if namespace_of(element) in (SSC, SSV) and local_name(element) in _TYPES:
            element.tag = f"{{{namespace_of(element)}}}{_TYPES[local_name(element)]}"


def _of_ssp(root: Element) -> Iterator[Element]:
    return (element for element in root.iter("{*}*") if namespace_of(element).startswith(_SSP1))


def _remove(root: Element, tags: tuple[str, ...], text: str, where: str, warnings: Warnings) -> None:
    found = [element for element in _of_ssp(root) if local_name(element) in tags]
    _detach(found)
    if text:
        _report(found, text, where, warnings)


def _detach(elements: list[Element]) -> None:
    for element in elements:
        element.getparent().remove(element)


def _report(found: list[Element], text: str, where: str, warnings: Warnings) -> None:
    if found:
        first = found[0]
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        warnings.append(f"{where}, line {first.sourceline}: {text}{more}")
