"""Return columns of Arrow as NumPy arrays: `to_numpy` of Arrow imports pandas, for half a second, if it is there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray


def column_values(column: pa.Array | pa.ChunkedArray) -> NDArray[Any]:
    """Return a column of numbers without gaps, or of texts; a view of the column's memory where there is one chunk."""
    if pa.types.is_string(column.type):
        return np.array(column.to_pylist(), object)
    chunks = column.chunks if isinstance(column, pa.ChunkedArray) else [column]
    parts = [_numbers(chunk) for chunk in chunks if len(chunk)]
    if len(parts) == 1:
        return parts[0]
    return np.concatenate(parts) if parts else np.empty(0, column.type.to_pandas_dtype())


def _numbers(array: pa.Array) -> NDArray[Any]:
    """Return the numbers of an array, whose memory the result keeps."""
    kind = np.dtype(array.type.to_pandas_dtype())
    _, values = array.buffers()
    return np.frombuffer(values, kind, len(array), array.offset * kind.itemsize)
