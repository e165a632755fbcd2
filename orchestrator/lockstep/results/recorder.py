"""Stream recorded rows to disk during a run, and convert them to one compressed file at its end."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lockstep.errors import InputError
from lockstep.fmi.slave import DTYPES, SCALARS, Scalar
from lockstep.results.monitor import Observed
from lockstep.results.read import PARQUET, open_batches
from lockstep.results.signal_patterns import Signal
from lockstep.results.stream import STREAM, read_batches

_BLOCK_BYTES = 4_000_000  # of one batch on disk, when a simulated second is larger
_GROUP_BYTES = 16_000_000  # of one row group of the final file; bounds the memory of the conversion

_NUMBERS: tuple[Scalar, ...] = ("Real", "Integer", "Boolean")  # recorded as float64, which holds them all
_CONTINUED = f".{STREAM}.continued"  # the file of a resumed run, until it holds the rows saved before
_COLUMNS = {"Int64": pa.int64(), "UInt64": pa.uint64(), "String": pa.string()}

Rows = tuple[NDArray[Any], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedRows:
    """Rows that a run had recorded at some time: in its file, and not yet written, as an Arrow stream."""

    written: int
    waiting: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptRows:
    """All rows that a run in memory had recorded at some time: whole blocks, and the rows of the block begun last."""

    blocks: tuple[pa.RecordBatch, ...]
    last: pa.RecordBatch


class Recorder:
    """Collect rows in blocks and write them out each simulated second; without a folder the blocks stay in memory.

    A column is float64, unless the signal is a 64-bit integer or a text.
    """

    def __init__(
        self,
        folder: Path | None,
        signals: Sequence[Signal],
        rows_per_second: int,
        saved: SavedRows | None = None,
        observed: Observed | None = None,
    ) -> None:
        """Start a file, or continue that of an earlier part of the same run after the rows saved from it."""
        self._folder = folder
        self._observed = observed
        by_type: dict[Scalar, list[int]] = {scalar: [] for scalar in SCALARS}  # numbers of the signals
        for number, signal in enumerate(signals):
            if signal.variable.scalar is not None:
                by_type[signal.variable.scalar].append(number)
        columns = [number for group in by_type.values() for number in group]
        positions = {number: position for position, number in enumerate(columns)}
        self._order = [positions[k] for k in range(len(columns))]  # columns of the blocks in the order of the file
        self._size = max(1, min(rows_per_second, _BLOCK_BYTES // (8 * (len(columns) + 1))))
        self._times = np.zeros(self._size)
        ends = np.cumsum([0, *(len(by_type[scalar]) for scalar in _NUMBERS)])
        self._block = np.zeros((self._size, ends[-1]))
        self._others: list[NDArray[Any]] = [
            np.zeros((self._size, len(by_type[scalar])), DTYPES[scalar]) for scalar in SCALARS if scalar not in _NUMBERS
        ]
        parts = [self._block[:, start:end] for start, end in pairwise(ends)] + self._others  # in the order of SCALARS
        self._rows: list[Rows] = [tuple(part[k] for part in parts) for k in range(self._size)]
        self._count = 0
        self.schema = _schema(signals)
        self._columns = [part[:, k] for part in parts for k in range(part.shape[1])]
        self._written = 0  # rows
        self._whole = True  # the stream: no write has failed
        self._blocks: list[pa.RecordBatch] = []  # of a run in memory
        if folder is None:
            return
        path = folder / (STREAM if saved is None else _CONTINUED)
        self._file = pa.OSFile(str(path), "wb")  # unbuffered: survives a kill
        self._writer = pa.ipc.new_stream(self._file, self.schema)
        if saved is not None:
            self._continue(saved)

    def saved(self) -> SavedRows:
        """Return what has been recorded so far, with the file on disk for good."""
        assert self._folder is not None
        waiting = pa.BufferOutputStream()
        with pa.ipc.new_stream(waiting, self.schema) as stream:
            stream.write_batch(self._batch(self._count))
        _write_through(self._folder / STREAM)
        return SavedRows(written=self._written, waiting=waiting.getvalue().to_pybytes())

    def kept(self) -> KeptRows:
        """Return all rows so far of a run in memory. They do not change any more."""
        return KeptRows(blocks=tuple(self._blocks), last=self._batch(self._count))

    def put_back(self, kept: KeptRows) -> None:
        """Go back to the rows that a run in memory had at some time, in this branch of it or another."""
        self._blocks = list(kept.blocks)
        self._written = sum(map(len, kept.blocks))
        self._fill(kept.last)

    def _continue(self, saved: SavedRows) -> None:
        """Copy rows of the earlier file in the batches that they came in, and put the new file in its place."""
        assert self._folder is not None
        continued = self._folder / _CONTINUED
        try:
            waiting = _waiting_batch(saved, self.schema)
            for batch in first_rows(self._folder, saved.written, self._size):
                self._writer.write_batch(batch)
                self._written += len(batch)
                if self._observed is not None:
                    self._observed.block(batch, past=True)
            if self._written != saved.written:
                raise OSError(f"{self._written} of {saved.written} rows of the earlier part could be read")
            _write_through(continued)
        except BaseException:
            self._file.close()
            continued.unlink(missing_ok=True)
            raise
        continued.replace(self._folder / STREAM)
        (self._folder / PARQUET).unlink(missing_ok=True)
        self._fill(waiting)

    def _fill(self, waiting: pa.RecordBatch) -> None:
        """Begin the block with rows that had been recorded before."""
        self._count = len(waiting)
        self._times[: self._count] = waiting.column(0).to_numpy()
        for k, position in enumerate(self._order, 1):
            self._columns[position][: self._count] = waiting.column(k).to_numpy(zero_copy_only=False)

    def row(self, time: float) -> Rows:
        """Return the next row to fill in, in the order of `lockstep.fmi.slave.SCALARS`."""
        count = self._count
        if count == self._size:
            self._flush()
            count = 0
        self._count = count + 1
        self._times[count] = time
        return self._rows[count]

    def _flush(self) -> None:
        count, self._count = self._count, 0  # first of all: a failed write must not be repeated by close
        batch = self._batch(count)
        if self._folder is None:
            self._blocks.append(batch)
        else:
            self._write(batch)
        self._written += count
        if self._observed is not None:
            self._observed.block(batch)

    def _write(self, batch: pa.RecordBatch) -> None:
        """Write a batch to the stream."""
        assert self._folder is not None
        end = self._file.tell()
        try:
            self._writer.write_batch(batch)
        except BaseException:
            self._whole = False
            self._file.close()
            os.truncate(self._folder / STREAM, end)  # no part of a batch stays: readers would take it for a whole one
            raise

    def _batch(self, count: int) -> pa.RecordBatch:
        """Return the first rows of the block, copied: the block is filled again."""
        columns = list(np.array(self._block[:count].T, order="C"))
        for block in self._others:
            columns += list(np.array(block[:count].T, order="C"))
        arrays = [_array(self._times[:count].copy()), *(_array(columns[position]) for position in self._order)]
        return pa.RecordBatch.from_arrays(arrays, schema=self.schema)

    def close(self) -> None:
        """Write the last rows, convert the stream, remove it. When that fails the stream stays readable.

        Raises OSError, also for a stream that does not give back every row that was written.
        """
        if self._folder is None:
            if self._count and self._observed is not None:
                self._flush()  # the rows that nothing has looked at
            return
        try:
            if self._whole:
                if self._count:
                    self._flush()
                self._writer.close()
        finally:
            self._file.close()
        convert(self._folder, self._written)


def _array(values: NDArray[Any]) -> pa.Array:
    """Return values as Arrow's; `pa.array` imports pandas at its first call, in the middle of the run."""
    if values.dtype == np.object_:
        return pa.array(values.tolist(), pa.string())
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [None, pa.py_buffer(values)])


def waiting_rows(saved: SavedRows, signals: Sequence[Signal]) -> int:
    """Count the rows that were not yet written; raise ValueError if they cannot be read, or are of other signals."""
    return len(_waiting_batch(saved, _schema(signals)))


def _waiting_batch(saved: SavedRows, schema: pa.Schema) -> pa.RecordBatch:
    try:
        (batch,) = pa.ipc.open_stream(saved.waiting)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"its waiting rows cannot be read: {error}") from None
    if batch.schema != schema:
        raise ValueError("its waiting rows are of other signals than the run")
    return batch


def first_rows(folder: Path, count: int, size: int) -> Iterator[pa.RecordBatch]:
    """Yield the first rows of a run, ended or not, in batches of one size."""
    if not count:
        return
    left, waiting, rows = count, [], 0
    with open_batches(folder) as (_, batches):
        for batch in batches:
            start = 0
            while left and start < len(batch):
                part = batch.slice(start, min(len(batch) - start, size - rows, left))
                start, rows, left = start + len(part), rows + len(part), left - len(part)
                waiting.append(part)
                if rows == size or not left:
                    yield pa.Table.from_batches(waiting).combine_chunks().to_batches()[0]
                    waiting, rows = [], 0
            if not left:
                return


def convert(folder: Path, rows: int) -> None:
    """Convert the stream of a run to its compressed file, a bounded number of rows at a time.

    The stream is removed once that file is on disk with so many rows; otherwise OSError is raised, and it stays.
    """
    partial = folder / f".{PARQUET}.partial"
    try:
        _write_parquet(folder / STREAM, partial)
        with pq.ParquetFile(partial) as file:
            found = file.metadata.num_rows
        if found != rows:
            raise OSError(f"{STREAM} gives back {found} of {rows} rows; it is kept")
        _write_through(partial)
        partial.replace(folder / PARQUET)
    except BaseException as error:
        partial.unlink(missing_ok=True)
        if isinstance(error, InputError | pa.ArrowException):  # of the stream, which this run wrote
            raise OSError(f"{error}; it is kept") from None
        raise
    (folder / STREAM).unlink()


def _write_parquet(stream: Path, path: Path) -> None:
    with read_batches(stream) as (schema, batches):
        rows_per_group = max(1, _GROUP_BYTES // (8 * len(schema)))
        with pq.ParquetWriter(path, schema, compression="zstd", write_page_checksum=True) as writer:
            waiting: list[pa.RecordBatch] = []
            for batch in batches:
                waiting.append(batch)
                if sum(map(len, waiting)) >= rows_per_group:
                    writer.write_table(pa.Table.from_batches(waiting), row_group_size=rows_per_group)
                    waiting = []
            if waiting:
                writer.write_table(pa.Table.from_batches(waiting), row_group_size=rows_per_group)


def _write_through(path: Path) -> None:
    """Wait until a file is on disk for good."""
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _schema(signals: Sequence[Signal]) -> pa.Schema:
    fields = [pa.field("time", pa.float64(), nullable=False, metadata={"unit": "s", "description": "simulated time"})]
    for signal in signals:
        unit = signal.variable.unit.name if signal.variable.unit else ""
        metadata = {"unit": unit, "description": signal.variable.description, "type": signal.variable.type}
        kind = _COLUMNS.get(signal.variable.scalar or "", pa.float64())
        fields.append(pa.field(signal.name, kind, nullable=False, metadata=metadata))
    return pa.schema(fields)
