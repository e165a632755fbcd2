"""Stream recorded rows to disk while a run goes on, and turn them into one compressed file at its end."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lockstep.results import PARQUET, STREAM, read_batches
from lockstep.selection import Signal
from lockstep.slave import SCALARS

_BLOCK_BYTES = 4_000_000  # of one batch on disk, when a simulated second is larger
_GROUP_BYTES = 16_000_000  # of one row group of the final file; bounds the memory of the conversion

Rows = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


class Recorder:
    """Collect rows in a block and write it out each simulated second. Every column is float64."""

    def __init__(self, folder: Path, signals: Sequence[Signal], rows_per_second: int) -> None:
        self._folder = folder
        by_type = [[signal for signal in signals if signal.variable.type == scalar] for scalar in SCALARS]
        columns = [signal for group in by_type for signal in group]
        self._order = [columns.index(signal) for signal in signals]  # block columns in the order of the file
        width = len(columns)
        self._size = max(1, min(rows_per_second, _BLOCK_BYTES // (8 * (width + 1))))
        self._times = np.zeros(self._size)
        self._block = np.zeros((self._size, width))
        ends = np.cumsum([len(group) for group in by_type])
        self._rows: list[Rows] = [(row[: ends[0]], row[ends[0] : ends[1]], row[ends[1] :]) for row in self._block]
        self._count = 0
        self.schema = _schema(signals)
        self._file = pa.OSFile(str(folder / STREAM), "wb")  # unbuffered: a written batch survives a kill
        self._writer = pa.ipc.new_stream(self._file, self.schema)

    def row(self, time: float) -> Rows:
        """Return the next row to fill in: its Reals, Integers and Booleans."""
        count = self._count
        if count == self._size:
            self._flush()
            count = 0
        self._count = count + 1
        self._times[count] = time
        return self._rows[count]

    def _flush(self) -> None:
        count, self._count = self._count, 0  # first of all: a failed write must not be repeated by close
        columns = np.ascontiguousarray(self._block[:count].T)
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
        fields.append(pa.field(signal.name, pa.float64(), nullable=False, metadata=metadata))
    return pa.schema(fields)
