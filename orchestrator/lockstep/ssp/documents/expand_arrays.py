"""Write the arrays of SSP 2.0 as the scalars of SSP 1.0: `w` of size 3 becomes w[1], w[2], w[3].

Elements have the names that FMI 2.0 uses for arrays, and that this master gives the elements of FMI 3.0's; the last
index runs fastest. A size that the file does not give as a number is that of the FMU.
"""

from collections.abc import Callable
from copy import deepcopy
from itertools import product

from lockstep.errors import InputError
from lockstep.ssp.documents.xml import NS, SSB, SSC, SSD, SSV, Element, local_name

_TEXTS = ("String", "Enumeration", "Binary")  # their values may hold blanks: an array has them as Value elements

# The indices of the elements that a component has of an array, `[1]` and so on; none if it has no such array.
Shapes = Callable[[Element, str], list[str]]


def no_shapes(_component: Element, _connector: str) -> list[str]:
    """Return nothing: no FMU is known."""
    return []


def expand_arrays(root: Element, where: str, shapes: Shapes = no_shapes) -> None:
    """Replace array connectors, connections between them, and values of arrays, in place. Raises InputError."""
    for system in [*root.iter(f"{{{SSD}}}System")]:
        _expand_system(system, where, shapes)
    for parameter in [*root.iter(f"{{{SSV}}}Parameter")]:
        _expand_parameter(parameter, where)
    for entry in [*root.iter(f"{{{SSB}}}DictionaryEntry")]:
        indices = _indices(entry, f"{where}: {entry.get('name')}")
        if indices is not None:
            _replace(entry, indices)


def _expand_system(system: Element, where: str, shapes: Shapes) -> None:
    sizes: dict[tuple[str | None, str], list[str]] = {}  # element or None for the system, and connector: its elements
    children = system.findall("ssd:Elements/*", NS)
    for owner in (system, *children):
        for connector in owner.findall("ssd:Connectors/ssd:Connector", NS):
            name = str(connector.get("name"))
            own = owner if local_name(owner) == "Component" else None
            indices = _indices(connector, f"{where}: {owner.get('name')}.{name}", own, shapes)
            if indices is not None:
                sizes[None if owner is system else str(owner.get("name")), name] = indices
                _replace(connector, indices)
    for connection in system.findall("ssd:Connections/ssd:Connection", NS):
        _expand_connection(connection, sizes, where)


def _expand_connection(connection: Element, sizes: dict[tuple[str | None, str], list[str]], where: str) -> None:
    ends = []
    for side in ("start", "end"):
        connector = str(connection.get(f"{side}Connector"))
        indices = sizes.get((connection.get(f"{side}Element") or None, connector))
        given = connection.attrib.pop(f"{side}Indices", None)
        if given is not None:
            indices = [f"[{','.join(given.split())}]"]
        ends.append([connector + index for index in indices or ("",)])
    starts, stops = ends
    if len(starts) != len(stops):
        what = f"{connection.get('startConnector')} -> {connection.get('endConnector')}"
        raise InputError(
            f"{where}: {what}: connects {len(starts)} elements to {len(stops)}; arrays of one size can be connected"
        )
    for start, stop in zip(starts, stops, strict=True):
        copy = deepcopy(connection)
        copy.set("startConnector", start)
        copy.set("endConnector", stop)
        connection.addprevious(copy)
    connection.getparent().remove(connection)


def _expand_parameter(parameter: Element, where: str) -> None:
    name, (kind, *_) = str(parameter.get("name")), parameter
    what = f"{where}: parameter {name}"
    given = [str(value.get("value")) for value in kind.findall("ssv:Value", NS)]
    if not given and local_name(kind) not in _TEXTS:
        given = str(kind.get("value", "")).split()
    indices = _indices(parameter, what)
    if indices is None:
        if len(given) < 2:
            _write_value(parameter, given)
            return
        indices = [f"[{number}]" for number in range(1, len(given) + 1)]
    if len(given) != len(indices):
        raise InputError(f"{what}: has {len(given)} values for {len(indices)} elements; give one for each")
    for copy, value in zip(_replace(parameter, indices), given, strict=True):
        _write_value(copy, [value])


def _write_value(parameter: Element, values: list[str]) -> None:
    """Write the value of a scalar as an attribute, as SSP 1.0 has it."""
    for child in parameter[0].findall("ssv:Value", NS):
        parameter[0].remove(child)
    for value in values:
        parameter[0].set("value", value)


def _indices(
    element: Element, what: str, component: Element | None = None, shapes: Shapes = no_shapes
) -> list[str] | None:
    """Return the indices of an array's elements; None if it has no dimensions. The dimensions are removed."""
    dimensions = element.findall("ssc:Dimension", NS)
    dimensions += [
        d for kind in element if str(kind.tag).startswith(f"{{{SSC}}}") for d in kind.findall("ssc:Dimension", NS)
    ]
    if not dimensions:
        return None
    given = [dimension.get("size") for dimension in dimensions]
    for dimension in dimensions:
        dimension.getparent().remove(dimension)
    if None in given:
        found = [] if component is None else shapes(component, str(element.get("name")))
        if not found:
            other = next((d.get("sizeConnector") for d in dimensions if d.get("sizeConnector")), None)
            text = "its size is not given" if other is None else f"its size is that of the connector {other}"
            raise InputError(f"{what}: {text}, and no FMU has such an array; give the size as a number")
        return found
    sizes = [range(1, int(size) + 1) for size in given]
    return [f"[{','.join(map(str, index))}]" for index in product(*sizes)]


def _replace(element: Element, indices: list[str]) -> list[Element]:
    """Replace an element by copies of it with the indices after its name."""
    copies = []
    for index in indices:
        copy = deepcopy(element)
        copy.set("name", f"{element.get('name')}{index}")
        element.addprevious(copy)
        copies.append(copy)
    element.getparent().remove(element)
    return copies
