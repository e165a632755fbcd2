"""Read and write the typed parts of SSP documents: units, enumerations, values and transformations."""

from collections.abc import Mapping

from lockstep.errors import InputError, compact, suggestion
from lockstep.plain_values import plain_value
from lockstep.ssp.documents.xml import NS, SSC, Element, Warnings, add, local_name, namespace_of, unique
from lockstep.system.component import Value
from lockstep.system.transformation import Hop, MapValue, Table
from lockstep.system.units import BASES, Unit

TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")


def read_units(element: Element, where: str) -> dict[str, Unit]:
    """Read the Units of an SSD document or of a parameter set."""
    found = {}
    entries = _top_level(element, "Units", "Unit")
    unique((str(unit.get("name")) for unit in entries), f"{where}: unit ")
    for unit in entries:
        base = unit.find("ssc:BaseUnit", NS)
        assert base is not None  # the schema demands it
        name, factor = str(unit.get("name")), float(base.get("factor", "1"))
        if factor == 0.0:
            raise InputError(f"{where}: unit {name}: its factor must not be 0")
        found[name] = Unit(
            name=name,
            exponents=tuple(int(base.get(symbol, "0")) for symbol in BASES),
            factor=factor,
            offset=float(base.get("offset", "0")),
        )
    return found


def read_enumerations(element: Element, where: str) -> dict[str, dict[str, int]]:
    """Read the Enumerations of an SSD document or of a parameter set: value by item, by enumeration."""
    entries = _top_level(element, "Enumerations", "Enumeration")
    unique((str(entry.get("name")) for entry in entries), f"{where}: enumeration ")
    found = {}
    for entry in entries:
        items = entry.findall("ssc:Item", NS)
        unique((str(item.get("name")) for item in items), f"{where}: enumeration {entry.get('name')}: item ")
        found[str(entry.get("name"))] = {str(item.get("name")): int(item.get("value")) for item in items}
    return found


def _top_level(element: Element, group: str, tag: str) -> list[Element]:
    return list(element.iterfind(f"{{{namespace_of(element)}}}{group}/{{{SSC}}}{tag}"))


def _unit_of_value(name: str | None, units: Mapping[str, Unit], what: str, warnings: Warnings) -> Unit | None:
    """Look the unit of a value up; some tools put it in brackets.

    Of an unknown one only the name can be compared: a variable in another unit refuses the value.
    """
    if name is None or name in units:
        return None if name is None else units[name]
    inside = name.strip("[]")
    if inside in units:
        warnings.append(f"{what}: unit {name!r} is read as {inside}")
        return units[inside]
    warnings.append(f"{what}: unit {name!r} is not defined; the file defines {compact(units)}")
    return Unit(name=name)


def unit_named(name: str | None, units: Mapping[str, Unit], what: str, warnings: Warnings) -> Unit | None:
    """Look the unit of a connector up. An unknown one is left out, with a warning: that of the FMU applies."""
    if name is not None and name not in units:
        warnings.append(f"{what}: unit {name!r} is left out, as the file defines only {compact(units)}")
        return None
    return None if name is None else units[name]


def read_value(
    element: Element,
    units: Mapping[str, Unit],
    enumerations: Mapping[str, Mapping[str, int]],
    what: str,
    warnings: Warnings,
) -> tuple[Value, Unit | None]:
    """Read a typed value and its unit, if it has one. An Enumeration's value is the name of its item."""
    kind, text = local_name(element), str(element.get("value"))
    match kind:
        case "Real":
            return _number(text), _unit_of_value(element.get("unit"), units, what, warnings)
        case "Integer":
            return int(text), None
        case "Boolean":
            return boolean(text), None
        case "String":
            return text, None
        case "Enumeration":
            items = items_of(element, enumerations, what, warnings)
            if items and text not in items:
                raise InputError(f"{what}: no item {text}; there are {compact(items)}{suggestion(text, items)}")
            return text, None
    raise InputError(f"{what}: type {kind} is not supported; use one of {', '.join(TYPES)}")


def items_of(
    element: Element, enumerations: Mapping[str, Mapping[str, int]], what: str, warnings: Warnings
) -> Mapping[str, int]:
    """Return the items of the enumeration that a type names; none if it names none, or, with a warning, another's."""
    name = element.get("name")
    if name is not None and name not in enumerations:
        defined = compact(enumerations)
        warnings.append(f"{what}: enumeration {name!r} is not defined; the items are the FMU's, the file has {defined}")
    return enumerations.get(name, {})


def read_hop(element: Element) -> Hop:
    """Read the transformation of a Connection or MappingEntry, and whether it converts units."""
    converts = not boolean(element.get("suppressUnitConversion", "false"))
    for child in element:
        tag = local_name(child)
        if tag == "LinearTransformation":
            factor, offset = _number(child.get("factor", "1")), _number(child.get("offset", "0"))
            return Hop(factor=factor, offset=offset, convert_units=converts)
        if tag.endswith("MappingTransformation"):
            kind = tag.removesuffix("MappingTransformation")
            entries = ((_entry(kind, e.get("source")), _entry(kind, e.get("target"))) for e in child)
            return Hop(table=Table(kind=kind, entries=tuple(entries)), convert_units=converts)  # type: ignore[arg-type]
    return Hop(convert_units=converts)


def _entry(kind: str, text: str) -> MapValue:
    match kind:
        case "Boolean":
            return boolean(text)
        case "Integer":
            return int(text)
    return text


def boolean(text: str) -> bool:
    """Read an xs:boolean that the schema has accepted."""
    return text.strip() in ("true", "1")


def _number(text: str) -> float:
    return float(text.replace("INF", "inf"))  # xs:double


def write_transformation(element: Element, factor: float, offset: float, table: Table | None) -> None:
    """Write the transformation of a connection or of an entry of a parameter mapping, if there is one."""
    if (factor, offset) != (1.0, 0.0):
        add(element, SSC, "LinearTransformation", factor=repr(factor), offset=repr(offset))
    if table is not None:
        entries = add(element, SSC, f"{table.kind}MappingTransformation")
        for given, result in table.entries:
            add(entries, SSC, "MapEntry", source=_entry_text(given), target=_entry_text(result))


def write_units(parent: Element | None, namespace: str, units: Mapping[str, Unit]) -> None:
    """Define units, if there are any, in a system or in a parameter set."""
    if parent is None or not units:
        return
    group = add(parent, namespace, "Units")
    for unit in units.values():
        base = add(add(group, SSC, "Unit", name=unit.name), SSC, "BaseUnit")
        for symbol, exponent in zip(BASES, unit.exponents or (), strict=False):
            if exponent:
                base.set(symbol, str(exponent))
        if (unit.factor, unit.offset) != (1.0, 0.0):
            base.set("factor", repr(float(unit.factor)))
            base.set("offset", repr(float(unit.offset)))


def literal(value: Value, items: Mapping[str, int]) -> tuple[str, str]:
    """Return type and text of a value; `items` are those of its Enumeration."""
    value = plain_value(value, "parameter")
    for item, number in items.items():
        if number == value:
            return "Enumeration", item
    match value:
        case bool():
            return "Boolean", "true" if value else "false"
        case int():
            return "Integer", str(value)
        case float():
            return "Real", repr(value)
        case str():
            return "String", value
    raise InputError(f"parameter: {value!r} must be a number, a text, True or False")


def _entry_text(entry: MapValue) -> str:
    plain = plain_value(entry, "entry of a mapping transformation")
    return str(plain).lower() if isinstance(plain, bool) else str(plain)
