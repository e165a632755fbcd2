"""Transfer texts between master and worker through the shared memory, up to a length."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.slave import WARNING

LONGEST_TEXT = 4096  # bytes as UTF-8
RAW = np.dtype(f"S{LONGEST_TEXT}")

Transfer = Callable[[], int]
Raw = NDArray[Any]  # of RAW


def encoded(texts: NDArray[Any]) -> list[bytes]:
    """Encode texts for the shared memory, or raise ValueError."""
    found = [str(text).encode() for text in texts]
    longest = max(map(len, found))
    if longest > LONGEST_TEXT:
        raise ValueError(f"a text of {longest} bytes; at most {LONGEST_TEXT} travel to and from an isolated FMU")
    return found


def decoded(raw: Raw) -> list[str]:
    """Decode texts from the shared memory."""
    return [text.decode("utf-8", "replace") for text in raw.tolist()]


def then_decode(call: Transfer, raw: Raw, texts: NDArray[Any]) -> Transfer:
    """Return a call that decodes texts from `raw` after the given one has filled it."""

    def get() -> int:
        status = call()
        if status <= WARNING:
            texts[:] = decoded(raw)
        return status

    return get


def first_decode(raw: Raw, texts: NDArray[Any], call: Transfer) -> Transfer:
    """Return a call that decodes texts from `raw` before the given one sets them."""

    def put() -> int:
        texts[:] = decoded(raw)
        return call()

    return put


def then_encode(call: Transfer, texts: NDArray[Any], raw: Raw, refuse: Callable[[str], int]) -> Transfer:
    """Return a call that encodes into `raw` the texts that the given one gets; `refuse` reports a failure."""

    def get() -> int:
        status = call()
        if status <= WARNING:
            try:
                raw[:] = encoded(texts)
            except ValueError as error:
                return refuse(str(error))
        return status

    return get


def first_encode(texts: NDArray[Any], raw: Raw, call: Transfer, refuse: Callable[[str], int]) -> Transfer:
    """Return a call that encodes texts into `raw` before the given one reads that."""

    def put() -> int:
        try:
            raw[:] = encoded(texts)
        except ValueError as error:
            return refuse(str(error))
        return call()

    return put
