"""Read the appendages of a spacecraft's file, [[appendages]], with the modal files that they name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from ..errors import SpacecraftFileError
from ..structure.modal_data import ModalData, structure_from
from ..structure.modal_file import LARGEST, read_modal
from ..structure.structure import Structure
from .appendage import Appendage
from .fields import make, read_fields
from .lines import Key
from .placed_devices import read_axis
from .source import Source

KEYS = ("file", "axis", "damping_ratio")  # beside the fields of an appendage


def read_appendages(source: Source, entries: Any, folder: Path) -> tuple[tuple[Appendage, ...], dict[str, bytes]]:
    """Return the appendages, and the content of their modal files by name.

    Parameters
    ----------
    folder : of the spacecraft's file, from which paths of modal files go; a copy of one may lie in it under its name

    Raises
    ------
    SpacecraftFileError
        If one is refused.
    """
    if not isinstance(entries, list):
        source.refuse(["appendages"], "must be tables; write [[appendages]] before each one", entries)
    found, files = [], dict[str, bytes]()
    for k, entry in enumerate(entries):
        keys: list[Key] = ["appendages", k]
        values = read_fields(source, entry, keys, Appendage, without=("structure", "axis"), also=KEYS)
        for key in ("name", "file"):
            if not isinstance(entry.get(key), str):
                source.refuse(keys, f"{key} is missing; write for example"
                              f' {key} = "{"north" if key == "name" else "array.npz"}"')  # fmt: skip
        if "axis" in entry and not {"angle", "turns"} & entry.keys():
            source.refuse([*keys, "axis"], "is that of a drive; give its angle, or turns = true, too", entry["axis"])
        if "axis" in entry:
            values["axis"] = read_axis(source, entry["axis"], [*keys, "axis"])
        name, content = _content(source, entry["file"], [*keys, "file"], folder)
        if files.setdefault(name, content) != content:
            source.refuse([*keys, "file"], "another modal file has this name; rename one", entry["file"])
        structure = _structure(source, content, entry, keys)
        found.append(make(source, keys, Appendage, {**values, "structure": structure}))
    return tuple(found), files


def _content(source: Source, given: str, keys: list[Key], folder: Path) -> tuple[str, bytes]:
    path = folder / given
    if not path.is_file() and (folder / path.name).is_file():
        path = folder / path.name  # a copy beside the FMUs
    try:
        if path.stat().st_size > LARGEST:
            source.refuse(keys, "is larger than 2 GB; keep fewer modes or nodes", given)
        return path.name, path.read_bytes()
    except OSError as error:
        source.refuse(keys, f"cannot be read ({error.strerror}); `flexsat modal` writes modal files", given)


def _structure(source: Source, content: bytes, entry: Any, keys: list[Key]) -> Structure:
    try:
        data = read_modal(content)
        if "damping_ratio" in entry:
            data = _damped(source, data, entry["damping_ratio"], [*keys, "damping_ratio"])
        return structure_from(data)
    except SpacecraftFileError:
        raise
    except ValueError as error:
        source.refuse([*keys, "file"], str(error), entry["file"])


def _damped(source: Source, data: ModalData, ratio: Any, keys: list[Key]) -> ModalData:
    if isinstance(ratio, bool) or not isinstance(ratio, (int, float)) or not 0.0 <= ratio < 1.0:
        source.refuse(keys, "must be a number >= 0 and < 1, of every mode", ratio)
    return replace(data, damping_ratio=0.0 * data.damping_ratio + ratio)
