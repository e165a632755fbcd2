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


class Columns:
    """The columns of the signals in the order of the file, for so many rows; their memory is used again and again."""

    def __init__(self, signals: Sequence[Signal], size: int) -> None:
        self.size = size
        self.schema = schema_of(signals)
        by_type: dict[Scalar, list[int]] = {scalar: [] for scalar in SCALARS}  # numbers of the signals
        for number, signal in enumerate(signals):
            if signal.variable.scalar is not None:
                by_type[signal.variable.scalar].append(number)
        self._ends = np.cumsum([0, *(len(by_type[scalar]) for scalar in _NUMBERS)]).tolist()
        self._widths = {scalar: len(by_type[scalar]) for scalar in _OTHERS}
        self._times = np.zeros(size)
        self._numbers = np.zeros((self._ends[-1], size))
        self._others: list[NDArray[Any]] = [_empty((self._widths[scalar], size), scalar) for scalar in _OTHERS]
        places = {number: place for place, number in enumerate(n for group in by_type.values() for n in group)}
        self._order = [places[number] for number in range(len(places))]  # of the file, in a block
        self._arrays = [_array(column) for column in (self._times, *self._in_order())]  # of texts: what they are now
        self._batch = pa.RecordBatch.from_arrays(self._arrays, schema=self.schema)
        texts = [k for k, field in enumerate(self.schema) if field.type == pa.string()]
        self._texts = dict(zip(texts, [self._in_order()[k - 1] for k in texts], strict=True))

    def _in_order(self) -> list[NDArray[Any]]:
        columns = [column for part in (self._numbers, *self._others) for column in part]
        return [columns[place] for place in self._order]

    def block(self) -> Block:
        """Return memory for as many rows."""
        size = self.size
        numbers = np.zeros((size, self._ends[-1]))
        others: tuple[NDArray[Any], ...] = tuple(_empty((size, self._widths[scalar]), scalar) for scalar in _OTHERS)
        parts = (*(numbers[:, start:end] for start, end in pairwise(self._ends)), *others)
        rows = [tuple(part[k] for part in parts) for k in range(size)]
        return Block(times=np.zeros(size), numbers=numbers, others=others, parts=parts, rows=rows)

    def batch(self, block: Block, count: int) -> pa.RecordBatch:
        """Return the first rows of a block as Arrow's, valid until the next call.

        It holds the interpreter for some microseconds, whatever the number of signals, unless there are texts: copy
        and write are done beside the loop.
        """
        self._times[:count] = block.times[:count]
        self._numbers[:, :count] = block.numbers[:count].T
        for columns, values in zip(self._others, block.others, strict=True):
            columns[:, :count] = values[:count].T
        if not self._texts:
            return self._batch if count == self.size else self._batch.slice(0, count)
        arrays = [
            _array(self._texts[k][:count]) if k in self._texts else array.slice(0, count)
            for k, array in enumerate(self._arrays)
        ]
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
