"""The call that is under way, kept where it survives the process that made it."""

from __future__ import annotations

import ctypes
import mmap
from pathlib import Path


class LastCall(ctypes.Structure):
    """Name and time of the call under way; an empty name between calls."""

    _fields_ = [("name", ctypes.c_char * 64), ("time", ctypes.c_double), ("timed", ctypes.c_int)]

    name: bytes
    time: float
    timed: int


def map_last_call(path: Path) -> LastCall:
    """Map a last_call into a file: what stands in it outlives a crash."""
    with path.open("w+b") as stream:
        stream.write(bytes(ctypes.sizeof(LastCall)))
        stream.flush()
        return LastCall.from_buffer(mmap.mmap(stream.fileno(), ctypes.sizeof(LastCall)))


def read_last_call(path: Path) -> str:
    """Return the call that was under way when a process ended, as words; "" for none."""
    try:
        last_call = LastCall.from_buffer_copy(path.read_bytes())
    except (OSError, ValueError):
        return ""
    name = bytes(last_call.name).decode("utf-8", "replace")
    return f"{name} at t = {last_call.time:.9g} s" if name and last_call.timed else name
