"""Parse names of array elements, such as `rate[3]` and `gain[1,2]`, and put them into the order of their indices.

Variables of an FMU come in any order, `p[10]` before `p[2]` included, and their indices count from any base. Whoever
lists the elements of an array lists them by number, the last index running fastest.
"""

import re
from collections.abc import Iterable, Iterator, Sequence

Index = tuple[int, ...]  # (): the name is no element of an array

_ELEMENT = re.compile(r"(.+)\[(\d+(?:,\d+)*)\]")
_RANGE = re.compile(r"(.+)\[(\d+)\.\.(\d+)\]")


def split_element(name: str) -> tuple[str, Index]:
    """Return the array and the index of an element: `gain[1,2]` is `gain`, (1, 2); other names have no index."""
    match = _ELEMENT.fullmatch(name)
    return (name, ()) if match is None else (match[1], tuple(map(int, match[2].split(","))))


def element_name(array: str, index: Sequence[int]) -> str:
    """Return the name of an element: `gain`, (1, 2) is `gain[1,2]`; without an index that of the array."""
    return f"{array}[{','.join(map(str, index))}]" if index else array


def array_of(name: str) -> str:
    """Return the name of the array that an element is of, or the name itself."""
    return split_element(name)[0]


def name_and_arrays(name: str) -> Iterator[str]:
    """Yield the name, and the arrays that it is an element of, the smallest first: of `a[1][2]` also `a[1]` and `a`."""
    yield name
    while (array := array_of(name)) != name:
        yield (name := array)


def stem(name: str) -> str:
    """Return what stands before the first bracket, also of a pattern or of a range such as `rate[1..3]`."""
    return name.partition("[")[0]


def elements_of(array: str, names: Iterable[str]) -> list[str]:
    """Return the names that are elements of an array, in the order of their indices; none if there are none."""
    begun = (name for name in names if name.startswith(array))
    found = [(index, name) for name in begun for base, index in [split_element(name)] if index and base == array]
    return [name for _, name in sorted(found)]


def in_order(names: Iterable[str]) -> list[str]:
    """Sort the elements of each array by index among the positions that they have; other names stay where they are."""
    split = [(name, *split_element(name)) for name in names]
    elements: dict[str, list[tuple[Index, str]]] = {}
    for name, array, index in split:
        elements.setdefault(array, []).append((index, name))
    following = {array: iter(sorted(found)) for array, found in elements.items()}
    return [next(following[array])[1] for _, array, _ in split]


def by_array(names: Iterable[str]) -> dict[str, dict[Index, str]]:
    """Group names by array, in the order in which arrays begin: the elements by index and in its order, or none."""
    groups: dict[str, dict[Index, str]] = {}
    for name in names:
        array, index = split_element(name)
        group = groups.setdefault(array, {})
        if index:
            group[index] = name
    return {array: dict(sorted(elements.items())) for array, elements in groups.items()}


def split_range(text: str) -> tuple[str, int, int] | None:
    """Return array, first and last index of a range such as `rate[1..3]`; None if the text is none."""
    match = _RANGE.fullmatch(text)
    return None if match is None else (match[1], int(match[2]), int(match[3]))


def range_names(array: str, first: int, last: int) -> list[str]:
    """Return the elements of a range, both ends included."""
    return [element_name(array, (index,)) for index in range(first, last + 1)]


def grid_axes(indices: Iterable[Index]) -> tuple[Index, ...] | None:
    """Return the index values along each dimension if the indices fill a whole grid, or None.

    The indices (1, 1), (1, 2), (2, 1), (2, 2) give ((1, 2), (1, 2)).
    """
    found = set(indices)
    if len({len(index) for index in found}) != 1:
        return None
    axes = tuple(tuple(sorted(set(values))) for values in zip(*found, strict=True))
    size = 1
    for values in axes:
        size *= len(values)
    return axes if size == len(found) else None
