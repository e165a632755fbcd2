"""Describe a bound call of an FMU so that C can make it: addresses of function, instance and buffers, all plain.

A bound call that C can make has a description beside it; `native` returns it. Calls of FMUs in other processes, of
adapters and of tables have none, and stay calls in Python.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.log_callbacks import Messages

# `values`: fmiGet and fmiSet of FMI 1.0 and 2.0; `arrays`: of FMI 3.0; `step_N`: doStep of FMI N.0
Kind = Literal["values", "arrays", "step_1", "step_2", "step_3"]
Bound = TypeVar("Bound", bound=Callable[..., int])


def _ignore(_: int) -> None:
    """Note nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Apart:
    """What a step in a thread needs of the instance."""

    messages: Messages
    failed: Callable[[int], None]  # notes a status


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeCall:
    """One call of FMI. `buffer` holds the values; for `step_3` the last time reached, and `flags` are its three."""

    kind: Kind
    function: int  # address
    instance: int  # address
    references: NDArray[np.uint32] | None = None
    buffer: NDArray[Any] | None = None
    flags: NDArray[np.uint8] | None = None
    note: Callable[[int], None] = _ignore  # called with a status above OK, before that is judged
    apart: Apart | None = None  # of a step that a thread may make


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """Copy values in memory before or after a call: buffer[k] = source[index[k]], or buffer[index[k]] = source[k].

    Source and buffer are of one type, or one has Booleans of a byte and the other int32: such are gathered
    from bytes or scattered to them.
    """

    source: NDArray[Any]
    index: NDArray[np.intp]
    buffer: NDArray[Any]
    scatter: bool = False


Native = tuple[NativeCall | Move, ...]  # in turn


def described(call: Bound, *parts: NativeCall | Move) -> Bound:
    """Return a bound call with its description."""
    call.native = parts  # type: ignore[attr-defined]
    return call


def native(call: object) -> Native | None:
    """Return the description of a bound call, None if C cannot make it."""
    found: Native | None = getattr(call, "native", None)
    return found


def step_apart(call: object) -> tuple[NativeCall, Apart] | None:
    """Return the description of a step that a thread may make; None for others."""
    parts = native(call)
    if parts is None or len(parts) != 1:
        return None
    (part,) = parts
    return (part, part.apart) if isinstance(part, NativeCall) and part.apart is not None else None
