"""The call that is under way, kept where it survives the process that made it."""

from __future__ import annotations

import ctypes
import mmap
from pathlib import Path


class Crumb(ctypes.Structure):
    """Name and time of the call under way; an empty name between calls."""

    _fields_ = [("name", ctypes.c_char * 64), ("time", ctypes.c_double), ("timed", ctypes.c_int)]

    name: bytes
    time: float
    timed: int


def shared_crumb(path: Path) -> Crumb:
    """Map a crumb into a file: what stands in it outlives a crash."""
    with path.open("w+b") as stream:
        stream.write(bytes(ctypes.sizeof(Crumb)))
        stream.flush()
        return Crumb.from_buffer(mmap.mmap(stream.fileno(), ctypes.sizeof(Crumb)))


def read_crumb(path: Path) -> str:
    """Return the call that was under way when a process ended, as words; "" for none."""
    try:
        crumb = Crumb.from_buffer_copy(path.read_bytes())
    except (OSError, ValueError):
        return ""
    name = bytes(crumb.name).decode("utf-8", "replace")
    return f"{name} at t = {crumb.time:.9g} s" if name and crumb.timed else name
