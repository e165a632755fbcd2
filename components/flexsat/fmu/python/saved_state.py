"""Turn the state of a stepper into bytes and back, exactly: no pickle, no loss, readable by a new process.

A state is made of dataclasses, numpy arrays and scalars, random generators, deques, lists, tuples, dicts with
string keys, and plain values, nested at will. The bytes are a JSON tree, one line, followed by the arrays' memory.
"""

from __future__ import annotations

import copy
import json
import sys
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_PLAIN = (bool, int, float, str)  # exact types; a numpy float is not plain, and stays what it is


def encode(state: object) -> bytes:
    """Write a state. What cannot be written is refused with its place, such as `state.filter.memory[2]`."""
    blobs: list[bytes] = []
    tree = json.dumps(_encoded(state, "state", blobs), separators=(",", ":"))
    return b"\n".join([tree.encode("ascii"), b"".join(blobs)])


def decode(data: bytes) -> Any:
    """Read what `encode` wrote, as new objects.

    Raises
    ------
    ValueError
        If the bytes were cut short or are something else, or name a class that is not loaded here.
    """
    head, separator, blob = data.partition(b"\n")
    try:
        if not separator:
            raise ValueError("no tree")
        reader = _Reader(blob)
        state = reader.decoded(json.loads(head))
        if reader.position != len(blob):
            raise ValueError("arrays and tree disagree")
        return state
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ValueError(f"these bytes are not a saved state of this component: {error}") from error


def sealed(owner: str, content: Mapping[str, Any]) -> bytes:
    """Write a state with the name of what it belongs to in front."""
    return owner.encode() + b"\n" + encode(dict(content))


def unsealed(owner: str, data: bytes) -> dict[str, Any]:
    """Read what `sealed` wrote; raise ValueError if it belongs to another owner or is no state."""
    name, _, content = data.partition(b"\n")
    if name != owner.encode():
        raise ValueError(f"the saved state belongs to {name[:60]!r}, this is {owner}")
    saved: dict[str, Any] = decode(content)
    return saved


def restored(live: Any, saved: Any) -> Any:
    """Give `live` the value of `saved`, in place wherever the two have the same shape, and return it.

    In place matters: buffers of a stepper may be views of one array, and one generator may be shared.
    """
    if type(live) is not type(saved):
        return saved
    if isinstance(live, np.ndarray):
        if live.shape != saved.shape or live.dtype != saved.dtype or not live.flags.writeable:
            return saved
        np.copyto(live, saved)
        return live
    if isinstance(live, np.random.Generator):
        if type(live.bit_generator) is not type(saved.bit_generator):
            return saved
        live.bit_generator.state = saved.bit_generator.state
        return live
    if isinstance(live, (list, deque)):
        if isinstance(live, deque) and live.maxlen != saved.maxlen:
            return saved
        kept = [restored(old, new) for old, new in zip(live, saved, strict=False)]
        rest = list(saved)[len(kept) :]
        live.clear()
        live.extend(kept + rest)
        return live
    if isinstance(live, dict):
        merged = {key: restored(live[key], value) if key in live else value for key, value in saved.items()}
        live.clear()
        live.update(merged)
        return live
    if isinstance(live, tuple):
        return (
            tuple(restored(old, new) for old, new in zip(live, saved, strict=True))
            if len(live) == len(saved)
            else saved
        )
    if is_dataclass(live):
        return _restored_dataclass(live, saved)
    return saved


def _restored_dataclass(live: Any, saved: Any) -> Any:
    changed = {}
    for item in fields(live):
        old = getattr(live, item.name)
        new = restored(old, getattr(saved, item.name))
        if new is not old:
            changed[item.name] = new
    if changed and live.__dataclass_params__.frozen:
        live = copy.copy(live)  # somebody may hold the old one and trust that it is frozen
    for name, value in changed.items():
        object.__setattr__(live, name, value)
    return live


def _encoded(value: Any, place: str, blobs: list[bytes]) -> Any:
    if value is None or type(value) in _PLAIN:
        return value
    if isinstance(value, (np.ndarray, np.generic)) and value.dtype.kind in "biufcSU":
        fortran = value.flags.f_contiguous and not value.flags.c_contiguous  # layout decides the rounding of products
        blobs.append(value.tobytes("F" if fortran else "C"))
        tag = "array" if isinstance(value, np.ndarray) else "scalar"
        return {tag: [value.dtype.str, list(value.shape), "F" if fortran else "C"]}
    if isinstance(value, np.random.Generator):
        inner = value.bit_generator
        return {"generator": [type(inner).__name__, _encoded(dict(inner.state), f"{place}.bit_generator", blobs)]}
    if type(value) in (list, tuple):
        return {type(value).__name__: [_encoded(item, f"{place}[{i}]", blobs) for i, item in enumerate(value)]}
    if type(value) is deque:
        items = [_encoded(item, f"{place}[{i}]", blobs) for i, item in enumerate(value)]
        return {"deque": [value.maxlen, items]}
    if type(value) is dict and all(type(key) is str for key in value):
        return {"dict": {key: _encoded(item, f"{place}[{key!r}]", blobs) for key, item in value.items()}}
    if is_dataclass(value) and not isinstance(value, type) and "<locals>" not in type(value).__qualname__:
        kind = type(value)
        inside = {
            item.name: _encoded(getattr(value, item.name), f"{place}.{item.name}", blobs) for item in fields(kind)
        }
        return {"dataclass": [kind.__module__, kind.__qualname__, inside]}
    raise ValueError(f"{place}: a {type(value).__qualname__} cannot be saved")


class _Reader:
    """Take the arrays from the blob in the order of the tree."""

    def __init__(self, blob: bytes) -> None:
        self.blob = blob
        self.position = 0

    def decoded(self, tree: Any) -> Any:
        if not isinstance(tree, dict):
            return tree
        ((tag, content),) = tree.items()
        builders: dict[str, Callable[[Any], Any]] = {
            "array": self._array,
            "scalar": lambda spec: self._array(spec)[()],
            "generator": self._generator,
            "list": lambda items: [self.decoded(item) for item in items],
            "tuple": lambda items: tuple(self.decoded(item) for item in items),
            "deque": lambda pair: deque((self.decoded(item) for item in pair[1]), maxlen=pair[0]),
            "dict": lambda items: {key: self.decoded(item) for key, item in items.items()},
            "dataclass": self._dataclass,
        }
        return builders[tag](content)

    def _array(self, spec: list[Any]) -> np.ndarray[Any, Any]:
        dtype, shape, order = np.dtype(spec[0]), tuple(spec[1]), spec[2]
        count = int(np.prod(shape, dtype=np.int64))
        flat = np.frombuffer(self.blob, dtype=dtype, count=count, offset=self.position) if count else np.empty(0, dtype)
        self.position += flat.nbytes
        return flat.reshape(shape, order=order).copy(order=order)

    def _generator(self, spec: list[Any]) -> np.random.Generator:
        inner = getattr(np.random, spec[0])()
        inner.state = self.decoded(spec[1])
        return np.random.Generator(inner)

    def _dataclass(self, spec: list[Any]) -> Any:
        module, path, inside = spec
        kind: Any = sys.modules[module]
        for name in path.split("."):
            kind = getattr(kind, name)
        if not (isinstance(kind, type) and is_dataclass(kind)):
            raise ValueError(f"{module}.{path} is not a dataclass")
        made = object.__new__(kind)  # not __init__: it would validate, or compute, once more
        for name, item in inside.items():
            object.__setattr__(made, name, self.decoded(item))
        return made
