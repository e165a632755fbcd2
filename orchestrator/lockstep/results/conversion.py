"""Write the rows of a run to its compressed file, group by group, beside the run where the system permits.

The rows are those that have gone to the stream. They are kept in memory until a group of them is written, so that the
stream is read only where the file could not be made beside the run.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue

import pyarrow as pa
import pyarrow.parquet as pq

from lockstep.errors import InputError
from lockstep.operating_system import descriptor_path, name_file, pin, unnamed_file
from lockstep.results.blocks import Piece, piece_of
from lockstep.results.read import PARQUET
from lockstep.results.row_group import RowGroup
from lockstep.results.stream import STREAM, read_batches

_GROUP_BYTES = 32_000_000  # of one row group; bounds the memory. Half as many take 1.3 x as long
_ROOM = 4  # groups that have to fit on the disk, or the file is made at the end: the stream needs the space first


class HistoryConversion:
    """The compressed file of a run that goes on. What cannot be done beside the run is done at its end."""

    def __init__(
        self, folder: Path, schema: pa.Schema, block: int, cores: Collection[int] = (), *, only_stream: bool = False
    ) -> None:
        """Start nothing yet; rows come in blocks of so many at most, and the thread may run on these cores.

        With `only_stream` there will be no file: groups hold rows for those who look at them.
        """
        self._folder, self._schema, self._cores = folder, schema, cores
        self._only_stream = only_stream
        self._rows_per_group = _rows_per_group(schema, block)
        self.group = RowGroup(schema, self._rows_per_group)  # that is filled
        self._spare: SimpleQueue[RowGroup] = SimpleQueue()
        self._groups = 1
        self._file: _ParquetFile | None = None
        self._failed = False
        self._due: SimpleQueue[RowGroup | None] = SimpleQueue()
        self._thread: threading.Thread | None = None

    def add(self, piece: Piece) -> None:
        """Copy rows to the present group, which `next_group` follows when it is full."""
        self.group.add(piece)

    @property
    def full(self) -> bool:
        """Whether there is no room for another block."""
        return self.group.count == self._rows_per_group

    def next_group(self) -> None:
        """Have the present group written, and begin another one."""
        if self._failed or self._only_stream:
            self.group.clear()
            return
        if self._thread is None:
            file = unnamed_file(self._folder)  # a killed run leaves no part of it
            if file is None:
                self._failed = True
                self.group.clear()
                return
            self._file = _ParquetFile(self._folder, file, self._schema)
            self._thread = threading.Thread(target=self._work, name="convert signals", daemon=True)
            self._thread.start()
        self._due.put(self.group)
        if self._groups == 1:
            self._groups = 2
            self.group = RowGroup(self._schema, self._rows_per_group)
        else:
            self.group = self._spare.get()

    def finish(self, rows: int) -> None:
        """Write what is left, put the file in its place, and remove the stream.

        Raises OSError if that fails, or the stream does not give back so many rows; it then stays, and nothing else.
        """
        self._end_thread()
        if self._only_stream:
            return
        if self._failed:
            convert(self._folder, rows)
            return
        file = self._file or _ParquetFile(self._folder, None, self._schema)
        with _refusing():
            try:
                file.write(self.group)
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
        """Write whole groups as they come."""
        pin(threading.get_native_id(), self._cores)
        assert self._file is not None
        while (group := self._due.get()) is not None:
            if not self._failed:
                try:
                    enough = shutil.disk_usage(self._folder).free > _ROOM * _GROUP_BYTES
                    if enough:
                        self._file.write(group)
                except Exception:
                    enough = False
                if not enough:
                    self._failed = True
                    self._file.discard()
            group.clear()
            self._spare.put(group)


def convert(folder: Path, rows: int) -> None:
    """Convert the stream of a run that has ended; raises as `HistoryConversion.finish` does."""
    with _refusing(), read_batches(folder / STREAM) as (schema, batches):
        file = _ParquetFile(folder, None, schema)
        try:
            group: RowGroup | None = None
            for batch in batches:
                if group is None:
                    group = RowGroup(schema, _rows_per_group(schema, len(batch)))
                group.add(piece_of(batch))
                if group.count == group.size:
                    file.write(group)
                    group.clear()
            if group is not None:
                file.write(group)
            file.publish(rows)
        finally:
            file.discard()


class _ParquetFile:
    """The compressed file while it is made: without a name where there are such files, else with that of a part."""

    def __init__(self, folder: Path, file: int | None, schema: pa.Schema) -> None:
        self._folder, self._descriptor, self._schema = folder, file, schema
        self._partial = folder / f".{PARQUET}.partial"
        self._path = str(self._partial) if file is None else descriptor_path(file)
        self._writer: pq.ParquetWriter | None = None

    def write(self, group: RowGroup) -> None:
        """Write a group, if it has rows."""
        writer = self._open()
        if group.count:
            writer.write_table(group.table(), row_group_size=group.count)

    def _open(self) -> pq.ParquetWriter:
        if self._writer is None:
            kinds = {field.name: field.type for field in self._schema}
            # Exponents and signs together, mantissas together: smaller and quicker than doubles one after the other.
            # A dictionary of each signal takes as long as all the rest, and is given up where values do not recur.
            self._writer = pq.ParquetWriter(
                self._path,
                self._schema,
                compression="lz4",
                use_byte_stream_split=[name for name, kind in kinds.items() if kind == pa.float64()],
                use_dictionary=[name for name, kind in kinds.items() if kind == pa.string()],
                write_statistics=["time"],
                write_page_checksum=True,
            )
        return self._writer

    def publish(self, rows: int) -> None:
        """Put the file on disk for good, in its place, if it holds so many rows; remove the stream."""
        self._open().close()
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
        self._writer = None
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


def _rows_per_group(schema: pa.Schema, block: int) -> int:
    """Return how many rows a group has: whole blocks."""
    return max(1, _GROUP_BYTES // (8 * len(schema) * block)) * block
