"""Write the batches of a run to its stream in a thread, so that the loop goes on meanwhile."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Collection
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pyarrow as pa

from lockstep.operating_system import pin
from lockstep.results.blocks import Piece

_END = b"\xff\xff\xff\xff" + bytes(4)  # of a stream: a message of no length

Make = Callable[[], Piece]
Look = Callable[[Piece], Any]


class StreamWriter:
    """The stream of a run. One batch at most is on its way to the disk; a failed one ends the stream before it."""

    def __init__(self, path: Path, schema: pa.Schema, cores: Collection[int]) -> None:
        """Make the file; the thread, which is started when it is needed, may run on these cores."""
        self._path, self._cores = path, cores
        self._file = pa.OSFile(str(path), "wb")  # unbuffered: survives a kill
        self._schema = schema
        self.rows = 0  # that are on disk
        self._failure: BaseException | None = None
        self._due: SimpleQueue[tuple[Make, Look] | None] = SimpleQueue()
        self._done: SimpleQueue[tuple[Any, BaseException | None]] = SimpleQueue()
        self.busy = False  # whether a batch was begun that was not waited for
        self._thread: threading.Thread | None = None

    def start_piece(self, make: Make, look: Look) -> None:
        """Make a batch, write it and look at it, in the thread; `wait` comes before the next one."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="write signals", daemon=True)
            self._thread.start()
        self.busy = True
        self._due.put((make, look))

    def wait(self) -> Any:
        """Wait for the batch that was begun, and return what the look at it returned; raise what was raised for it."""
        found, failure = self._done.get()  # a second Ctrl-C may end it here: the batch is still waited for
        self.busy = False
        if failure is not None:
            raise failure
        return found

    def write(self, piece: Piece) -> None:
        """Write a batch in the calling thread."""
        end = self._file.tell()
        try:
            self._begin()
            self._append(piece)
        except BaseException as error:
            self._failure = error
            self._file.close()
            os.truncate(self._path, end)  # no part of a batch stays: readers would take it for a whole one
            raise
        self.rows += len(piece.batch)

    def _begin(self) -> None:
        """Write what a stream begins with, if it is empty."""
        if not self._file.tell():
            self._file.write(self._schema.serialize())

    def _append(self, piece: Piece) -> None:
        self._file.write(piece.batch.serialize() if piece.message is None else piece.message)

    def moved(self, path: Path) -> None:
        """Note that the file has another name."""
        self._path = path

    @property
    def whole(self) -> bool:
        """Whether no write has failed."""
        return self._failure is None

    def close(self) -> None:
        """End the thread and the stream."""
        if self._thread is not None:
            self._due.put(None)
            self._thread.join()
            self._thread = None
        try:
            if self.whole:
                self._begin()
                self._file.write(_END)
        finally:
            self._file.close()

    def _work(self) -> None:
        """Write what is due until the end."""
        pin(threading.get_native_id(), self._cores)  # the thread that steps FMUs may be pinned to one
        while (job := self._due.get()) is not None:
            make, look = job
            found, failure = None, None
            try:
                piece = make()
                self.write(piece)
                with np.errstate(over="ignore"):  # as in the loop
                    found = look(piece)
            except BaseException as error:  # raised where the loop waits
                failure = error
            self._done.put((found, failure))
