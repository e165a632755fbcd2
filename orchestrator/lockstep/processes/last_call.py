"""The record of the call under way in a child process, in memory that outlives a crash of the process.

A block of 8-byte fields (the time and step size of the call [s], the number of the call or 0 between calls, the size of
a text, how long the process has worked [s], and the number of the FMU that logged the text), then the text: the call's
name, or the last message logged.
"""

from __future__ import annotations

import math
import mmap
from pathlib import Path

TIME, STEP, CALL, TEXT_SIZE, BUSY, SPEAKER = range(6)
_TEXT, SIZE = 64, 1024  # bytes: where the text begins, and of all


class LastCall:
    """One process's view of the record, at the start of a memory map."""

    def __init__(self, memory: mmap.mmap | bytearray) -> None:
        self._memory = memory
        header = memoryview(memory)[:_TEXT]
        self.reals = header.cast("d")
        self.integers = header.cast("q")

    @property
    def text(self) -> str:
        """The text that was left, or nothing."""
        length = min(max(0, self.integers[TEXT_SIZE]), SIZE - _TEXT)
        return self._memory[_TEXT : _TEXT + length].decode("utf-8", "replace")

    def leave_text(self, text: str) -> None:
        """Leave a text, as much of it as fits."""
        content = text.encode()[: SIZE - _TEXT]
        self._memory[_TEXT : _TEXT + len(content)] = content
        self.integers[TEXT_SIZE] = len(content)

    def enter(self, name: str, time: float | None) -> None:
        """Note the call that is about to be made, and its simulated time [s] if it has one."""
        self.reals[TIME] = math.nan if time is None else time
        self.leave_text(name)
        self.integers[CALL] = 1

    def leave(self) -> None:
        """Note that the call returned."""
        self.integers[CALL] = 0

    def __str__(self) -> str:
        """Describe the call under way: `fmi2DoStep at t = 0.1 s`; nothing between calls."""
        if not self.integers[CALL]:
            return ""
        time = self.reals[TIME]
        return self.text if math.isnan(time) else f"{self.text} at t = {time:.9g} s"


def last_call_in(path: Path) -> LastCall:
    """Return a new record in a file."""
    with path.open("w+b") as stream:
        stream.truncate(SIZE)
        return LastCall(mmap.mmap(stream.fileno(), SIZE))


def read_last_call(path: Path) -> str:
    """Describe the call that was under way when a process ended; nothing if there was none."""
    try:
        content = bytearray(path.read_bytes())
    except OSError:
        return ""
    return str(LastCall(content)) if len(content) == SIZE else ""
