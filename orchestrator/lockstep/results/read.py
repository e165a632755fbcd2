"""Read the recorded signals of a run: finished, still running, or killed."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lockstep.array_names import by_array, in_order
from lockstep.errors import InputError, compact, suggestion
from lockstep.results.stream import STREAM, read_batches

PARQUET = "signals.parquet"  # of a run that ended


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Recorded signals by name `component.variable`, with the time [s] at which each row is true.

    A column is float64; a 64-bit integer of FMI 3.0 is int64 or uint64, and a text an object.
    """

    time: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    units: Mapping[str, str]
    descriptions: Mapping[str, str]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a signal, (n,); or an array `component.variable` as (n, elements), in the order of its indices."""
        if name in self.columns:
            return self.columns[name]
        elements = self._elements.get(name)
        if not elements:
            raise InputError(f"{name}: not recorded; there are {compact(self.columns)}{suggestion(name, self.columns)}")
        return np.column_stack([self.columns[element] for element in elements])

    def __contains__(self, name: str) -> bool:
        """Return whether a signal, or an array of signals, was recorded."""
        return name in self.columns or name in self._elements

    @cached_property
    def _elements(self) -> dict[str, list[str]]:
        """The elements of each array, in the order of their indices."""
        return _elements(self.columns)


def read_signals(folder: Path | str, columns: Sequence[str] | None = None) -> Signals:
    """Read a run's signals, from the compressed file or from the stream of a run that was killed.

    Parameters
    ----------
    folder : results folder of a run
    columns : names of signals or of whole arrays; None for all. Time comes always.

    Raises
    ------
    InputError
        If the folder holds no signals, their file is damaged, or a column was not recorded.
    """
    folder = Path(folder)
    if (folder / PARQUET).exists():
        with _open_parquet(folder / PARQUET) as file:
            schema = file.schema_arrow
            names = _chosen(schema, columns)
            with _refusing(folder / PARQUET):
                table = file.read(columns=["time", *names])
    elif (folder / STREAM).exists():
        with read_batches(folder / STREAM) as (schema, batches):
            names = _chosen(schema, columns)
            picked = [batch.select(["time", *names]) for batch in batches]
            table = pa.Table.from_batches(picked, pa.schema([schema.field(name) for name in ("time", *names)]))
    else:
        raise InputError(f"{folder}: holds no {PARQUET} and no {STREAM}; give the folder of a run")
    metadata = {name: schema.field(name).metadata or {} for name in names}
    return Signals(
        time=table.column("time").to_numpy(),
        columns={name: table.column(name).to_numpy() for name in names},
        units={name: metadata[name].get(b"unit", b"").decode() for name in names},
        descriptions={name: metadata[name].get(b"description", b"").decode() for name in names},
    )


@contextmanager
def open_batches(folder: Path) -> Iterator[tuple[pa.Schema, Iterator[pa.RecordBatch]]]:
    """Open the signals of a run, a bounded number of rows at a time, whether it ended or not."""
    if (folder / STREAM).exists() or not (folder / PARQUET).exists():
        with read_batches(folder / STREAM) as opened:
            yield opened
        return
    with _open_parquet(folder / PARQUET) as file:
        yield file.schema_arrow, _parquet_batches(folder / PARQUET, file)


def recorded_rows(folder: Path, enough: int) -> int:
    """Count the rows of a run, ended or not; stop when there are enough."""
    count = 0
    if not enough:
        return count  # a run of less than a second may have left no file that can be read
    with open_batches(folder) as (_, batches):
        for batch in batches:
            count += len(batch)
            if count >= enough:
                break
    return count


@contextmanager
def _open_parquet(path: Path) -> Iterator[pq.ParquetFile]:
    """Open the file of a run that ended; a page that differs from its checksum is refused when it is read."""
    with _refusing(path):
        file = pq.ParquetFile(path, page_checksum_verification=True)  # pq.read_table imports for half a second
    with file:
        yield file


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """Raise InputError where the file cannot be read."""
    try:
        yield
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"{path}: cannot be read ({error}); restore the file, or run again") from None


def _parquet_batches(path: Path, file: pq.ParquetFile) -> Iterator[pa.RecordBatch]:
    batches = file.iter_batches()
    while True:
        with _refusing(path):
            batch = next(batches, None)
        if batch is None:
            return
        yield batch


def _chosen(schema: pa.Schema, columns: Sequence[str] | None) -> list[str]:
    names = in_order(name for name in schema.names if name != "time")
    if columns is None:
        return names
    known, elements, chosen = set(names), _elements(names), dict[str, None]()
    for column in columns:
        found = [column] if column in known else elements.get(column, [])
        if not found and column != "time":
            raise InputError(f"{column}: not recorded; there are {compact(names)}{suggestion(column, names)}")
        chosen.update(dict.fromkeys(found))
    return list(chosen)


def _elements(names: Iterable[str]) -> dict[str, list[str]]:
    """Return the elements of each array among names, in the order of their indices."""
    return {array: list(elements.values()) for array, elements in by_array(names).items() if elements}
