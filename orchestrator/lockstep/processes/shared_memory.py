"""The memory that the master and a worker share: a header, then one region for each set of values exchanged.

Header: time and step of the doStep asked for [s], the number of the call under way, how long the worker has worked [s],
and the last message logged, which so outlives a crash.
"""

from __future__ import annotations

import mmap
import os
from typing import Any

import numpy as np

from lockstep.fmi.slave import DTYPES, Buffer, Scalar
from lockstep.processes.string_transfer import RAW

SIZE = 2**28  # bytes of address space; pages that nobody touches take no memory
TIME, STEP, PLACE, WORDS, BUSY = range(5)  # 8-byte fields
TEXT, TEXT_SIZE = 64, 960  # bytes
REGIONS = 1024  # where they begin
_ALIGNMENT = 64  # one cache line


class Shared:
    """One process's view. Only the master allocates; both look at the same offsets."""

    def __init__(self, file: int) -> None:
        self._map = mmap.mmap(file, SIZE)
        header = memoryview(self._map)[:TEXT]
        self.reals = header.cast("d")
        self.integers = header.cast("q")
        self._free = REGIONS

    def allocate(self, scalar: Scalar, count: int) -> int:
        """Return the offset of a new region for so many values of a type."""
        offset = self._free
        self._free += -(-count * _dtype(scalar).itemsize // _ALIGNMENT) * _ALIGNMENT
        if self._free > SIZE:
            raise MemoryError(f"more than {SIZE} bytes of values are exchanged with one component")
        return offset

    def region(self, scalar: Scalar, count: int, offset: int) -> Buffer:
        """Return a region as an array of shape (count,)."""
        values: Buffer = np.frombuffer(self._map, _dtype(scalar), count, offset)
        return values

    def say(self, text: str) -> None:
        """Leave a message for whoever looks after a crash."""
        content = text.encode()[:TEXT_SIZE]
        self._map[TEXT : TEXT + len(content)] = content
        self.integers[WORDS] = len(content)

    def said(self) -> str:
        """Return the message that was left, or nothing."""
        length = min(max(0, self.integers[WORDS]), TEXT_SIZE)
        return self._map[TEXT : TEXT + length].decode("utf-8", "replace")


def _dtype(scalar: Scalar) -> np.dtype[Any]:
    return RAW if scalar == "String" else np.dtype(DTYPES[scalar])


def shared_file() -> int:
    """Return the descriptor of a new file in memory of the right size; it has no name that could be left behind."""
    file = os.memfd_create("lockstep")
    os.ftruncate(file, SIZE)
    return file
