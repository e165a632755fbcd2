"""Send messages over a pipe: four bytes of length, then JSON, which runs no code whatever a worker sends."""

from __future__ import annotations

import json
import os
from typing import Any

_LONGEST = 2**26  # bytes; a faulty worker must not fill the master's memory


def pack(content: object) -> bytes:
    """Return the JSON of a message, with its length before it."""
    text = json.dumps(content).encode()
    return len(text).to_bytes(4, "little", signed=True) + text


def write_all(pipe: int, content: bytes) -> None:
    """Write all of it."""
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(pipe, rest) :]


def read_exactly(pipe: int, count: int) -> bytes:
    """Read so many bytes, or raise EOFError."""
    parts = bytearray()
    while len(parts) < count:
        part = os.read(pipe, min(count - len(parts), 2**20))
        if not part:
            raise EOFError
        parts += part
    return bytes(parts)


def read_message(pipe: int) -> Any:
    """Read one message, or raise EOFError when the other end is closed or sends something else."""
    length = int.from_bytes(read_exactly(pipe, 4), "little", signed=True)
    if not 0 <= length <= _LONGEST:
        raise EOFError
    try:
        return json.loads(read_exactly(pipe, length))
    except ValueError:
        raise EOFError from None
