"""The journals of a campaign: a line for each finished run, on disk before it counts, one file a worker."""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from lockstep.errors import RunError

FOLDER = "journal"
_CHECK = "{:08x}"


class Journals:
    """Append lines to the journals in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder / FOLDER
        self._open: dict[str, IO[bytes]] = {}

    def add(self, worker: str, entry: Mapping[str, Any]) -> None:
        """Write a line and wait until it is on disk.

        Raises
        ------
        RunError
            If it cannot be written; the journal is then as before.
        """
        line = _line(entry)
        end: int | None = None
        try:
            stream = self._stream(worker)
            end = os.fstat(stream.fileno()).st_size
            _write_all(stream, line)
            os.fsync(stream.fileno())
        except OSError as error:
            self._cut(worker, end)
            reason = os.strerror(error.errno) if error.errno else str(error)
            raise RunError(
                f"{self._folder}: cannot be written ({reason}); free space there and repeat the command"
            ) from None

    def close(self) -> None:
        """Close the files."""
        for stream in self._open.values():
            stream.close()
        self._open.clear()

    def _stream(self, worker: str) -> IO[bytes]:
        name = re.sub(r"[^\w.-]+", "-", worker).strip("-") or "worker"
        if name not in self._open:
            self._folder.mkdir(parents=True, exist_ok=True)
            path = self._folder / f"{name}.jsonl"
            stream = path.open("ab", buffering=0)
            if stream.tell() and not _ends_line(path):  # a line that a kill cut off
                stream.write(b"\n")
            self._open[name] = stream
        return self._open[name]

    def _cut(self, worker: str, end: int | None) -> None:
        name = re.sub(r"[^\w.-]+", "-", worker).strip("-") or "worker"
        stream = self._open.pop(name, None)
        if stream is not None:
            if end is not None:
                os.ftruncate(stream.fileno(), end)
            stream.close()


def entries(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the entries of all journals in a folder; what was not completely written is left out."""
    for path in sorted((folder / FOLDER).glob("*.jsonl")):
        with path.open("rb") as stream:
            for line in stream:
                check, _, text = line.rstrip(b"\n").partition(b" ")
                if check.decode("ascii", "replace") == _CHECK.format(zlib.crc32(text)):
                    yield json.loads(text)


def _write_all(stream: IO[bytes], content: bytes) -> None:
    rest = memoryview(content)
    while rest:  # on a disk that is nearly full, a write takes a part
        rest = rest[stream.write(rest) :]


def _line(entry: Mapping[str, Any]) -> bytes:
    text = json.dumps(entry, separators=(",", ":")).encode()
    return _CHECK.format(zlib.crc32(text)).encode() + b" " + text + b"\n"


def _ends_line(path: Path) -> bool:
    with path.open("rb") as stream:
        stream.seek(-1, os.SEEK_END)
        return stream.read(1) == b"\n"
