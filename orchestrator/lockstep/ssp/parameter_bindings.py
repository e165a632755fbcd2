"""Read the parameter bindings of one element: values inline and from files, prefixes, and parameter mappings."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from lockstep.array_names import elements_of
from lockstep.errors import InputError, compact
from lockstep.ssp.documents.location import Location
from lockstep.ssp.documents.parse import parse, validate
from lockstep.ssp.documents.xml import MAPPING, NS, PARAMETERS, Element, Warnings, unique
from lockstep.ssp.tree import Setting
from lockstep.ssp.typed_values import read_enumerations, read_hop, read_units, read_value
from lockstep.system.component import Value
from lockstep.system.units import Unit

_SET, _MAPPING = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"
UnitValues = Mapping[str, tuple[Value, Unit | None]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    """Hold the base of the sources in an element's bindings, and the units and enumerations of inline values.

    `component` is the file of a component; with `inside` it is an archive that holds the files.
    """

    document: Location
    component: Location | None
    inside: bool
    units: Mapping[str, Unit]
    enumerations: Mapping[str, Mapping[str, int]]
    warnings: Warnings


def read_bindings(element: Element, base: Base, name: str, level: int) -> tuple[Setting, ...]:
    """Return the settings of the bindings of a system or component, in the order of the file.

    A prefix is put before the names of the values; a mapping refers to the names with the prefix, and values that it
    does not map are not set. Raises InputError.
    """
    found: list[Setting] = []
    for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NS):
        if binding.get("type", _SET) != _SET:
            raise InputError(f"{name}: parameter binding of type {binding.get('type')} is not supported; use {_SET}")
        values, origin = _values(binding, base, name)
        prefix = binding.get("prefix", "")
        values = {prefix + key: value for key, value in values.items()}
        mapping = binding.find("ssd:ParameterMapping", NS)
        if mapping is None:
            found += [
                Setting(name=key, value=value, unit=unit, hops=(), level=level, origin=origin)
                for key, (value, unit) in values.items()
            ]
        else:
            found += _mapped(mapping, values, base, name, level)
    return tuple(found)


def _values(binding: Element, base: Base, name: str) -> tuple[UnitValues, str]:
    inline = binding.find("ssd:ParameterValues", NS)
    source = binding.get("source")
    if (inline is None) == (source is None):
        both = "both" if source is not None else "neither"
        raise InputError(f"{name}: a ParameterBinding has {both} source and ParameterValues; give one of them")
    if inline is not None:
        (found,) = _one(inline, name, "ParameterSet")
        validate(found, str(base.document), PARAMETERS)  # the schema of the system allows anything here
        origin, units, enumerations = "inline", dict(base.units), dict(base.enumerations)
    else:
        location = _file(binding, base, name)
        found = parse(location.read(name), str(location), PARAMETERS, base.warnings)
        origin, units, enumerations = location.document.name, {}, {}
    units |= read_units(found, origin)
    enumerations |= read_enumerations(found, origin)
    parameters = found.findall("ssv:Parameters/ssv:Parameter", NS)
    twice = [key for key, count in Counter(str(p.get("name")) for p in parameters).items() if count > 1]
    if twice:
        base.warnings.append(f"{name}: {origin}: parameter {compact(twice)}: declared twice; the last value is used")
    return {
        str(p.get("name")): read_value(p[0], units, enumerations, f"{name}.{p.get('name')}", base.warnings)
        for p in parameters
    }, origin


def _mapped(mapping: Element, values: UnitValues, base: Base, name: str, level: int) -> list[Setting]:
    if mapping.get("type", _MAPPING) != _MAPPING:
        raise InputError(f"{name}: parameter mapping of type {mapping.get('type')} is not supported; use {_MAPPING}")
    if mapping.get("source") is None:
        (found,) = _one(mapping, name, "ParameterMapping")
        validate(found, str(base.document), MAPPING)
        origin = "inline mapping"
    else:
        location = _file(mapping, base, name)
        found = parse(location.read(name), str(location), MAPPING, base.warnings)
        origin = location.document.name
    entries = found.findall("ssm:MappingEntry", NS)
    unique((str(entry.get("target")) for entry in entries), f"{name}: {origin}: target ")
    settings = []
    for entry in entries:
        source = str(entry.get("source"))
        hop = read_hop(entry)
        hops = () if hop.converts_units_only and hop.convert_units else (hop,)
        # a set may have a part of the values of a large mapping; those of an array are mapped one by one
        for one in [source] if source in values else elements_of(source, values):
            value, unit = values[one]
            target = f"{entry.get('target')}{one.removeprefix(source)}"
            settings.append(Setting(name=target, value=value, unit=unit, hops=hops, level=level, origin=origin))
    return settings


def _one(holder: Element, name: str, tag: str) -> list[Element]:
    found = list(holder)
    if len(found) != 1:
        raise InputError(f"{name}: {holder.tag.partition('}')[2]} holds {len(found)} elements; give one {tag}")
    return found


def _file(element: Element, base: Base, name: str) -> Location:
    source = str(element.get("source"))
    if element.get("sourceBase", "SSD") == "SSD":
        return base.document.resolve(source, name)[0]
    if base.component is None:
        raise InputError(f"{name}: {source}: sourceBase component needs a component, but this is a system")
    return base.component.member(source, name) if base.inside else base.component.resolve(source, name)[0]
