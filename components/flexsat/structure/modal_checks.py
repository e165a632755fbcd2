"""Check modal data against themselves: participation against mass and inertia, orthogonality; name what is missing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .modal_data import ModalData, body_of, body_of_nodes, normalised, participation_of_nodes, structure_from

ALIKE = 1e-2  # relative difference of mass properties, and of orthogonality, that data of one model keep
AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One line about modal data."""

    text: str
    right: bool = True
    numbers: tuple[tuple[str, float, str], ...] = ()  # of the text: quantity, value, unit


def modal_checks(data: ModalData) -> list[Check]:
    """Return what was checked and what could not be; ValueError for data that give no structure."""
    structure = structure_from(data)
    share = 1.0 - np.diag(structure.residual_mass)
    diagonal = np.diag(structure.rigid_mass)
    shares = [
        (f"effective {what} {axis}", float(100.0 * share[3 * k + i]), "%")
        for k, what in enumerate(("mass", "inertia"))
        for i, axis in enumerate(AXES)
        if diagonal[3 * k + i] > 1e-9 * diagonal.max()
    ]
    shown = ", ".join(f"{name.removeprefix('effective ')} {value:.2f} {unit}" for name, value, unit in shares)
    return [
        Check(
            text=f"effective, of all {structure.mode_count} modes clamped at the interface: {shown}",
            numbers=tuple(shares),
        ),
        *_against_nodes(data),
        *(Check(text=f"missing: {text}") for text in _missing(data)),
    ]


def _against_nodes(data: ModalData) -> Iterator[Check]:
    of_nodes = body_of_nodes(data)
    if of_nodes is None:
        return
    given = body_of(data)
    for what, one, other in (
        ("mass", given.mass, of_nodes.mass),
        ("inertia", given.inertia, of_nodes.inertia),
    ):
        error = float(np.max(np.abs(np.subtract(one, other))) / np.max(np.abs(other)))
        yield _deviation(f"{what} against that of the nodes", error)
    moved, turned = normalised(data)
    error = orthogonality(data, moved, turned)
    yield Check(
        text=f"orthogonality of the shapes: largest error {error:.2g}",
        right=error < ALIKE,
        numbers=(("orthogonality of the shapes: largest error", error, ""),),
    )
    found = participation_of_nodes(data, moved, turned)
    if found is not None and data.translation is not None and data.rotation is not None and data.kind == "clamped":
        scale = np.ones(len(data.frequency)) if data.modal_mass is None else 1.0 / np.sqrt(data.modal_mass)
        stated = np.vstack([data.translation, data.rotation]) * scale
        error = float(np.max(np.abs(stated - found)) / np.max(np.abs(found)))
        yield _deviation("participation against that of the nodes", error)


def _deviation(what: str, error: float) -> Check:
    percent = 100.0 * error
    return Check(text=f"{what}: differs by {percent:.2g} %", right=error < ALIKE, numbers=((what, percent, "%"),))


def orthogonality(data: ModalData, moved: Array, turned: Array) -> float:
    """Return the largest difference of the modal mass matrix from the unit matrix."""
    if data.node_mass is None:
        raise ValueError("node_mass: missing; orthogonality is that of shapes with masses")
    gram = np.einsum("nim,n,nik->mk", moved, data.node_mass, moved)
    if data.node_inertia is not None:
        gram += np.einsum("nim,nij,njk->mk", turned, data.node_inertia, turned)
    return float(np.max(np.abs(gram - np.eye(len(gram)))))


def _missing(data: ModalData) -> Iterator[str]:
    if data.node_mass is None:
        yield "node_mass: orthogonality is not checked"
    if data.node_rotation is None:
        yield "node_rotation: gyros and wheels at nodes meet no rotation of the modes"
    if not data.node_name:
        yield "node_name: no site can be a node"
    if not np.any(data.damping_ratio):
        yield "damping: all ratios are 0; set damping_ratio of the appendage"
