"""Check that a checkpoint's header and arrays have the shape in which they are written, and agree with each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.data_text import check_shape
from lockstep.errors import InputError
from lockstep.fmi.slave import SCALARS
from lockstep.results.read_run_record import check_whole_record
from lockstep.system.clock import read_nanoseconds

WAITING = "rows/waiting"  # among the arrays: rows that were not yet on disk
PARTS = ("version", "output", "value")  # of the bus: arrays of each component and type
_KINDS = {"Real": "f", "String": "U"}  # of the values, as numpy names them; all others are integers
_REMEDY = "use another one"
_HEADER = {
    "tick": "whole number",
    "time": "time",
    "wall_time": "number",
    "identity": {
        "tick": "time",
        "?start_time": "time",
        "components": {
            "*": {
                "source": "text", "sha256": "text", "adapter": "text", "period": "time",
                "offset": "time", "kind": "text", "parameters": "table", "?shadow": "list",
            }
        },
        "connections": {"*": "list"},
    },
    "run": "table",
    "outputs": {"*": {"*": ["text"]}},
    "rows": "whole number",
    "events": {"size": "whole number", "counts": {"*": "whole number"}},
    "faults": {"memory": "list", "altered": ["list"], "present": ["list"]},
    "checkpoints": {"times": ["text"], "every": "text?", "without": ["text"]},
}  # fmt: skip


def check_header(header: Mapping[str, Any], where: str) -> None:
    """Raise InputError if the header lacks something, or a time or a number of rows cannot be."""
    shape = {key: each for key, each in _HEADER.items() if key != "faults" or header.get(key) is not None}
    check_shape(header, shape, where, _REMEDY)
    check_whole_record(header["run"], where, _REMEDY)
    tick, identity = header["tick"], header["identity"]
    given = {"time": header["time"], "identity.tick": identity["tick"], "start_time": identity.get("start_time", 0)}
    time, length, start = (read_nanoseconds(value, f"{where}: {name}") for name, value in given.items())
    if length <= 0 or tick < 0 or time != start + tick * length:
        times = f"tick = {tick} of {length} ns and time = {time} ns"
        raise InputError(f"{where}: {times} do not agree, or are < 0; {_REMEDY}")
    for name, value in {"rows": header["rows"], "wall_time": header["wall_time"], **header["events"]["counts"],
                        "events.size": header["events"]["size"]}.items():  # fmt: skip
        if not 0 <= value < float("inf"):
            raise InputError(f"{where}: {name} = {value} must be >= 0; {_REMEDY}")


def check_arrays(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], where: str) -> None:
    """Raise InputError if an array is missing, or is not what the header says of it."""
    _check_array(arrays, WAITING, "u", where)
    if arrays[WAITING].dtype != np.uint8:
        raise InputError(f"{where}: its array {WAITING} is of {arrays[WAITING].dtype}, and must be bytes; {_REMEDY}")
    for component, by_type in header["outputs"].items():
        for scalar, names in by_type.items():
            if scalar not in SCALARS:
                raise InputError(f"{where}: outputs.{component}: {scalar!r} is no type of values; {_REMEDY}")
            keys = [f"bus/{component}/{scalar}/{part}" for part in PARTS]
            for key, kind in zip(keys, ("i", "i", _KINDS.get(scalar, "iu")), strict=True):
                _check_array(arrays, key, kind, where)
            sizes = [len(arrays[key]) for key in keys]
            if len(set(sizes)) > 1:
                raise InputError(f"{where}: its arrays {', '.join(keys)} have {sizes} elements; {_REMEDY}")
            output = arrays[keys[1]]
            if not np.array_equal(np.unique(output), np.arange(len(names))):
                raise InputError(f"{where}: its array {keys[1]} does not number the outputs {names}; {_REMEDY}")


def _check_array(arrays: Mapping[str, NDArray[Any]], key: str, kinds: str, where: str) -> None:
    if key not in arrays:
        raise InputError(f"{where}: its array {key} is missing; {_REMEDY}")
    found = arrays[key]
    if found.ndim != 1 or found.dtype.kind not in kinds:
        raise InputError(f"{where}: its array {key} is of shape {found.shape} and type {found.dtype}; {_REMEDY}")
