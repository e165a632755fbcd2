"""Pack the saved state of an FMU, named arrays and numbers, into bytes and back: exact, and readable by a new process.

Layout: one line of ASCII JSON, a line feed, the memory of the arrays in the order of the line, in C order and without
gaps, and the BLAKE2b digest, 16 bytes, of all before it: damaged bytes are refused, whatever they would mean. The line
is `{"component": GUID, "layout": 2, "values": {name: [type, shape], ...}}` with numpy's names of types, byte order
included (`<f8`). A number is an array of shape []; a text is the bytes of its UTF-8.

Names: `life_cycle.phase`, `life_cycle.experiment`, `life_cycle.time`, `life_cycle.step`, `life_cycle.started`,
`life_cycle.stale` and `life_cycle.inputs_set` (numbers); `ports.real`, `ports.integer` and `ports.boolean`, each in the
order of value references; `ports.string`, the texts in that order, each ended by a zero byte; and `state.<name>`, the
model's own (flexsat.runtime.named_state).
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...runtime.named_state import NamedValues, named_values, restore_values

LAYOUT = 2  # version of the layout
DIGEST = 16  # bytes
TYPES = frozenset({"<f8", "<i8", "<u8", "<i4", "<u4", "|u1", "|b1"})  # of the arrays; no other is made from bytes
AnyArray = np.ndarray[Any, Any]


class ModelState:
    """What a component adds to its life cycle: the state of its model, and how that is saved."""

    state: Any = None

    def saved_state(self) -> NamedValues:
        """Return the model's state as named arrays and numbers."""
        return named_values(self.state)

    def restore_state(self, saved: Mapping[str, AnyArray], /) -> None:
        """Write a saved state back; raise ValueError if it does not fit."""
        restore_values(self.state, saved)


def pack_state(component: str, values: Mapping[str, AnyArray]) -> bytes:
    """Return the bytes of a saved state of the component with this GUID; raise ValueError for another type of array."""
    for name, array in values.items():
        if array.dtype.str not in TYPES:
            raise ValueError(f"{name} has the type {array.dtype.str!r}; there are {', '.join(sorted(TYPES))}")
    head = {
        "component": component,
        "layout": LAYOUT,
        "values": {name: [array.dtype.str, list(array.shape)] for name, array in values.items()},
    }
    line = json.dumps(head, separators=(",", ":")).encode("ascii")
    content = b"\n".join([line, b"".join(array.tobytes() for array in values.values())])
    return content + digest(content)


def digest(content: bytes) -> bytes:
    """Return what stands at the end of a saved state."""
    return hashlib.blake2b(content, digest_size=DIGEST).digest()


def unpack_state(component: str, data: bytes) -> dict[str, AnyArray]:
    """Return the named values of a saved state, as new arrays.

    Raises
    ------
    ValueError
        If the bytes were cut short, changed or are no saved state, or belong to another component.
    """
    content, found = data[:-DIGEST], data[-DIGEST:]
    line, separator, memory = content.partition(b"\n")
    try:
        if found != digest(content):
            raise ValueError("cut short, or changed since they were saved")
        if not separator:
            raise ValueError("no first line")
        head = json.loads(line)
        owner, layout, listed = head["component"], head["layout"], head["values"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"these bytes are not a saved state of this component: {error}") from error
    if owner != component:
        raise ValueError(f"the saved state belongs to {str(owner)[:60]}, this is {component}")
    if layout != LAYOUT:
        raise ValueError(f"the saved state has layout {layout!r}; this component reads layout {LAYOUT}")
    try:
        return _arrays(listed, memory)
    except (ValueError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f"these bytes are not a saved state of this component: {error}") from error


def _arrays(listed: Mapping[str, list[Any]], memory: bytes) -> dict[str, AnyArray]:
    found: dict[str, AnyArray] = {}
    position = 0
    for name, (kind, shape) in listed.items():
        if kind not in TYPES:
            raise ValueError(f"{name} has the type {kind!r}; there are {', '.join(sorted(TYPES))}")
        if not all(type(length) is int and length >= 0 for length in shape):
            raise ValueError(f"{name} has the shape {shape!r}")
        dtype = np.dtype(kind)
        size = math.prod(shape) * dtype.itemsize
        part = memory[position : position + size]
        if len(part) != size:
            raise ValueError(f"{name} has {len(part)} of its {size} bytes")
        found[name] = np.frombuffer(part, dtype=dtype).reshape(shape).copy()
        position += size
    if position != len(memory):
        raise ValueError(f"{len(memory) - position} bytes follow the last array")
    return found


def section(values: Mapping[str, AnyArray], prefix: str) -> dict[str, AnyArray]:
    """Return the values whose names begin with `prefix` and a dot, by the rest of their names."""
    return {name.removeprefix(f"{prefix}."): array for name, array in values.items() if name.startswith(f"{prefix}.")}


def prefixed(values: Mapping[str, AnyArray], prefix: str) -> dict[str, AnyArray]:
    """Return the values with `prefix` and a dot before their names."""
    return {f"{prefix}.{name}": array for name, array in values.items()}
