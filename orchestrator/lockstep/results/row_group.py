"""The rows of one row group of the compressed file, column by column, until they are written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lockstep.results.blocks import Piece
from lockstep.results.column_values import column_values


class RowGroup:
    """So many rows in memory that is used again for other ones."""

    def __init__(self, schema: pa.Schema, size: int) -> None:
        self._schema, self.size = schema, size
        self._numbers = np.empty((len(schema), size))  # 8 bytes of each value; those of texts are not used
        self._kinds = [None if field.type == pa.string() else field.type.to_pandas_dtype() for field in schema]
        self._texts: dict[int, list[pa.Array]] = {k: [] for k, kind in enumerate(self._kinds) if kind is None}
        self._places = {name: k for k, name in enumerate(schema.names)}
        self.count = 0  # rows in it

    def add(self, piece: Piece) -> None:
        """Copy rows, which have to fit."""
        end = self.count + len(piece.batch)
        self._numbers[:, self.count : end] = piece.numbers
        for k, chunks in self._texts.items():
            chunks.append(piece.batch.column(k))
        self.count = end

    def clear(self) -> None:
        """Begin again without rows."""
        self.count = 0
        for chunks in self._texts.values():
            chunks.clear()

    def table(self) -> pa.Table:
        """Return the rows as Arrow's, which share the memory."""
        return pa.Table.from_arrays([self._column(k) for k in range(len(self._schema))], schema=self._schema)

    def _column(self, k: int) -> pa.Array | pa.ChunkedArray:
        if self._kinds[k] is None:
            return pa.chunked_array(self._texts[k], pa.string())
        values = pa.py_buffer(self._numbers[k, : self.count])
        return pa.Array.from_buffers(self._schema.field(k).type, self.count, [None, values])

    def values(self, k: int, begin: int, end: int) -> NDArray[Any]:
        """Return a copy of the values of a column in some rows."""
        kind = self._kinds[k]
        if kind is None:
            return column_values(pa.chunked_array(self._texts[k], pa.string()).slice(begin, end - begin))
        values: NDArray[Any] = self._numbers[k, begin:end].view(kind)
        return values.copy()

    def rows(self, begin: int, end: int) -> tuple[NDArray[np.float64], Mapping[str, NDArray[Any]]]:
        """Return the times of some rows, and their signals by name, each copied when it is read."""
        return self.values(0, begin, end), _Rows(self, self._places, begin, end)


class _Rows(Mapping[str, NDArray[Any]]):
    """The signals in some rows of a group."""

    def __init__(self, group: RowGroup, places: Mapping[str, int], begin: int, end: int) -> None:
        self._group, self._places, self._begin, self._end = group, places, begin, end

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._group.values(self._places[name], self._begin, self._end)

    def __iter__(self) -> Iterator[str]:
        return (name for name, place in self._places.items() if place)

    def __len__(self) -> int:
        return len(self._places) - 1
