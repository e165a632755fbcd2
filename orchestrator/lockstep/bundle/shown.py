"""What hosts see of the ports: in FMI 2.0 each is a variable; in FMI 3.0 complete arrays are variables too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from lockstep.array_names import array_of, by_array, elements_of, grid_axes, split_element
from lockstep.bundle.ports import Port
from lockstep.fmi.model_description import Description


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """One variable of the bundle: a port, or all elements of an array, the last index running fastest."""

    name: str
    ports: tuple[Port, ...]
    dimensions: tuple[int, ...] = ()

    @property
    def first(self) -> Port:
        """The port that kind, type and unit are those of: its other elements are alike."""
        return self.ports[0]

    @property
    def description(self) -> str:
        """The description of the elements, if they have one in common."""
        found = {port.variable.description for port in self.ports}
        return found.pop() if len(found) == 1 else ""


def shown(ports: Sequence[Port], descriptions: Mapping[str, Description], version: str) -> tuple[Shown, ...]:
    """Return the variables of a bundle, in the order in which they begin among its ports.

    An array that is not exported whole, or whose elements differ in kind, type, unit or range, stays elements.
    """
    if version != "3.0":
        return tuple(Shown(name=port.name, ports=(port,)) for port in ports)
    by_name = {port.name: port for port in ports}
    arrays = {
        array: dimensions
        for array, elements in by_array(by_name).items()
        if (dimensions := _dimensions(array, [by_name[name] for name in elements.values()], by_name, descriptions))
    }
    return tuple(_variables(ports, arrays, by_name))


def _variables(
    ports: Sequence[Port], arrays: Mapping[str, tuple[int, ...]], by_name: Mapping[str, Port]
) -> Iterator[Shown]:
    done: set[str] = set()
    for port in ports:
        array = array_of(port.name)
        if array not in arrays:
            yield Shown(name=port.name, ports=(port,))
        elif array not in done:
            done.add(array)
            elements = tuple(by_name[name] for name in elements_of(array, by_name))
            yield Shown(name=array, ports=elements, dimensions=arrays[array])


def _dimensions(
    array: str, elements: Sequence[Port], by_name: Mapping[str, Port], descriptions: Mapping[str, Description]
) -> tuple[int, ...]:
    """Return the size of each dimension; none if these elements cannot be one variable."""
    axes = grid_axes(split_element(port.name)[1] for port in elements) if elements else None
    if axes is None or any(values != tuple(range(1, len(values) + 1)) for values in axes):
        return ()
    if array in by_name or len({_kind(port) for port in elements}) > 1:
        return ()
    end = elements[0].ends[0]
    behind = elements_of(array_of(end.variable.name), descriptions[end.component].variables)
    return tuple(map(len, axes)) if len(behind) <= len(elements) else ()


def _kind(port: Port) -> tuple[object, ...]:
    """Return what all elements of a variable have in common."""
    one = port.variable
    plain = [(end.gain, end.bias) == (1.0, 0.0) for end in port.ends]
    return (
        *(port.kind, port.unit, all(plain), one.type, one.variability, one.display_unit, one.relative),
        *(one.minimum, one.maximum, one.nominal, tuple(one.items.items())),
    )
