"""Stream recorded rows to disk while a run goes on, and turn them into one compressed file at its end."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lockstep.results import PARQUET, STREAM, read_batches
from lockstep.selection import Signal
from lockstep.slave import DTYPES, SCALARS, Scalar

_BLOCK_BYTES = 4_000_000  # of one batch on disk, when a simulated second is larger
_GROUP_BYTES = 16_000_000  # of one row group of the final file; bounds the memory of the conversion

_NUMBERS: tuple[Scalar, ...] = ("Real", "Integer", "Boolean")  # recorded as float64, which holds them all
_COLUMNS = {"Int64": pa.int64(), "UInt64": pa.uint64(), "String": pa.string()}

Rows = tuple[NDArray[Any], ...]


class Recorder:
    """Collect rows in blocks and write them out each simulated second.

    A column is float64, unless the signal is a 64-bit integer or a text.
    """

    def __init__(self, folder: Path, signals: Sequence[Signal], rows_per_second: int) -> None:
        self._folder = folder
        by_type = {scalar: [signal for signal in signals if signal.variable.scalar == scalar] for scalar in SCALARS}
        columns = [signal for group in by_type.values() for signal in group]
        self._order = [columns.index(signal) for signal in signals]  # columns of the blocks in the order of the file
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
        self._file = pa.OSFile(str(folder / STREAM), "wb")  # unbuffered: a written batch survives a kill
        self._writer = pa.ipc.new_stream(self._file, self.schema)

    def row(self, time: float) -> Rows:
        """Return the next row to fill in, in the order of `lockstep.slave.SCALARS`."""
        count = self._count
        if count == self._size:
            self._flush()
            count = 0
        self._count = count + 1
        self._times[count] = time
        return self._rows[count]

    def _flush(self) -> None:
        count, self._count = self._count, 0  # first of all: a failed write must not be repeated by close
        columns = list(np.ascontiguousarray(self._block[:count].T))
        for block in self._others:
            columns += list(np.ascontiguousarray(block[:count].T))
        arrays = [pa.array(self._times[:count]), *(pa.array(columns[position]) for position in self._order)]
        self._writer.write_batch(pa.RecordBatch.from_arrays(arrays, schema=self.schema))

    def close(self) -> None:
        """Write the last rows, convert the stream, remove it. When that fails the stream stays readable."""
        try:
            if self._count:
                self._flush()
            self._writer.close()
        finally:
            self._file.close()
        convert(self._folder)


def convert(folder: Path) -> None:
    """Turn the stream of a run into its compressed file, a bounded number of rows at a time."""
    partial = folder / f".{PARQUET}.partial"
    try:
        with read_batches(folder / STREAM) as (schema, batches):
            rows_per_group = max(1, _GROUP_BYTES // (8 * len(schema)))
            with pq.ParquetWriter(partial, schema, compression="zstd") as writer:
                waiting: list[pa.RecordBatch] = []
                for batch in batches:
                    waiting.append(batch)
                    if sum(map(len, waiting)) >= rows_per_group:
                        writer.write_table(pa.Table.from_batches(waiting), row_group_size=rows_per_group)
                        waiting = []
                if waiting:
                    writer.write_table(pa.Table.from_batches(waiting), row_group_size=rows_per_group)
        partial.replace(folder / PARQUET)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    (folder / STREAM).unlink()


def _schema(signals: Sequence[Signal]) -> pa.Schema:
    fields = [pa.field("time", pa.float64(), nullable=False, metadata={"unit": "s", "description": "simulated time"})]
    for signal in signals:
        unit = signal.variable.unit.name if signal.variable.unit else ""
        metadata = {"unit": unit, "description": signal.variable.description, "type": signal.variable.type}
        kind = _COLUMNS.get(signal.variable.scalar or "", pa.float64())
        fields.append(pa.field(signal.name, kind, nullable=False, metadata=metadata))
    return pa.schema(fields)
