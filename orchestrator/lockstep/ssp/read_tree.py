"""Read an SSD and every SSD that it refers to into one tree of systems and components."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count

from lockstep.array_names import elements_of
from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import read_description
from lockstep.ssp.annotations import (
    SYSTEM_ATTRIBUTES,
    DeclaredSteps,
    annotation,
    connection_delay,
    declared_steps,
)
from lockstep.ssp.documents.location import Location
from lockstep.ssp.documents.parse import parse
from lockstep.ssp.documents.xml import ANNOTATION, DESCRIPTION, MAIN, NS, SSC, Element, Warnings, local_name, unique
from lockstep.ssp.native_fmu import native_location
from lockstep.ssp.parameter_bindings import Base, read_bindings
from lockstep.ssp.signal_dictionary import Dictionary, read_bus, read_dictionaries
from lockstep.ssp.tree import Branch, Bus, End, Leaf, Port, Wire, joined, with_more
from lockstep.ssp.typed_values import TYPES, items_of, read_enumerations, read_hop, read_units, unit_named
from lockstep.system.clock import nanoseconds
from lockstep.system.component import Component
from lockstep.system.units import Unit

_FMU = "application/x-fmu-sharedlibrary"
_MOST, _DEEPEST = 10_000, 60  # elements of all documents; levels: an archive may hold itself
_SSD, _SSP = "application/x-ssp-definition", "application/x-ssp-package"


@dataclass(frozen=True, slots=True, kw_only=True)
class Document:
    """A parsed SSD, with the units, enumerations and dictionaries that its elements may refer to."""

    location: Location
    root: Element
    units: Mapping[str, Unit]
    enumerations: Mapping[str, Mapping[str, int]]
    opened: tuple[str, ...]  # this document and those that refer to it: none may be opened again
    elements: Iterator[int]  # counts those of all documents
    dictionaries: Mapping[str, Dictionary] = field(default_factory=dict)  # of the system at hand and those around it


def open_description(location: Location, outer: Document | None = None, name: str = "") -> Document:
    """Parse and validate an SSD, that of the component `name` of another document if given, or raise InputError."""
    text = location.read(name or str(location))
    root = parse(text, str(location), DESCRIPTION, location.warnings, partial(_shape, location))
    units, enumerations = read_units(root, str(location)), read_enumerations(root, str(location))
    own = root.find(f"ssd:System/ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']", NS) is not None
    return Document(
        location=replace(location, home=None) if own else location,
        root=root,
        units=units,
        enumerations=enumerations,
        opened=(*(outer.opened if outer else ()), str(location)),
        elements=outer.elements if outer else count(1),
    )


def _shape(location: Location, component: Element, connector: str) -> list[str]:
    """Return the indices of the elements of an FMU's array, none if there is no such FMU or array."""
    if component.get("type", _FMU) != _FMU or not component.get("source"):
        return []
    name = str(component.get("name"))
    file = _fmu_location(replace(location, home=None, warnings=[]), component, declared_steps(component, name), name)
    description = read_description(Component(name="array", source=file.document, archive=file.archive, period=1))
    return [element.removeprefix(connector) for element in elements_of(connector, description.variables)]


def read_tree(document: Document) -> Branch:
    """Return the system of a document with all systems inside and referred to, or raise InputError."""
    system = document.root.find("ssd:System", NS)
    assert system is not None  # the schema demands it
    return _system(system, document, "", 0)


def _system(element: Element, document: Document, path: str, level: int) -> Branch:
    name = path or "the system"
    own = annotation(element, "System", name, SYSTEM_ATTRIBUTES)
    defined = read_dictionaries(element, document.location, path, _port, document.location.warnings)
    document = replace(document, dictionaries={**document.dictionaries, **defined})
    elements = element.findall("ssd:Elements/*", NS)
    unique((str(child.get("name")) for child in elements), f"{name}: element ")
    children = {
        str(child.get("name")): _element(child, document, joined(path, str(child.get("name"))), level + 1)
        for child in elements
    }
    base = _base(document, None, inside=False)
    ports = _ports(element, document, name)
    branch = Branch(
        path=path, ports=ports, children=children, wires=(), settings=read_bindings(element, base, name, level)
    )
    return replace(
        branch,
        wires=tuple(_wire(wire, branch) for wire in element.iterfind("ssd:Connections/ssd:Connection", NS)),
        tick=None if own is None or "tick" not in own.attrib else nanoseconds(own.attrib["tick"], f"{name}: tick"),
    )


def _element(element: Element, document: Document, path: str, level: int) -> Leaf | Bus | Branch:
    if next(document.elements) > _MOST or level > _DEEPEST:
        limits = f"more than {_MOST} elements or {_DEEPEST} levels"
        raise InputError(f"{path[:60]}: {limits}; systems that refer to each other may have no end")
    match local_name(element):
        case "System":
            return _system(element, document, path, level)
        case "Component":
            kind = element.get("type", _FMU)
            if kind == _FMU:
                return _fmu(element, document, path, level)
            if kind in (_SSD, _SSP):
                return _referred(element, document, path, level)
            raise InputError(f"{path}: type {kind} is not supported; use {_FMU}, {_SSD} or {_SSP}")
    return read_bus(path, str(element.get("dictionary")), _ports(element, document, path), document.dictionaries)


def _fmu(element: Element, document: Document, path: str, level: int) -> Leaf:
    implementation = element.get("implementation", "any")
    if implementation not in ("any", "CoSimulation"):
        document.location.warnings.append(f"{path}: implementation {implementation} is run as CoSimulation")
    steps = declared_steps(element, path)
    location = _fmu_location(document.location, element, steps, path)
    return Leaf(
        path=path,
        source=location.document,
        archive=location.archive,
        ports=_ports(element, document, path),
        steps=steps,
        settings=read_bindings(element, _base(document, location, inside=True), path, level),
    )


def _fmu_location(location: Location, element: Element, steps: DeclaredSteps, name: str) -> Location:
    source = str(element.get("source", ""))
    return native_location(location, source, name) if steps.native else location.resolve(source, name)[0]


def _referred(element: Element, document: Document, path: str, level: int) -> Branch:
    """Read the system that a component refers to: another SSD, one in an SSP, or one of this document by its id."""
    source = str(element.get("source"))
    if source.startswith("#"):
        location = document.location
        found = [e for e in document.root.iter("{*}System") if e.get("id") == source[1:]]
        if not found:
            raise InputError(f"{path}: source {source}: the file has no System with this id")
        key = f"{document.location}{source}"
        _refuse_again(key, document.opened, path)
        branch = _system(found[0], replace(document, opened=(*document.opened, key)), path, level)
    else:
        file, fragment = document.location.resolve(source, path)
        if element.get("type") == _SSP:
            location = file.inner(fragment or MAIN)
        elif fragment:
            raise InputError(f"{path}: source {source}: a part of another file is not supported; name the file alone")
        else:
            location = file
        _refuse_again(str(location), document.opened, path)
        inner = open_description(location, document, path)
        system = inner.root.find("ssd:System", NS)
        branch = _system(system, inner, path, level)
        location = file
    for name, port in _ports(element, document, path).items():
        there = branch.ports.get(name)
        if there is None:
            raise InputError(f"{path}.{name}: no such connector; {source} has {compact(branch.ports)}")
        same_unit = port.unit is None or there.unit is None or replace(port.unit, name=there.unit.name) == there.unit
        if (port.kind, port.type or there.type) != (there.kind, there.type or port.type) or not same_unit:
            raise InputError(f"{path}.{name}: declared differently in {source}; correct kind, type or unit")
    base = _base(document, location, inside=element.get("type") == _SSP)
    return with_more(branch, read_bindings(element, base, path, level))


def _refuse_again(key: str, opened: tuple[str, ...], path: str) -> None:
    if key in opened:
        raise InputError(f"{path}: {key} contains itself: it is one of the systems that refer to this one")


def _base(document: Document, component: Location | None, inside: bool) -> Base:
    return Base(
        document=document.location,
        component=component,
        inside=inside,
        units=document.units,
        enumerations=document.enumerations,
        warnings=document.location.warnings,
    )


def _ports(element: Element, document: Document, name: str) -> dict[str, Port]:
    entries = element.findall("ssd:Connectors/ssd:Connector", NS)
    unique((str(entry.get("name")) for entry in entries), f"{name}: connector ")
    return {
        str(e.get("name")): _port(
            e, document.units, document.enumerations, f"{name}.{e.get('name')}", document.location.warnings
        )
        for e in entries
    }


def _port(
    element: Element,
    units: Mapping[str, Unit],
    enumerations: Mapping[str, Mapping[str, int]],
    what: str,
    warnings: Warnings,
) -> Port:
    kind = next((child for child in element if child.tag.startswith(f"{{{SSC}}}")), None)
    type_name = None if kind is None else local_name(kind)
    return Port(
        name=str(element.get("name")),
        kind=element.get("kind", "inout"),  # entries of dictionaries have none
        type=type_name,
        unit=None if kind is None else unit_named(kind.get("unit"), units, what, warnings),
        items=items_of(kind, enumerations, what, warnings) if type_name == "Enumeration" else {},
    )


def _wire(element: Element, branch: Branch) -> Wire:
    start: End = (element.get("startElement"), str(element.get("startConnector")))
    end: End = (element.get("endElement"), str(element.get("endConnector")))
    what = f"{_shown(start, branch)} -> {_shown(end, branch)}"
    for name, connector in (start, end):
        owner, port = _found(name, connector, branch, what)
        if port.type is not None and port.type not in TYPES:
            raise InputError(f"{what}: type {port.type} cannot be connected; use one of {', '.join(TYPES)}")
        if port.kind == "inout" and not isinstance(owner, Bus):
            raise InputError(f"{what}: kind inout is for signal dictionaries; use input or output")
    return Wire(start=start, end=end, hop=read_hop(element), delay=connection_delay(element, what), what=what)


def _shown(end: End, branch: Branch) -> str:
    name, connector = end
    path = branch.path if name is None else joined(branch.path, name)
    return f"{path}.{connector}" if path else connector


def _found(name: str | None, connector: str, branch: Branch, what: str) -> tuple[Leaf | Bus | Branch, Port]:
    owner: Leaf | Bus | Branch | None = branch if name is None else branch.children.get(name)
    if owner is None:
        there = branch.children
        raise InputError(f"{what}: {name}: no such component; there are {compact(there)}{suggestion(str(name), there)}")
    if connector not in owner.ports:
        near = compact(owner.ports) + suggestion(connector, owner.ports)
        raise InputError(f"{what}: {owner.path or 'the system'} declares no connector {connector}; it declares {near}")
    return owner, owner.ports[connector]
