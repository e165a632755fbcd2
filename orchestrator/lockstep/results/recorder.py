"""Record the rows of a run: capture them in blocks, and write each to the stream while the next one is filled."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from lockstep.processes.cpu_affinity import core_assignment
from lockstep.results.blocks import Block, Columns, Copied, Piece, Rows, piece_of, schema_of
from lockstep.results.conversion import HistoryConversion
from lockstep.results.monitor import Found, Observed
from lockstep.results.read import PARQUET, open_batches
from lockstep.results.signal_patterns import Signal
from lockstep.results.stream import STREAM
from lockstep.results.stream_writer import StreamWriter

_BLOCK_BYTES = 4_000_000  # of one batch on disk, when there are more signals
_SCRATCH_ROWS = 500  # in a block of a scratch run, at least: nobody reads it before its end
_LOOK_BLOCKS = 8  # that a monitor looks at together: each look takes a millisecond
_CONTINUED = f".{STREAM}.continued"  # the file of a resumed run, until it holds the rows saved before


@dataclass(frozen=True, slots=True, kw_only=True)
class SavedRows:
    """Rows that a run had recorded at some time: in its file, and not yet written, as an Arrow stream."""

    written: int
    waiting: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptRows:
    """All rows that a run in memory had recorded at some time: whole blocks, and the rows of the block begun last."""

    blocks: tuple[pa.RecordBatch, ...]
    last: Copied


class Recorder:
    """Collect rows in blocks of half a simulated second. One is filled while the one before is written.

    Without a folder the blocks stay in memory. A column is float64, unless the signal is a 64-bit integer or a text.
    A write that fails ends the run at the next block, or at the end.
    """

    def __init__(
        self,
        folder: Path | None,
        signals: Sequence[Signal],
        rows_per_block: int,
        saved: SavedRows | None = None,
        observed: Observed | None = None,
        *,
        scratch: bool = False,
    ) -> None:
        """Start a file, or continue that of an earlier part of the same run after the rows saved from it.

        A scratch run is read once by the program that simulates it, and removed: its blocks are longer, are written
        in the thread of the loop, and stay a stream.
        """
        self._folder = folder
        self._observed = observed
        self.scratch = scratch
        wanted = max(rows_per_block, _SCRATCH_ROWS) if scratch else rows_per_block
        self._columns = Columns(signals, max(1, min(wanted, _BLOCK_BYTES // (8 * (len(signals) + 1)))))
        self.block: Block = self._columns.block()  # that is filled
        self.count = 0  # rows in it
        self._spare = self.block if scratch else self._columns.block()
        self._size, self._rows, self._times = self.block.size, self.block.rows, self.block.times
        self._seen = 0  # rows of the present group that the monitor has looked at
        self._blocks: list[pa.RecordBatch] = []  # of a run in memory
        self._kept = 0  # rows in them
        if folder is None:
            return
        cores = core_assignment().cores
        path = folder / (STREAM if saved is None else _CONTINUED)
        self._stream = StreamWriter(path, self._columns.schema, cores)
        self._conversion = HistoryConversion(
            folder, self._columns.schema, self._columns.size, cores, only_stream=scratch
        )
        if saved is not None:
            self._continue(saved)

    @property
    def schema(self) -> pa.Schema:
        """Names, types and units of the columns."""
        return self._columns.schema

    def saved(self) -> SavedRows:
        """Return what has been recorded so far, with the file on disk for good."""
        assert self._folder is not None
        self._complete_write()
        self._look_at_rest()
        _write_through(self._folder / STREAM)
        return SavedRows(written=self._stream.rows, waiting=self._streamed(self.count))

    def nothing(self) -> SavedRows | KeptRows:
        """Return what a run has recorded that begins at the present time, to go back to."""
        if self._folder is None:
            return KeptRows(blocks=(), last=self._columns.rows(self.block, 0))
        return SavedRows(written=0, waiting=self._streamed(0))

    def _streamed(self, count: int) -> bytes:
        """Return the first rows of the block as an Arrow stream."""
        waiting = pa.BufferOutputStream()
        with pa.ipc.new_stream(waiting, self.schema) as stream:
            stream.write_batch(self._columns.piece(self.block, count).batch)
        found: bytes = waiting.getvalue().to_pybytes()
        return found

    def abandon(self) -> None:
        """Close the file as it is, before another recorder continues it."""
        if self._folder is not None:
            self._complete_write()
            self._look_at_rest()
            self._stream.close()
            self._conversion.discard()

    def kept(self) -> KeptRows:
        """Return all rows so far of a run in memory. They do not change any more."""
        return KeptRows(blocks=tuple(self._blocks), last=self._columns.rows(self.block, self.count))

    def in_memory(self) -> list[pa.RecordBatch]:
        """Return all rows so far of a run in memory as Arrow's."""
        return [*self._blocks, self._columns.copy(self.block, self.count)]

    def put_back(self, kept: KeptRows) -> None:
        """Go back to the rows that a run in memory had at some time, in this branch of it or another."""
        self._blocks = list(kept.blocks)
        self._kept = sum(map(len, kept.blocks))
        self._columns.put_rows(self.block, kept.last)
        self.count = len(kept.last[0])

    def _fill(self, rows: pa.RecordBatch) -> None:
        """Begin the block with rows that had been recorded before."""
        self._columns.fill(self.block, rows)
        self.count = len(rows)

    def _continue(self, saved: SavedRows) -> None:
        """Copy rows of the earlier file in the batches that they came in, and put the new file in its place."""
        assert self._folder is not None
        continued = self._folder / _CONTINUED
        try:
            waiting = _waiting_batch(saved, self.schema)
            for batch in first_rows(self._folder, saved.written, self._size):
                self._write(batch, past=True)
            if self._stream.rows != saved.written:
                raise OSError(f"{self._stream.rows} of {saved.written} rows of the earlier part could be read")
            while len(waiting) >= self._size:  # of a version whose blocks were longer
                self._write(waiting.slice(0, self._size), past=False)
                waiting = waiting.slice(self._size)
            _write_through(continued)
        except BaseException:
            self._stream.close()
            self._conversion.discard()
            continued.unlink(missing_ok=True)
            raise
        continued.replace(self._folder / STREAM)
        self._stream.moved(self._folder / STREAM)
        (self._folder / PARQUET).unlink(missing_ok=True)
        self._fill(waiting)

    def _write(self, batch: pa.RecordBatch, *, past: bool) -> None:
        """Write rows of an earlier part of the run; what those that were on disk show is among the events."""
        piece = piece_of(batch)
        self._stream.write(piece)
        found = [*self._written(piece), *self._unseen()]
        if self._observed is not None and not past:
            self._observed.note(found)

    def row(self, time: float) -> Rows:
        """Return the next row to fill in, in the order of `lockstep.fmi.slave.SCALARS`."""
        count = self.count
        if count == self._size:
            self.next_block()
            count = 0
        self.count = count + 1
        self._times[count] = time
        return self._rows[count]

    def next_block(self) -> None:
        """Have the present block written, and begin with the next one; raise what the write before that raised."""
        count, self.count = self.count, 0  # first of all: after a failure no rows follow
        if self._folder is None:
            self._keep(self._columns.copy(self.block, count))
            return
        self._complete_write()
        if self.scratch:
            self._write_here(count)
            return
        self._stream.start_piece(partial(self._columns.piece, self.block, count), self._written)
        self.block, self._spare = self._spare, self.block
        self._rows, self._times = self.block.rows, self.block.times

    def _write_here(self, count: int) -> None:
        """Write the first rows of the block in this thread, and note what they show.

        What Arrow allocates in a thread of each run stays with the process when the thread ends.
        """
        piece = self._columns.piece(self.block, count)
        self._stream.write(piece)
        with np.errstate(over="ignore"):  # as in the loop
            found = self._written(piece)
        if self._observed is not None:
            self._observed.note(found)

    def _keep(self, batch: pa.RecordBatch) -> None:
        """Keep a block in memory."""
        self._blocks.append(batch)
        self._kept += len(batch)
        if self._observed is not None:
            self._observed.block(batch)

    def _written(self, piece: Piece) -> list[Found]:
        """Keep rows that are in the stream for the compressed file; return what a look at the last ones shows."""
        conversion = self._conversion
        conversion.add(piece)
        found = []
        if conversion.full or conversion.group.count - self._seen >= _LOOK_BLOCKS * self._size:
            found = self._unseen()
        if conversion.full:
            conversion.next_group()
            self._seen = 0
        return found

    def _unseen(self) -> list[Found]:
        """Return what the rows show that were not looked at."""
        group = self._conversion.group
        begin, self._seen = self._seen, group.count
        if self._observed is None or begin == group.count:
            return []
        return self._observed.look(*group.rows(begin, group.count))

    def _look_at_rest(self) -> None:
        """Note what the rows in the stream show that were not looked at."""
        found = self._unseen()
        if self._observed is not None:
            self._observed.note(found)

    def _complete_write(self) -> None:
        """Wait for the block that is being written, and note what it shows."""
        if self._stream.busy:
            found = self._stream.wait()
            if self._observed is not None:
                self._observed.note(found)

    @property
    def written(self) -> int:
        """Rows in whole blocks: on disk, or of a run in memory."""
        return self._kept if self._folder is None else self._stream.rows

    def size_on_disk(self) -> int:
        """Return how many bytes the signals take on disk."""
        if self._folder is None:
            return 0
        sizes = [path.stat().st_size for name in (PARQUET, STREAM) if (path := self._folder / name).exists()]
        return sizes[0] if sizes else 0

    def close(self) -> None:
        """Write the last rows; convert the stream and remove it, but for a scratch run's. It stays if that fails.

        Raises OSError, also for a stream that does not give back every row that was written.
        """
        if self._folder is None:
            if self.count:
                self.next_block()
            return
        try:
            try:
                self._complete_write()
                if self._stream.whole and self.count:
                    self.next_block()
                    self._complete_write()
            finally:
                self._stream.close()
                self._look_at_rest()
        except BaseException:
            self._conversion.discard()
            raise
        self._conversion.finish(self._stream.rows)


def waiting_rows(saved: SavedRows, signals: Sequence[Signal]) -> int:
    """Count the rows that were not yet written; raise ValueError if they cannot be read, or are of other signals."""
    return len(_waiting_batch(saved, schema_of(signals)))


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


def _write_through(path: Path) -> None:
    """Wait until a file is on disk for good."""
    with path.open("rb") as file:
        os.fsync(file.fileno())
