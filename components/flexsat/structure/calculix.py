"""Read the modes that CalculiX has found: nodes and shapes from the .frd, participation from the .dat, as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Index

NUMBER = 12  # characters of a number in a line of a .frd
FIRST = 13  # characters before the first one: key and node
PARTICIPATION = "P A R T I C I P A T I O N   F A C T O R S"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Results:
    """Mass-normalised modes of a *FREQUENCY step, in the axes of its model."""

    frequency: Array  # (m,) [Hz]
    node_name: tuple[str, ...]  # (n,): the numbers of the nodes
    node_position: Array  # (n, 3)
    node_translation: Array  # (n, 3, m)
    participation: Array  # (6, m): along x, y, z, and about them through the origin
    edges: Index  # (e, 2): nodes that follow one another in an element


def read_calculix(frd: str, dat: str) -> Results:
    """Return the modes of a run of CalculiX, in the units of its model.

    Parameters
    ----------
    frd : text of the .frd, with displacements: `*NODE FILE` and `U` in the step
    dat : text of the .dat, with participation factors

    Raises
    ------
    ValueError
        If modes, nodes or factors are missing, or differ in number.
    """
    names: list[str] = []
    places: list[list[float]] = []
    elements: list[list[str]] = []
    frequency: list[float] = []
    shapes: list[dict[str, list[float]]] = []
    block = ""
    for line in frd.splitlines():
        kind = line[:6].strip()
        if kind in ("2C", "3C"):
            block = kind
        elif line[2:6] == "100C":
            block, value = "mode", float(line[12:24])
        elif kind.startswith("-4"):
            if block == "mode" and line[5:9] == "DISP":
                frequency.append(value)
                shapes.append({})
                block = "shape"
        elif line[:3] == " -3":
            block = ""
        elif line[:3] == " -1" and block == "2C":
            names.append(line[3:FIRST].strip())
            places.append(_numbers(line))
        elif line[:3] == " -1" and block == "3C":
            elements.append([])
        elif line[:3] == " -2" and block == "3C":
            elements[-1] += line[3:].split()
        elif line[:3] == " -1" and block == "shape":
            shapes[-1][line[3:FIRST].strip()] = _numbers(line)
    if not names or not shapes:
        raise ValueError(
            "the .frd has no nodes, or no displacements; write `*NODE FILE` and `U` in the *FREQUENCY step"
        )
    if any(shape.keys() != set(names) for shape in shapes):
        raise ValueError("the .frd has no displacement of some nodes; write `*NODE FILE` and `U` for all of them")
    factors = _participation(dat)
    if len(factors) != len(shapes):
        raise ValueError(f"the .frd has {len(shapes)} modes, and the .dat participation of {len(factors)}; take both of"
                         " one run")  # fmt: skip
    moved = np.array([[shape[name] for name in names] for shape in shapes])  # (m, n, 3)
    return Results(
        frequency=np.array(frequency),
        node_name=tuple(names),
        node_position=np.array(places),
        node_translation=np.ascontiguousarray(moved.transpose(1, 2, 0)),
        participation=np.ascontiguousarray(np.array(factors).T),
        edges=_edges(elements, {name: k for k, name in enumerate(names)}),
    )


def _numbers(line: str) -> list[float]:
    return [float(line[FIRST + NUMBER * k : FIRST + NUMBER * (k + 1)]) for k in range(3)]


def _participation(dat: str) -> list[list[float]]:
    _, found, rest = dat.partition(PARTICIPATION)
    if not found:
        raise ValueError("the .dat has no participation factors; take that of a *FREQUENCY step")
    rows: list[list[float]] = []
    for line in rest.splitlines()[1:]:
        words = line.split()
        if len(words) == 7 and words[0].isdigit():
            rows.append([float(word) for word in words[1:]])
        elif rows:
            break
    return rows


def _edges(elements: Sequence[Sequence[str]], index: dict[str, int]) -> Index:
    """Return pairs of corners that follow one another in an element, each once: for drawings."""
    pairs = set()
    for nodes in elements:
        corners = nodes[: {20: 8, 10: 4, 15: 6, 6: 3, 3: 2}.get(len(nodes), len(nodes))]
        for one, other in zip(corners, [*corners[1:], corners[0]], strict=True):
            if one != other and one in index and other in index:
                pairs.add(tuple(sorted((index[one], index[other]))))
    return np.array(sorted(pairs), dtype=np.intp).reshape(-1, 2)
