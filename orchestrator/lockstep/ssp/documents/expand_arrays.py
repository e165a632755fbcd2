"""Write the arrays of SSP 2.0 as the scalars of SSP 1.0: `w` of size 3 becomes w[1], w[2], w[3].

Elements have the names that FMI 2.0 uses for arrays, and that this master gives the elements of FMI 3.0's; the last
index runs fastest.
"""

from copy import deepcopy
from itertools import product

from lockstep.errors import InputError
from lockstep.ssp.documents.xml import NS, SSC, SSD, SSV, Element, local_name

_TEXTS = ("String", "Enumeration", "Binary")  # their values may hold blanks: an array has them as Value elements


def expand_arrays(root: Element, where: str) -> None:
    """Replace array connectors, connections between them, and values of arrays, in place. Raises InputError."""
    for system in [*root.iter(f"{{{SSD}}}System")]:
        _expand_system(system, where)
    for parameter in [*root.iter(f"{{{SSV}}}Parameter")]:
        _expand_parameter(parameter, where)


def _expand_system(system: Element, where: str) -> None:
    sizes: dict[tuple[str | None, str], list[str]] = {}  # element or None for the system, and connector: its elements
    children = system.findall("ssd:Elements/*", NS)
    for owner in (system, *children):
        for connector in owner.findall("ssd:Connectors/ssd:Connector", NS):
            indices = _indices(connector, f"{where}: {owner.get('name')}.{connector.get('name')}")
            if indices is not None:
                sizes[None if owner is system else str(owner.get("name")), str(connector.get("name"))] = indices
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
            return
        indices = [f"[{number}]" for number in range(1, len(given) + 1)]
    if len(given) != len(indices):
        raise InputError(f"{what}: has {len(given)} values for {len(indices)} elements; give one for each")
    for copy, value in zip(_replace(parameter, indices), given, strict=True):
        for child in copy[0].findall("ssv:Value", NS):
            copy[0].remove(child)
        copy[0].set("value", value)


def _indices(element: Element, what: str) -> list[str] | None:
    """Return the indices of an array's elements; None if it has no dimensions. The dimensions are removed."""
    dimensions = element.findall("ssc:Dimension", NS)
    dimensions += [
        d for kind in element if str(kind.tag).startswith(f"{{{SSC}}}") for d in kind.findall("ssc:Dimension", NS)
    ]
    if not dimensions:
        return None
    sizes = []
    for dimension in dimensions:
        if dimension.get("size") is None:
            raise InputError(
                f"{what}: its size is that of the connector {dimension.get('sizeConnector')}; give it as a number"
            )
        sizes.append(range(1, int(dimension.get("size")) + 1))
        dimension.getparent().remove(dimension)
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
