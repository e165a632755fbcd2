"""Turn what pyNastran has read of a NASTRAN run into modal data in SI."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from .modal_data import STILL, ModalData
from .modal_sources import ratios, read_body

BULK_DATA = (".bdf", ".dat", ".nas")  # endings of the model that stands beside the results
UNITS = ("length_unit", "mass_unit")  # m and kg that the units of the model are


def bulk_data_beside(op2: Path) -> Path:
    """Return the bulk data of a run; ValueError if there is none."""
    found = [path for ending in BULK_DATA if (path := op2.with_suffix(ending)).is_file()]
    if not found:
        raise ValueError(
            f"{op2.stem}{BULK_DATA[0]}: missing; the model stands beside its results, as {' or '.join(BULK_DATA)}"
        )
    return found[0]


def nastran_data(arrays: Mapping[str, Any], beside: Path) -> ModalData:
    """Return modal data of the arrays of `nastran_extract`.

    Parameters
    ----------
    arrays : in the units of the model
    beside : .toml of the same name: damping ratio, kind, interface, units; it may be missing

    Raises
    ------
    ValueError
        If rigid modes are among those of a structure that is said to be clamped, or the file is wrong.
    """
    body = read_body(beside, UNITS) if beside.is_file() else {"kind": "clamped"}
    length, mass = (float(body.pop(unit, 1.0)) for unit in UNITS)
    if not (length > 0.0 and mass > 0.0):
        raise ValueError(f"{beside.name}: {' and '.join(UNITS)} must be > 0, got {length:g} and {mass:g}")
    frequency = np.asarray(arrays["frequency"], np.float64)
    rigid = int(np.sum(frequency < STILL * np.max(frequency[:7])))
    if body["kind"] == "clamped" and rigid:
        raise ValueError(
            f"the first {rigid} of {len(frequency)} modes move rigidly, as nothing holds the model: write"
            f' kind = "free" and interface = "NODE", the node that the bus is, in {beside.name}'
        )
    damping_ratio = ratios(body, len(frequency))
    body.pop("damping_ratio", None)
    modal_mass = arrays.get("modal_mass")
    if modal_mass is None:  # normalised by the mass of the model's units
        modal_mass = np.ones(len(frequency))
    return ModalData(
        frequency=frequency,
        damping_ratio=damping_ratio,
        node_name=tuple(str(name) for name in arrays["node_name"]),
        node_position=length * arrays["node_position"],
        node_translation=length * arrays["node_translation"],
        node_rotation=np.asarray(arrays["node_rotation"]),
        modal_mass=mass * length**2 * modal_mass,
        node_mass=mass * arrays["node_mass"],
        node_inertia=mass * length**2 * arrays["node_inertia"],
        edges=np.asarray(arrays["edges"], np.intp),
        **{**_whole(arrays.get("rigid_mass"), length, mass), **body},
    )


def _whole(rigid: Array | None, length: float, mass: float) -> dict[str, Any]:
    """Return mass, centre of mass and inertia of NASTRAN's own 6 by 6 matrix about the origin, if the run has it."""
    if rigid is None or not rigid[0, 0] > 0.0:
        return {}
    return {
        "mass": mass * float(rigid[0, 0]),
        "centre_of_mass": length * np.array([rigid[1, 5], rigid[2, 3], rigid[0, 4]]) / rigid[0, 0],
        "inertia": mass * length**2 * np.array(rigid[3:, 3:]),
    }
