"""Read tables over time of others: CSV or Parquet files with a column `time` in seconds and named columns."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pyarrow import csv as arrow_csv

from lockstep.errors import InputError, compact
from lockstep.whole_file import file_digest

TIME = "time"
_DELIMITERS = ",;\t"
_WITH_UNIT = re.compile(r"(.*\S)\s+\[([^\[\]]*)\]")  # as in exported results: `plant.rate[1] [rad/s]`


@dataclass(frozen=True, slots=True, kw_only=True)
class TableFile:
    """A file, its digest and the names of its columns. `delimiter` is that of a CSV file, "" for Parquet."""

    path: Path
    sha256: str
    names: tuple[str, ...]
    delimiter: str
    units: Mapping[str, str] = field(default_factory=dict)  # that columns state, as `rate [rad/s]` or in their metadata

    def __str__(self) -> str:
        return self.path.name

    def read(self, reals: Collection[str]) -> Table:
        """Read the file, these columns as doubles and the others as their text if it is CSV, or raise InputError."""
        if not self.delimiter:
            found = _refusing(self.path, lambda: pq.read_table(self.path)).rename_columns(list(self.names))
            return Table(file=self, columns=found)
        options = arrow_csv.ConvertOptions(
            column_types={name: pa.float64() if name in reals else pa.string() for name in self.names},
            null_values=[""],
        )
        reading = arrow_csv.ReadOptions(column_names=list(self.names), skip_rows=1)
        parsing = arrow_csv.ParseOptions(delimiter=self.delimiter)
        read = _refusing(self.path, lambda: arrow_csv.read_csv(self.path, reading, parsing, options))
        return Table(file=self, columns=read)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The columns of a file."""

    file: TableFile
    columns: pa.Table

    def times(self) -> NDArray[np.float64]:
        """Return the times [s]; InputError if there are none, or one is before that of the row before."""
        times = self.numbers(TIME)
        if not len(times):
            raise InputError(f"{self.file}: has no rows; give at least one")
        back = np.flatnonzero(np.diff(times) < 0.0)
        if len(back):
            row = int(back[0]) + 1
            order = f"time {times[row]:.9g} s after {times[row - 1]:.9g} s"
            raise InputError(f"{self.file}: row {row + 1}: {order}; sort the rows")
        return times

    def numbers(self, name: str) -> NDArray[np.float64]:
        """Return a column as doubles; InputError if one is missing or not finite."""
        column = _refusing(self.file.path, lambda: self.columns.column(name).cast(pa.float64()))
        values: NDArray[np.float64] = column.to_numpy()
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            row = int(bad[0])
            what = "is empty" if column[row].as_py() is None else f"{values[row]} must be finite"
            raise InputError(f"{self.file}: row {row + 1}: {name} {what}")
        return values

    def python_values(self, name: str) -> list[Any]:
        """Return a column as values of Python."""
        found: list[Any] = self.columns.column(name).to_pylist()
        return found


def open_table(path: Path) -> TableFile:
    """Return what a file holds, or raise InputError."""
    digest = table_digest(path)
    with path.open("rb") as stream:
        parquet = stream.read(4) == b"PAR1"
    if parquet:
        schema = _refusing(path, lambda: pq.read_schema(path))
        names, delimiter = [str(name) for name in schema.names], ""
        units = [
            (schema.field(k).metadata or {}).get(b"unit", b"").decode("utf-8", "replace") for k in range(len(names))
        ]
    else:
        header, delimiter = _csv_header(path)
        found = [_WITH_UNIT.fullmatch(name) for name in header]
        names = [name if match is None else match[1] for name, match in zip(header, found, strict=True)]
        units = ["" if match is None else match[2] for match in found]
    timed = [name for name in names if name.lower() == TIME]
    if len(timed) != 1:
        there = f"it has {compact(names)}"
        raise InputError(f"{path.name}: has {len(timed)} columns {TIME}, and needs one, in seconds; {there}")
    renamed = tuple(TIME if name == timed[0] else name for name in names)
    twice = [name for name in renamed if renamed.count(name) > 1] if len(set(renamed)) < len(renamed) else []
    if twice:
        raise InputError(f"{path.name}: has the column {twice[0]} twice; remove one of them")
    stated = {name: unit for name, unit in zip(renamed, units, strict=True) if unit not in ("", "1")}
    if stated.get(TIME, "s") != "s":
        raise InputError(f"{path.name}: has its time in {stated[TIME]}; give seconds")
    return TableFile(path=path, sha256=digest, names=renamed, delimiter=delimiter, units=stated)


def table_digest(path: Path) -> str:
    """Return the SHA-256 of a file, or raise InputError."""
    try:
        return file_digest(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); give a CSV or Parquet file") from None


def _csv_header(path: Path) -> tuple[list[str], str]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            line = stream.readline()
    except UnicodeDecodeError:
        raise InputError(f"{path.name}: is neither CSV in UTF-8 nor Parquet; save it as one of them") from None
    delimiter = next((letter for letter in _DELIMITERS if letter in line), ",")
    return [name.strip() for name in next(csv.reader([line], delimiter=delimiter), [])], delimiter


def _refusing(path: Path, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except (pa.ArrowException, OSError, ValueError) as error:
        raise InputError(f"{path.name}: cannot be read ({' '.join(str(error).split())})") from None
