"""Read and write modal data as an .npz file: named arrays, described in docs/modal_files.md."""

from __future__ import annotations

import io
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from .modal_data import KINDS, ModalData

FORMAT = "flexsat modal 1"
LARGEST = 2**31  # bytes
_TEXTS = ("kind", "interface", "source")
_NEEDED = ("kind", "frequency", "damping_ratio", "node_position", "node_translation")


def modal_bytes(data: ModalData) -> bytes:
    """Return the content of a modal file: the same data give the same bytes."""
    arrays: dict[str, Any] = {"format": np.array(FORMAT)}
    for item in fields(data):
        value = getattr(data, item.name)
        if value is not None and not (isinstance(value, (str, tuple)) and not value):
            arrays[item.name] = np.asarray(value)
    memory = io.BytesIO()
    np.savez_compressed(memory, **arrays)
    return memory.getvalue()


def write_modal(path: Path, data: ModalData) -> None:
    """Write a modal file; raise OSError if it cannot be written."""
    path.write_bytes(modal_bytes(data))


def read_modal(content: bytes) -> ModalData:
    """Read the content of a modal file.

    Raises
    ------
    ValueError
        If it is none, lacks an array, or has one that is unknown or of the wrong shape.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"not a modal file, an .npz with arrays as in docs/modal_files.md: {error}") from None
    if str(arrays.pop("format", "")) != FORMAT:
        raise ValueError(f'not a modal file: its array format must be "{FORMAT}"')
    known = [item.name for item in fields(ModalData)]
    for name in arrays:
        if name not in known:
            raise ValueError(f"{name}: no such array; there are {', '.join(known)}")
    for name in _NEEDED:
        if name not in arrays:
            raise ValueError(f"{name}: missing; docs/modal_files.md lists what a modal file has")
    values: dict[str, Any] = {name: str(arrays[name]) for name in _TEXTS if name in arrays}
    if values["kind"] not in KINDS:
        raise ValueError(f"kind must be {' or '.join(KINDS)}, got {values['kind']!r}")
    values["node_name"] = tuple(str(name) for name in np.atleast_1d(arrays.get("node_name", np.zeros(0, dtype=str))))
    for name, array in arrays.items():
        if name not in values:
            values[name] = _numbers(name, array)
    count, nodes = len(np.atleast_1d(values["frequency"])), len(values["node_position"])
    values["damping_ratio"] = np.broadcast_to(values["damping_ratio"], (count,)).copy()
    _check_shapes(values, count, nodes)
    if "mass" in values:
        values["mass"] = float(values["mass"])
    return ModalData(**values)


def _numbers(name: str, array: Any) -> Any:
    wanted = "iu" if name == "edges" else "iuf"
    if array.dtype.kind not in wanted:
        raise ValueError(f"{name} must be numbers, got {array.dtype}")
    if name == "edges":
        return array.astype(np.intp)
    numbers = array.astype(np.float64)
    if not np.all(np.isfinite(numbers)):
        raise ValueError(f"{name} must be finite numbers")
    return numbers


def _check_shapes(values: dict[str, Any], modes: int, nodes: int) -> None:
    by_mode, shapes = (modes,), (nodes, 3, modes)
    expected = {
        "frequency": by_mode,
        "damping_ratio": by_mode,
        "modal_mass": by_mode,
        "node_position": (nodes, 3),
        "node_translation": shapes,
        "node_rotation": shapes,
        "mass": (),
        "centre_of_mass": (3,),
        "inertia": (3, 3),
        "translation": (3, modes),
        "rotation": (3, modes),
        "node_mass": (nodes,),
        "node_inertia": (nodes, 3, 3),
    }
    for name, shape in expected.items():
        if name in values and np.shape(values[name]) != shape:
            raise ValueError(
                f"{name} must be {shape} for {modes} modes and {nodes} nodes, got {np.shape(values[name])}"
            )
    if not modes:
        raise ValueError("frequency: there are no modes")
    for name in ("frequency", "modal_mass"):
        if name in values and not np.all(values[name] >= 0.0):
            raise ValueError(f"{name} must be >= 0")
    if not np.all((values["damping_ratio"] >= 0.0) & (values["damping_ratio"] < 1.0)):
        raise ValueError("damping_ratio must be >= 0 and < 1")
    if values["node_name"] and len(values["node_name"]) != nodes:
        raise ValueError(f"node_name must name all {nodes} nodes, got {len(values['node_name'])}")
    if len(set(values["node_name"])) != len(values["node_name"]):
        raise ValueError("node_name: two nodes have the same name")
    edges = values.get("edges", np.zeros((0, 2), dtype=np.intp))
    if edges.ndim != 2 or edges.shape[1] != 2 or (edges.size and not 0 <= edges.min() <= edges.max() < nodes):
        raise ValueError(f"edges must be pairs of nodes from 0 to {nodes - 1}")
