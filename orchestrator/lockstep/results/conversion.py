"""Convert the stream of a run to its compressed file, group by group, beside the run where the system permits."""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue

import pyarrow as pa
import pyarrow.parquet as pq

from lockstep.errors import InputError
from lockstep.operating_system import descriptor_path, name_file, pin, unnamed_file
from lockstep.results.read import PARQUET
from lockstep.results.stream import STREAM, read_batches

_GROUP_BYTES = 32_000_000  # of one row group; bounds the memory of the conversion. Half as many take 1.3 x as long
_ROOM = 4  # groups that have to fit on the disk, or the file is made at the end: the stream needs the space first


class Conversion:
    """The compressed file of a run whose stream grows. What cannot be done beside the run is done at its end."""

    def __init__(self, folder: Path, schema: pa.Schema, cores: Collection[int] = ()) -> None:
        """Start nothing yet; the thread may run on these cores."""
        self._folder, self._cores = folder, cores
        self._rows_per_group = _rows_per_group(schema)
        self._file: _ParquetFile | None = None
        self._failed = False
        self._due: SimpleQueue[int | None] = SimpleQueue()
        self._asked = 0  # rows
        self._thread: threading.Thread | None = None

    def written(self, rows: int) -> None:
        """Note that so many rows of the stream are on disk."""
        if rows - self._asked < self._rows_per_group or self._failed:
            return
        if self._thread is None:
            file = unnamed_file(self._folder)  # a killed run leaves no part of it
            if file is None:
                self._failed = True
                return
            self._file = _ParquetFile(self._folder, file)
            self._thread = threading.Thread(target=self._work, name="convert signals", daemon=True)
            self._thread.start()
        self._asked = rows
        self._due.put(rows)

    def finish(self, rows: int) -> None:
        """Convert what is left, put the file in its place, and remove the stream.

        Raises OSError if that fails, or the stream does not give back so many rows; it then stays, and nothing else.
        """
        self._end_thread()
        file = self._file
        if file is None or self._failed:
            convert(self._folder, rows)
            return
        with _refusing():
            try:
                file.convert(rows, last=True)
                file.publish(rows)
            finally:
                file.discard()

    def discard(self) -> None:
        """End the thread, without the file."""
        self._end_thread()
        if self._file is not None:
            self._file.discard()

    def _end_thread(self) -> None:
        if self._thread is not None:
            self._due.put(None)
            self._thread.join()
            self._thread = None

    def _work(self) -> None:
        """Convert whole groups as they come."""
        pin(threading.get_native_id(), self._cores)
        assert self._file is not None
        while (rows := self._due.get()) is not None:
            if self._failed:
                continue
            try:
                enough = shutil.disk_usage(self._folder).free > _ROOM * _GROUP_BYTES
                if enough:
                    self._file.convert(rows)
            except Exception:
                enough = False
            if not enough:
                self._failed = True
                self._file.discard()


def convert(folder: Path, rows: int) -> None:
    """Convert the stream of a run that has ended, as `Conversion.finish` does."""
    with _refusing():
        file = _ParquetFile(folder, None)
        try:
            file.convert(rows, last=True)
            file.publish(rows)
        finally:
            file.discard()


class _ParquetFile:
    """The compressed file while it is made: without a name where there are such files, else with that of a part."""

    def __init__(self, folder: Path, file: int | None) -> None:
        self._folder, self._descriptor = folder, file
        self._partial = folder / f".{PARQUET}.partial"
        self._path = str(self._partial) if file is None else descriptor_path(file)
        self._open = ExitStack()
        self._batches: Iterator[pa.RecordBatch] | None = None
        self._waiting: list[pa.RecordBatch] = []
        self._read = self._rows = 0  # rows: read at all, and waiting
        self._rows_per_group = 0
        self._writer: pq.ParquetWriter | None = None

    def convert(self, rows: int, *, last: bool = False) -> None:
        """Read the stream up to so many rows, and write groups that are whole; with the last rows all that waits."""
        if self._batches is None:
            schema, self._batches = self._open.enter_context(read_batches(self._folder / STREAM))
            self._rows_per_group = _rows_per_group(schema)
            texts = [field.name for field in schema if field.type == pa.string()]
            # a dictionary of each signal takes as long as all the rest, and is given up where values do not recur
            self._writer = pq.ParquetWriter(
                self._path, schema, compression="zstd", write_page_checksum=True, use_dictionary=texts
            )
        while last or self._read < rows:
            batch = next(self._batches, None)
            if batch is None:
                break
            self._waiting.append(batch)
            self._read, self._rows = self._read + len(batch), self._rows + len(batch)
            if self._rows >= self._rows_per_group:
                self._write_group()
        if last and self._waiting:
            self._write_group()

    def _write_group(self) -> None:
        assert self._writer is not None
        table = pa.Table.from_batches(self._waiting)
        self._writer.write_table(table, row_group_size=len(table))
        self._waiting, self._rows = [], 0

    def publish(self, rows: int) -> None:
        """Put the file on disk for good, in its place, if it holds so many rows; remove the stream."""
        assert self._writer is not None
        self._writer.close()
        self._open.close()
        with pq.ParquetFile(self._path) as file:
            found = file.metadata.num_rows
        if found != rows:
            raise OSError(f"{STREAM} gives back {found} of {rows} rows; it is kept")
        with open(self._path, "rb") as written:  # noqa: PTH123 (of a descriptor)
            os.fsync(written.fileno())
        if self._descriptor is not None:
            name_file(self._descriptor, self._partial)
        self._partial.replace(self._folder / PARQUET)
        (self._folder / STREAM).unlink()

    def discard(self) -> None:
        """Close and remove what has not been put in its place."""
        with suppress(OSError, pa.ArrowException):
            if self._writer is not None:
                self._writer.close()
        self._writer, self._waiting = None, []
        with suppress(OSError):
            self._open.close()
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None
        self._partial.unlink(missing_ok=True)


@contextmanager
def _refusing() -> Iterator[None]:
    """Raise OSError for what is wrong with the stream, which this run wrote."""
    try:
        yield
    except (InputError, pa.ArrowException) as error:
        raise OSError(f"{error}; it is kept") from None


def _rows_per_group(schema: pa.Schema) -> int:
    return max(1, _GROUP_BYTES // (8 * len(schema)))
