"""The memory shared by master and worker: the last call, the numbers of request and answer, values, and a message.

The pipes between the two carry single bytes, each of which wakes the other end. What is requested and answered stands
here, with a number: a byte that somebody else writes to a pipe, such as an FMU or a process that it started, wakes a
process that finds no new number, and waits on.
"""

from __future__ import annotations

import mmap
from ctypes import addressof, c_char
from typing import Any

import numpy as np

from lockstep.fmi.slave import DTYPES, Buffer, Scalar
from lockstep.operating_system import anonymous_memory, hide_from_copies
from lockstep.processes import last_call
from lockstep.processes.last_call import LastCall
from lockstep.processes.string_transfer import RAW
from lockstep.processes.worker_link import WorkerLink

SIZE = 2**28  # bytes of address space for values; pages that are never touched take no memory
_MESSAGE = 2**27  # bytes of it for one message; a faulty worker must not fill the master's memory
_ALIGNMENT = 64  # one cache line
REGIONS = last_call.SIZE + _ALIGNMENT  # where the values begin

# What `numbers` holds: the program to run, or 0 for a message; how many requests were made; the number of the request
# that was answered last, negative if the answer is a message; and how many calls of the program have been made before.
PROGRAM, REQUEST, ANSWER, START = range(4)
WAKE = b"\0"


class SharedMemory:
    """One process's view. Only the master allocates; both use the same offsets."""

    def __init__(self, file: int) -> None:
        self._map = mmap.mmap(file, SIZE + _MESSAGE)
        self.last_call = LastCall(self._map)
        self.numbers = memoryview(self._map)[last_call.SIZE : REGIONS].cast("q")
        self._free = REGIONS

    def link(self, commands: int, answers: int) -> WorkerLink:
        """Return what C needs to make requests through these pipes."""
        start = addressof(c_char.from_buffer(self._map))
        numbers, reals = start + last_call.SIZE, start
        return WorkerLink(numbers=numbers, reals=reals, commands=commands, answers=answers)

    def hide_from_copies(self) -> None:
        """Take the memory away from copies of this process: one that goes on as a second worker must not answer."""
        hide_from_copies(self._map)

    def put_message(self, content: bytes) -> None:
        """Leave a message for the other process, or raise ValueError. Requests and answers take turns."""
        start, size = SIZE + 8, len(content)
        if size > _MESSAGE - 8:
            raise ValueError(f"a message of {size} bytes; at most {_MESSAGE - 8} travel to and from an isolated FMU")
        self._map[SIZE:start] = size.to_bytes(8, "little")
        self._map[start : start + size] = content

    def message(self) -> bytes:
        """Return the message of the other process, or raise ValueError."""
        start, size = SIZE + 8, int.from_bytes(self._map[SIZE : SIZE + 8], "little")
        if size > _MESSAGE - 8:
            raise ValueError(f"the size of a message is {size} bytes; at most {_MESSAGE - 8} are possible")
        return self._map[start : start + size]

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
    return anonymous_memory(SIZE + _MESSAGE)
