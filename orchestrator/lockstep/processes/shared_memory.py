"""The memory shared by master and worker: the record of the last call, then a region for each set of values."""

from __future__ import annotations

import mmap
from typing import Any

import numpy as np

from lockstep.fmi.slave import DTYPES, Buffer, Scalar
from lockstep.operating_system import anonymous_memory
from lockstep.processes import last_call
from lockstep.processes.last_call import LastCall
from lockstep.processes.string_transfer import RAW

SIZE = 2**28  # bytes of address space; pages that are never touched take no memory
REGIONS = last_call.SIZE  # where they begin
_ALIGNMENT = 64  # one cache line


class SharedMemory:
    """One process's view. Only the master allocates; both use the same offsets."""

    def __init__(self, file: int) -> None:
        self._map = mmap.mmap(file, SIZE)
        self.last_call = LastCall(self._map)
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


def _dtype(scalar: Scalar) -> np.dtype[Any]:
    return RAW if scalar == "String" else np.dtype(DTYPES[scalar])


def shared_file() -> int:
    """Return the descriptor of a new file in memory of the right size."""
    return anonymous_memory(SIZE)
