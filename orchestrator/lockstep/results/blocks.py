"""Recorded rows in memory: row by row as a tick captures them, and column by column as they are written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lockstep.fmi.slave import DTYPES, SCALARS, Scalar
from lockstep.results.column_values import column_values
from lockstep.results.signal_patterns import Signal

_NUMBERS: tuple[Scalar, ...] = ("Real", "Integer", "Boolean")  # recorded as float64, which holds them all
_OTHERS = tuple(scalar for scalar in SCALARS if scalar not in _NUMBERS)
_COLUMNS = {"Int64": pa.int64(), "UInt64": pa.uint64(), "String": pa.string()}

Rows = tuple[NDArray[Any], ...]
Copied = tuple[NDArray[Any], ...]  # rows of a block: times, numbers and the others


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Rows in the order in which they were captured."""

    times: NDArray[np.float64]  # (size,) [s]
    numbers: NDArray[np.float64]  # (size, n): the Reals, Integers and Booleans, in this order
    others: tuple[NDArray[Any], ...]  # (size, k) of each type that float64 does not hold, in the order of SCALARS
    parts: Rows  # (size, k) views of each type, in the order of SCALARS
    rows: list[Rows]  # the same of each row

    @property
    def size(self) -> int:
        """How many rows there is room for."""
        return len(self.times)


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """Rows on their way to the disk, column by column. What `Columns` returns is valid until its next one."""

    batch: pa.RecordBatch
    numbers: NDArray[np.float64]  # (1 + n, rows): the 8 bytes of each value, in the order of the file; none of texts
    message: memoryview | None = None  # the batch as a stream has it, if that is known


class Columns:
    """The columns of the signals in the order of the file, for so many rows; their memory is used again and again.

    It is that of a message of the stream, which is the same for every full block but for its values.
    """

    def __init__(self, signals: Sequence[Signal], size: int) -> None:
        self.size = size
        self.schema = schema_of(signals)
        by_type: dict[Scalar, list[int]] = {scalar: [] for scalar in SCALARS}  # numbers of the signals
        for number, signal in enumerate(signals):
            if signal.variable.scalar is not None:
                by_type[signal.variable.scalar].append(number)
        self._ends = np.cumsum([0, *(len(by_type[scalar]) for scalar in _NUMBERS)]).tolist()
        self._widths = {scalar: len(by_type[scalar]) for scalar in _OTHERS}
        places = {number: place for place, number in enumerate(n for group in by_type.values() for n in group)}
        self._order = [places[number] for number in range(len(places))]  # of the file, in a block
        self._texts = [k for k, field in enumerate(self.schema) if field.type == pa.string()]
        self._message: memoryview | None = None
        self._batch: pa.RecordBatch | None = None
        if self._texts:
            self._body = np.zeros((len(self.schema), size))
        else:
            self._message, self._body, self._batch = _message(self.schema, size)
        self._runs = self._runs_of_columns()

    def _places(self) -> list[tuple[int, int]]:
        """Return in which part of a block each column of the file is, after the time, and where there."""
        widths = [self._ends[-1], *(self._widths[scalar] for scalar in _OTHERS)]
        places = [(part, column) for part, width in enumerate(widths) for column in range(width)]
        return [places[place] for place in self._order]

    def _runs_of_columns(self) -> list[tuple[NDArray[Any], int, slice]]:
        """Return rows of the body, and the neighbouring columns of a part of a block that are copied there."""
        kinds = [np.dtype(np.float64), *(np.dtype(DTYPES[scalar]) for scalar in _OTHERS)]
        runs: list[tuple[int, int, int, int]] = []  # first row, part, first column, how many
        for row, (part, column) in enumerate(self._places(), 1):
            first, *last, count = runs[-1] if runs else (0, 0, 0, 0)
            if runs and last == [part, column - count] and row == first + count:
                runs[-1] = (first, part, column - count, count + 1)
            elif kinds[part] != np.object_:
                runs.append((row, part, column, 1))
        return [
            (self._body[row : row + count].view(kinds[part]), part, slice(column, column + count))
            for row, part, column, count in runs
        ]

    def block(self) -> Block:
        """Return memory for as many rows."""
        size = self.size
        numbers = np.zeros((size, self._ends[-1]))
        others: tuple[NDArray[Any], ...] = tuple(_empty((size, self._widths[scalar]), scalar) for scalar in _OTHERS)
        parts = (*(numbers[:, start:end] for start, end in pairwise(self._ends)), *others)
        rows = [tuple(part[k] for part in parts) for k in range(size)]
        return Block(times=np.zeros(size), numbers=numbers, others=others, parts=parts, rows=rows)

    def piece(self, block: Block, count: int) -> Piece:
        """Return the first rows of a block, valid until the next call.

        It holds the interpreter for some microseconds, whatever the number of signals, unless there are texts: copy
        and write are done beside the loop.
        """
        self._body[0, :count] = block.times[:count]
        parts = (block.numbers, *block.others)
        for rows, part, columns in self._runs:
            rows[:, :count] = parts[part][:count, columns].T
        numbers = self._body[:, :count]
        if self._batch is None:
            return Piece(batch=self._with_texts(block, count), numbers=numbers)
        if count == self.size:
            return Piece(batch=self._batch, numbers=numbers, message=self._message)
        return Piece(batch=self._batch.slice(0, count), numbers=numbers)

    def _with_texts(self, block: Block, count: int) -> pa.RecordBatch:
        """Return the first rows of a block, whose numbers are in the body, as Arrow's."""
        parts, places = (block.numbers, *block.others), self._places()
        arrays = []
        for k, field in enumerate(self.schema):
            if k in self._texts:
                part, column = places[k - 1]
                arrays.append(_array(parts[part][:count, column]))
            else:
                arrays.append(_array(self._body[k, :count].view(field.type.to_pandas_dtype())))
        return pa.RecordBatch.from_arrays(arrays, schema=self.schema)

    def copy(self, block: Block, count: int) -> pa.RecordBatch:
        """Return the first rows of a block as Arrow's, in memory of their own."""
        columns = [column for part in (block.numbers, *block.others) for column in np.array(part[:count].T, order="C")]
        arrays = [_array(block.times[:count].copy()), *(_array(columns[place]) for place in self._order)]
        return pa.RecordBatch.from_arrays(arrays, schema=self.schema)

    def rows(self, block: Block, count: int) -> Copied:
        """Return a copy of the first rows of a block, for `put_rows`."""
        return tuple(part[:count].copy() for part in (block.times, block.numbers, *block.others))

    def put_rows(self, block: Block, rows: Copied) -> None:
        """Set the first rows of a block to copied ones."""
        for part, copied in zip((block.times, block.numbers, *block.others), rows, strict=True):
            part[: len(copied)] = copied

    def fill(self, block: Block, batch: pa.RecordBatch) -> None:
        """Set the first rows of a block to those of a batch."""
        count = len(batch)
        block.times[:count] = column_values(batch.column(0))
        columns = [column for part in (block.numbers, *block.others) for column in part.T]
        for k, place in enumerate(self._order, 1):
            columns[place][:count] = column_values(batch.column(k))


def piece_of(batch: pa.RecordBatch) -> Piece:
    """Return rows that were read."""
    numbers = np.zeros((batch.num_columns, len(batch)))
    for row, column in zip(numbers, batch.columns, strict=True):
        if column.type != pa.string():
            values = column_values(column)
            row.view(values.dtype)[:] = values
    return Piece(batch=batch, numbers=numbers)


def _message(schema: pa.Schema, size: int) -> tuple[memoryview, NDArray[np.float64], pa.RecordBatch]:
    """Return a message of a stream with so many rows of numbers, its values (columns, size), and the batch it holds."""
    zeros = pa.py_buffer(bytes(8 * size))
    empty = [pa.Array.from_buffers(field.type, size, [None, zeros]) for field in schema]
    message = bytearray(pa.RecordBatch.from_arrays(empty, schema=schema).serialize())
    memory = pa.py_buffer(message)
    batch = pa.ipc.read_record_batch(memory, schema)
    addresses = [column.buffers()[1].address - memory.address for column in batch.columns]
    if addresses != list(range(addresses[0], addresses[0] + 8 * size * len(schema), 8 * size)):
        raise AssertionError("the columns of a batch are expected one after the other")
    values = np.frombuffer(message, np.float64, size * len(schema), addresses[0])
    return memoryview(message), values.reshape(len(schema), size), batch


def _empty(shape: tuple[int, int], scalar: Scalar) -> NDArray[Any]:
    """Return zeros, or empty texts."""
    return np.full(shape, "" if scalar == "String" else 0, DTYPES[scalar])


def _array(values: NDArray[Any]) -> pa.Array:
    """Return values as Arrow's; `pa.array` imports pandas at its first call, in the middle of the run."""
    if values.dtype == np.object_:
        return pa.array(values.tolist(), pa.string())
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [None, pa.py_buffer(values)])


def schema_of(signals: Sequence[Signal]) -> pa.Schema:
    """Return the names, types and units of the columns of a file."""
    fields = [pa.field("time", pa.float64(), nullable=False, metadata={"unit": "s", "description": "simulated time"})]
    for signal in signals:
        unit = signal.variable.unit.name if signal.variable.unit else ""
        metadata = {"unit": unit, "description": signal.variable.description, "type": signal.variable.type}
        kind = _COLUMNS.get(signal.variable.scalar or "", pa.float64())
        fields.append(pa.field(signal.name, kind, nullable=False, metadata=metadata))
    return pa.schema(fields)
