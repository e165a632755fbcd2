"""Read the recorded signals of a run: finished, still running, or killed."""

from collections.abc import ItemsView, Iterable, Iterator, Mapping, Sequence, ValuesView
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lockstep.array_names import by_array, in_order
from lockstep.errors import InputError, compact, suggestion
from lockstep.results.column_values import column_values
from lockstep.results.lazy_columns import LazyColumns
from lockstep.results.stream import STREAM, read_batches

PARQUET = "signals.parquet"  # of a run that ended


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Signals(Mapping[str, NDArray[Any]]):
    """Recorded signals by name `component.variable`, with the time [s] at which each row is true.

    A column is float64; a 64-bit integer of FMI 3.0 is int64 or uint64, and a text an object. As a mapping it goes
    through the signals, each element of an array by itself; whole arrays are read by their names.
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
        return self.side_by_side(elements)

    def side_by_side(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Return some signals as columns, (n, names): of a file, these are read at once, and no others."""
        if isinstance(self.columns, LazyColumns):
            self.columns.load([name for name in names if name in self.columns])
        return np.column_stack([self[name] for name in names])

    def get(self, name: str, default: Any = None) -> Any:
        """Return a signal or an array of signals, or the default if it was not recorded."""
        return self[name] if name in self else default  # noqa: SIM401 (this is `get`)

    def __contains__(self, name: object) -> bool:
        """Return whether a signal, or an array of signals, was recorded."""
        return name in self.columns or name in self._elements

    def items(self) -> ItemsView[str, NDArray[Any]]:
        """Return names and signals; of a file, all are read at once."""
        return self.columns.items()

    def values(self) -> ValuesView[NDArray[Any]]:
        """Return the signals; of a file, all are read at once."""
        return self.columns.values()

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the signals."""
        return iter(self.columns)

    def __len__(self) -> int:
        """Return the number of signals."""
        return len(self.columns)

    def __repr__(self) -> str:
        """Describe the signals in one line."""
        span = f", {self.time[0]:.9g} to {self.time[-1]:.9g} s" if len(self.time) else ""
        return f"<Signals: {len(self)} of {compact(self, 4)}; {len(self.time)} rows{span}>"

    def _ipython_key_completions_(self) -> list[str]:
        """Return what Tab offers between the brackets: arrays and signals."""
        return [*self._elements, *self.columns]

    @cached_property
    def _elements(self) -> dict[str, list[str]]:
        """The elements of each array, in the order of their indices."""
        return _elements(self.columns)


def signals_in_memory(blocks: Sequence[pa.RecordBatch], schema: pa.Schema) -> Signals:
    """Return the signals of a run in memory; columns are joined when they are read."""
    table = pa.Table.from_batches(blocks, schema)
    names = _chosen(schema, None)
    return _signals(column_values(table.column("time")), schema, names, LazyColumns(names, partial(_of_table, table)))


def open_signals(folder: Path | str) -> Signals:
    """Return the signals of a run, each of which is read from the folder when it is used first.

    Raises InputError, now or then, as `read_signals` does.
    """
    folder = Path(folder).absolute()
    if not (folder / PARQUET).exists():
        return read_signals(folder)  # the stream of a run that goes on or was killed is read as a whole
    with _open_parquet(folder / PARQUET) as file:
        schema = file.schema_arrow
    names = _chosen(schema, None)
    return _signals(read_signals(folder, []).time, schema, names, LazyColumns(names, partial(_of_folder, folder)))


def _of_table(table: pa.Table, names: Sequence[str]) -> Mapping[str, NDArray[np.float64]]:
    return {name: column_values(table.column(name)) for name in names}


def _of_folder(folder: Path, names: Sequence[str]) -> Mapping[str, NDArray[np.float64]]:
    """Return whole columns by name: without time, and without the order and the arrays of all names."""
    if not (folder / PARQUET).exists():
        raise InputError(f"{folder}: holds no {PARQUET} any more; give the folder of a run")
    with _open_parquet(folder / PARQUET) as file:
        missing = set(names).difference(file.schema_arrow.names)
        if missing:
            raise InputError(f"{folder / PARQUET}: has changed, {compact(sorted(missing))} is gone; read it again")
        with _refusing(folder / PARQUET):
            table = file.read(columns=list(names))
    return _of_table(table, names)


def _signals(
    time: NDArray[np.float64], schema: pa.Schema, names: Sequence[str], columns: Mapping[str, NDArray[np.float64]]
) -> Signals:
    metadata = {name: schema.field(name).metadata or {} for name in names}
    return Signals(
        time=time,
        columns=columns,
        units={name: metadata[name].get(b"unit", b"").decode() for name in names},
        descriptions={name: metadata[name].get(b"description", b"").decode() for name in names},
    )


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
    read = _of_table(table, names)
    return _signals(column_values(table.column("time")), schema, names, read)


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
