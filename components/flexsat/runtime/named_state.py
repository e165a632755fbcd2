"""Read the state of a component as named arrays and numbers, and write such a set back. numpy alone.

A name is the path of fields to a value, such as `structure` or `profile.axis`. A number is an array of shape ().
A random generator gives the numbers of its bit generator: `noise.state.state`, `noise.state.inc`, `noise.has_uint32`,
`noise.uinteger`; whole numbers beyond 64 bits stand as (low, high) words of 64 bits. Fields declared with NOT_SAVED
are left out: each step writes them before it reads them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

NamedValues = dict[str, np.ndarray[Any, Any]]
NOT_SAVED: Mapping[str, bool] = MappingProxyType({"saved": False})  # metadata of a field
WORD = 64  # bits
GENERATORS = ("PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64")  # bit generators that are saved; no others
# The greatest value of each of their numbers that is less than its type allows: numpy does not check, and would read
# beyond the generator's memory.
GREATEST: Mapping[str, int] = MappingProxyType(
    {"has_uint32": 1, "uinteger": 2**32 - 1, "pos": 624, "buffer_pos": 4},
)


def named_values(state: object) -> NamedValues:
    """Return every value of a state by name, as copies; a state of None has none.

    Raises
    ------
    ValueError
        For a field that is no array of numbers, no number, no tuple of floats, no generator and no dataclass.
    """
    return {} if state is None else dict(_values(state, ""))


def restore_values(state: object, saved: Mapping[str, np.ndarray[Any, Any]]) -> None:
    """Write saved values into a state of the same component, arrays in place; nothing is written if one does not fit.

    Raises
    ------
    ValueError
        If a name is missing or unknown, or a shape or type differs.
    """
    for name, value in named_values(state).items():
        if name not in saved:
            raise ValueError(f"the saved state lacks {name}, which this component needs")
        found = saved[name]
        if found.shape != value.shape or found.dtype != value.dtype:
            raise ValueError(
                f"{name} is {found.dtype} {found.shape} in the saved state, and {value.dtype} {value.shape} in this"
                " component"
            )
    unknown = sorted(saved.keys() - named_values(state).keys())
    if unknown:
        raise ValueError(f"the saved state has {unknown[0]}, which this component does not know")
    if state is not None:
        _check_generators(state, "", saved)
        _write(state, "", saved)


def _check_generators(state: Any, prefix: str, saved: Mapping[str, np.ndarray[Any, Any]]) -> None:
    for _, name, value in _saved_fields(state, prefix):
        if isinstance(value, np.random.Generator):
            for number, greatest in GREATEST.items():
                for path in (f"{name}.{number}", f"{name}.state.{number}"):
                    if path in saved and not saved[path] <= greatest:
                        raise ValueError(f"{path} must be <= {greatest}, got {saved[path].item()}")
        elif is_dataclass(value):
            _check_generators(value, f"{name}.", saved)


def _saved_fields(state: Any, prefix: str) -> Iterator[tuple[str, str, Any]]:
    """Yield (field, name, value) of each field that belongs to a saved state."""
    for item in fields(state):
        if item.metadata.get("saved", True):
            yield item.name, f"{prefix}{item.name}", getattr(state, item.name)


def _values(state: Any, prefix: str) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    for _, name, value in _saved_fields(state, prefix):
        if isinstance(value, np.random.Generator):
            yield from _generator_values(_bit_generator_state(name, value), f"{name}.")
        elif is_dataclass(value):
            yield from _values(value, f"{name}.")
        else:
            yield name, _array(name, value)


def _array(name: str, value: object) -> np.ndarray[Any, Any]:
    """Return an array of numbers, a number or a tuple of floats as a new array in C order."""
    if isinstance(value, tuple) and value and all(type(item) is float for item in value):
        return np.array(value)
    if isinstance(value, (bool, int, float, np.ndarray, np.generic)):
        array = np.array(value, order="C")
        if array.dtype.kind in "biuf":
            return array
    raise ValueError(f"state.{name}: a {type(value).__qualname__} cannot be saved; a state is arrays and numbers")


def _bit_generator_state(name: str, generator: np.random.Generator) -> Mapping[str, Any]:
    state: Mapping[str, Any] = generator.bit_generator.state
    if state["bit_generator"] not in GENERATORS:
        raise ValueError(f"state.{name}: a {state['bit_generator']} cannot be saved; use {', '.join(GENERATORS)}")
    return state


def _generator_values(state: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    for key, value in state.items():
        if isinstance(value, Mapping):
            yield from _generator_values(value, f"{prefix}{key}.")
        elif isinstance(value, int):
            words = [value & (2**WORD - 1), value >> WORD] if key in ("state", "inc") else value
            yield f"{prefix}{key}", np.array(words, dtype=np.uint64)
        elif isinstance(value, np.ndarray):
            yield f"{prefix}{key}", value.copy()


def _write(state: Any, prefix: str, saved: Mapping[str, np.ndarray[Any, Any]]) -> None:
    for field, name, value in _saved_fields(state, prefix):
        if isinstance(value, np.ndarray):
            np.copyto(value, saved[name])
        elif isinstance(value, np.random.Generator):
            value.bit_generator.state = _generator_state(_bit_generator_state(name, value), f"{name}.", saved)
        elif is_dataclass(value):
            if value.__dataclass_params__.frozen:  # type: ignore[union-attr]  # others may hold it: make a new one
                value = _copy(value)
                object.__setattr__(state, field, value)
            _write(value, f"{name}.", saved)
        else:
            new = tuple(saved[name].tolist()) if isinstance(value, tuple) else saved[name].item()
            object.__setattr__(state, field, new)


def _copy(value: Any) -> Any:
    """Return a copy of a dataclass, with copies of its arrays."""
    made = object.__new__(type(value))  # not by its constructor, which would check or compute again
    for item in fields(value):
        inner = getattr(value, item.name)
        object.__setattr__(made, item.name, inner.copy() if isinstance(inner, np.ndarray) else inner)
    return made


def _generator_state(live: Mapping[str, Any], prefix: str, saved: Mapping[str, np.ndarray[Any, Any]]) -> dict[str, Any]:
    """Return the state of a bit generator with its numbers replaced by the saved ones."""
    state: dict[str, Any] = {}
    for key, value in live.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            state[key] = _generator_state(value, f"{name}.", saved)
        elif isinstance(value, int):
            words = saved[name].reshape(-1).tolist()
            state[key] = sum(word << (WORD * k) for k, word in enumerate(words))
        else:
            state[key] = saved[name].copy() if isinstance(value, np.ndarray) else value
    return state
