"""Texts between the master and a worker: through the shared memory like numbers, up to a length."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.slave import WARNING

LONGEST_TEXT = 4096  # bytes as UTF-8
RAW = np.dtype(f"S{LONGEST_TEXT}")

Call = Callable[[], int]
Raw = NDArray[Any]  # of RAW


def encoded(texts: NDArray[Any]) -> list[bytes]:
    """Return texts as they travel, or raise ValueError."""
    found = [str(text).encode() for text in texts]
    longest = max(map(len, found))
    if longest > LONGEST_TEXT:
        raise ValueError(f"a text of {longest} bytes; at most {LONGEST_TEXT} travel to and from an isolated FMU")
    return found


def decoded(raw: Raw) -> list[str]:
    """Return texts that have travelled."""
    return [text.decode("utf-8", "replace") for text in raw.tolist()]


def then_decode(call: Call, raw: Raw, texts: NDArray[Any]) -> Call:
    """Return a call that takes texts out of `raw`, which the given one fills."""

    def get() -> int:
        status = call()
        if status <= WARNING:
            texts[:] = decoded(raw)
        return status

    return get


def first_decode(raw: Raw, texts: NDArray[Any], call: Call) -> Call:
    """Return a call that takes texts out of `raw` before the given one hands them over."""

    def put() -> int:
        texts[:] = decoded(raw)
        return call()

    return put


def then_encode(call: Call, texts: NDArray[Any], raw: Raw, refuse: Callable[[str], int]) -> Call:
    """Return a call that puts texts into `raw` that the given one got; `refuse` says why that fails."""

    def get() -> int:
        status = call()
        if status <= WARNING:
            try:
                raw[:] = encoded(texts)
            except ValueError as error:
                return refuse(str(error))
        return status

    return get


def first_encode(texts: NDArray[Any], raw: Raw, call: Call, refuse: Callable[[str], int]) -> Call:
    """Return a call that puts texts into `raw` before the given one takes them from there."""

    def put() -> int:
        try:
            raw[:] = encoded(texts)
        except ValueError as error:
            return refuse(str(error))
        return call()

    return put
