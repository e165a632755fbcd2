"""Read modal data as other tools leave them: a folder of CSV tables, results of CalculiX with a file of the body."""

from __future__ import annotations

import csv
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from .calculix import read_calculix
from .modal_data import KINDS, ModalData
from .modal_file import read_modal

BODY = "body.toml"
_VECTORS = {"centre_of_mass": (3,), "inertia": (6,)}
_KEYS = ("kind", "mass", "centre_of_mass", "inertia", "damping_ratio", "interface", "source")
_AXES = ("x", "y", "z")


def read_modal_source(path: Path) -> ModalData:
    """Read a modal file, .npz; a folder of CSV tables; or the .frd of CalculiX with its .dat and .toml beside it.

    Raises
    ------
    ValueError
        If something is missing, or no number.
    OSError
        If a file cannot be read.
    """
    if path.is_dir():
        return _read_tables(path)
    if path.suffix == ".frd":
        return _read_results(path)
    if path.suffix == ".npz":
        return read_modal(path.read_bytes())
    raise ValueError(
        "neither a modal file (.npz), a folder of CSV tables, nor results of CalculiX (.frd) or NASTRAN (.op2)"
    )


def _read_results(path: Path) -> ModalData:
    body = read_body(path.with_suffix(".toml"))
    found = read_calculix(path.read_text(encoding="utf-8"), path.with_suffix(".dat").read_text(encoding="utf-8"))
    return ModalData(
        frequency=found.frequency,
        damping_ratio=ratios(body, len(found.frequency)),
        node_name=found.node_name,
        node_position=found.node_position,
        node_translation=found.node_translation,
        translation=found.participation[:3],
        rotation=found.participation[3:],
        edges=found.edges,
        **{key: value for key, value in body.items() if key != "damping_ratio"},
    )


def read_body(path: Path, also: Sequence[str] = ()) -> dict[str, Any]:
    """Return what a file says of mass, inertia and damping of the whole; `inertia` is about the origin of the axes.

    `also` names further keys, of numbers. ValueError for a file that is missing or wrong.
    """
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ValueError(
            f"{path.name}: missing; write mass [kg], centre_of_mass [m], inertia [kg.m2] as xx, yy, zz, xy, xz, yz"
            " about the origin, and damping_ratio"
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path.name}: not TOML: {error}") from None
    for key in values:
        if key not in (*_KEYS, *also):
            raise ValueError(f"{path.name}: {key}: no such key; there are {', '.join([*_KEYS, *also])}")
    body: dict[str, Any] = {"kind": "clamped", **values}
    if body["kind"] not in KINDS:
        raise ValueError(f"{path.name}: kind must be {' or '.join(KINDS)}, got {body['kind']!r}")
    for key, shape in _VECTORS.items():
        if key in body:
            body[key] = _array(f"{path.name}: {key}", body[key], shape)
    for key in ("mass", *also):
        if key in body:
            body[key] = float(_array(f"{path.name}: {key}", body[key], ()))
    if "inertia" in body:
        xx, yy, zz, xy, xz, yz = body["inertia"]
        body["inertia"] = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return body


def _array(name: str, value: Any, shape: tuple[int, ...]) -> Array:
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise ValueError(f"{name} must be {f'{shape[0]} numbers' if shape else 'a number'}, got {value!r}")
    return array


def ratios(body: dict[str, Any], count: int) -> Array:
    """Return the damping ratio of each mode: that of the whole, 0 if there is none."""
    return np.full(count, float(_array("damping_ratio", body.get("damping_ratio", 0.0), ())))


def _read_tables(folder: Path) -> ModalData:
    """Read body.toml, modes.csv, nodes.csv and shapes.csv, whose columns have the names in docs/modal_files.md."""
    body = read_body(folder / BODY)
    modes = _table(folder / "modes.csv", ("frequency",), ("damping_ratio", *_columns("participation")))
    nodes = _table(folder / "nodes.csv", ("name", *_AXES), ("mass",))
    moved, turned = _columns("translation"), _columns("rotation")
    shapes = _table(folder / "shapes.csv", ("mode", "node", *moved), turned)
    names = tuple(nodes["name"])
    count = len(modes["frequency"])
    shape = np.full((len(names), 6, count), np.nan)
    with_rotation = all(column in shapes for column in turned)
    columns = [*moved, *turned] if with_rotation else list(moved)
    for k, (mode, node) in enumerate(zip(shapes["mode"], shapes["node"], strict=True)):
        if node not in names or not mode.isdigit() or not 1 <= int(mode) <= count:
            raise ValueError(f"shapes.csv:{k + 2}: mode {mode!r}, node {node!r}: no such mode from 1, or no such node")
        for i, column in enumerate(columns):
            shape[names.index(node), i, int(mode) - 1] = _number(shapes[column][k], "shapes.csv", k, column)
    if np.isnan(shape[:, : len(columns)]).any():
        raise ValueError("shapes.csv: must have a row for every mode and node")
    participation = [_column(modes, column, "modes.csv") for column in _columns("participation")]
    damping = _column(modes, "damping_ratio", "modes.csv")
    whole = None if any(column is None for column in participation) else np.array(participation)
    place = np.array([[_number(nodes[axis][k], "nodes.csv", k, axis) for axis in _AXES] for k in range(len(names))])
    return ModalData(
        frequency=_needed(_column(modes, "frequency", "modes.csv")),
        damping_ratio=ratios(body, count) if damping is None else damping,
        node_name=names,
        node_position=place.reshape(len(names), 3),
        node_translation=shape[:, :3],
        node_rotation=shape[:, 3:] if with_rotation else None,
        node_mass=_column(nodes, "mass", "nodes.csv"),
        translation=None if whole is None else whole[:3],
        rotation=None if whole is None else whole[3:],
        **{key: value for key, value in body.items() if key != "damping_ratio"},
    )


def _columns(what: str) -> list[str]:
    if what == "participation":
        return [f"participation_{axis}" for axis in ("x", "y", "z", "rx", "ry", "rz")]
    return [f"{what}_{axis}" for axis in _AXES]


def _table(path: Path, needed: Sequence[str], optional: Sequence[str]) -> dict[str, list[str]]:
    try:
        rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    except FileNotFoundError:
        raise ValueError(f"{path.name}: missing; its columns are {', '.join([*needed, *optional])}") from None
    if not rows:
        raise ValueError(f"{path.name}: empty; its columns are {', '.join([*needed, *optional])}")
    head = [name.strip() for name in rows[0]]
    for name in needed:
        if name not in head:
            raise ValueError(f"{path.name}: column {name} is missing; there are {', '.join(head)}")
    for name in head:
        if name not in (*needed, *optional):
            raise ValueError(f"{path.name}: {name}: no such column; there are {', '.join([*needed, *optional])}")
    for k, row in enumerate(rows[1:], start=2):
        if len(row) != len(head):
            raise ValueError(f"{path.name}:{k}: must have {len(head)} values, got {len(row)}")
    return {name: [row[i].strip() for row in rows[1:]] for i, name in enumerate(head)}


def _column(table: dict[str, list[str]], name: str, file: str) -> Array | None:
    if name not in table:
        return None
    return np.array([_number(text, file, k, name) for k, text in enumerate(table[name])])


def _number(text: str, file: str, row: int, column: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise ValueError(f"{file}:{row + 2}: {column} must be a number, got {text!r}")
    return number


def _needed(values: Array | None) -> Array:
    if values is None or not len(values):
        raise ValueError("modes.csv: there are no modes")
    return values
