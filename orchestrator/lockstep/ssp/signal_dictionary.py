"""Read the signal dictionaries of a system: named buses whose entries have one source and any number of readers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from lockstep.errors import InputError, compact, suggestion
from lockstep.ssp.documents.location import Location
from lockstep.ssp.documents.parse import parse, validate
from lockstep.ssp.documents.xml import DICTIONARY, NS, Element, Warnings, unique
from lockstep.ssp.tree import Bus, Port
from lockstep.ssp.typed_values import read_enumerations, read_units

_TYPE = "application/x-ssp-signal-dictionary"


@dataclass(frozen=True, slots=True, kw_only=True)
class Dictionary:
    """A dictionary; its key differs from those of dictionaries of the same name in other systems."""

    key: str
    entries: Mapping[str, Port]


def read_dictionaries(
    system: Element, document: Location, path: str, read_port: Callable[..., Port], warnings: Warnings
) -> dict[str, Dictionary]:
    """Read the dictionaries that a system defines, by name, or raise InputError.

    `read_port` makes a port of an entry, given the units and enumerations of its file.
    """
    name = path or "the system"
    found = system.findall("ssd:SignalDictionaries/ssd:SignalDictionary", NS)
    unique((str(entry.get("name")) for entry in found), f"{name}: signal dictionary ")
    return {
        str(entry.get("name")): Dictionary(
            key=f"{path}:{entry.get('name')}",
            entries=_entries(entry, document, f"{name}: {entry.get('name')}", read_port, warnings),
        )
        for entry in found
    }


def _entries(
    element: Element, document: Location, what: str, read_port: Callable[..., Port], warnings: Warnings
) -> dict[str, Port]:
    if element.get("type", _TYPE) != _TYPE:
        raise InputError(f"{what}: signal dictionary of type {element.get('type')} is not supported; use {_TYPE}")
    source = element.get("source")
    if source is None:
        if len(element) != 1:
            raise InputError(f"{what}: holds {len(element)} elements; give one SignalDictionary, or a source")
        root, where = element[0], str(document)
        validate(root, where, DICTIONARY)
    else:
        location, _ = document.resolve(source, what)
        where = str(location)
        root = parse(location.read(what), where, DICTIONARY, warnings)
    units, enumerations = read_units(root, where), read_enumerations(root, where)
    entries = root.findall("ssb:DictionaryEntry", NS)
    unique((str(entry.get("name")) for entry in entries), f"{what}: entry ")
    return {str(e.get("name")): read_port(e, units, enumerations, f"{what}.{e.get('name')}", warnings) for e in entries}


def read_bus(path: str, name: str, ports: Mapping[str, Port], dictionaries: Mapping[str, Dictionary]) -> Bus:
    """Return a reference to a dictionary, its connectors being entries of it, or raise InputError."""
    if name not in dictionaries:
        near = compact(dictionaries) + suggestion(name, dictionaries)
        raise InputError(f"{path}: no signal dictionary {name} in this system or around it; there are {near}")
    entries = dictionaries[name].entries
    for port in ports.values():
        entry = entries.get(port.name)
        if entry is None:
            near = compact(entries) + suggestion(port.name, entries)
            raise InputError(f"{path}.{port.name}: signal dictionary {name} has no such entry; it has {near}")
        types = port.type in (None, entry.type) and (port.unit is None or port.unit == entry.unit)
        if not types or (port.items and port.items != entry.items):
            raise InputError(f"{path}.{port.name}: declared differently in signal dictionary {name}; correct one")
    return Bus(path=path, key=dictionaries[name].key, ports=ports, entries=entries)
