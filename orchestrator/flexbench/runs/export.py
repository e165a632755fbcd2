"""Export a run's signals with their units to one file: CSV, MATLAB, HDF5 (netCDF-4) or Parquet."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import xarray as xr
from numpy.typing import NDArray
from pyarrow import csv, parquet
from scipy.io import savemat

from lockstep import InputError
from lockstep.errors import compact, suggestion
from lockstep.results.read import read_signals
from lockstep.results.read_run_record import read_run_record
from lockstep.results.signal_patterns import matching

from .dataset import load_dataset, run_attributes
from .run_folder import refuse_own_file

LONGEST_FIELD = 63  # letters of a MATLAB name
SUFFIXES = {"csv": ".csv", "mat": ".mat", "hdf5": ".h5", "parquet": ".parquet"}


def export_run(folder: Path, to: str, out: Path | None = None, patterns: Sequence[str] = ()) -> Path:
    """Write a run's signals as one file, complete or not at all, and return its path.

    Parameters
    ----------
    folder : results folder of a run
    to : csv, mat, hdf5 or parquet
    out : file to write; None for one in the folder, with the folder's name
    patterns : signals to write, with the wildcards `*` and `?`, an array by its name; none for all

    Raises
    ------
    InputError
        If the folder holds no run, a pattern matches nothing, or the file cannot be written.
    """
    if to not in SUFFIXES:
        raise InputError(f"--format {to}: no such format; there are {', '.join(SUFFIXES)}")
    read_run_record(folder)  # that it is the folder of a run
    out = out or folder / f"{folder.resolve().name}{SUFFIXES[to]}"
    if out.is_dir():
        raise InputError(f"{out}: is a folder; give a file, for example {out / ('signals' + SUFFIXES[to])}")
    refuse_own_file(out)
    names = chosen_signals(folder, patterns)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent) as partial:
            file = Path(partial) / out.name
            WRITERS[to](folder, names, file)
            file.replace(out)
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror or error}); choose another file") from None
    return out


def chosen_signals(folder: Path, patterns: Sequence[str]) -> list[str] | None:
    """Return the recorded signals that match any pattern, in their order; None for all."""
    if not patterns:
        return None
    names = list(read_signals(folder).columns)
    chosen: set[str] = set()
    for pattern in patterns:
        matched = matching(pattern, names)
        if not matched:
            raise InputError(
                f"--signals {pattern}: matches nothing; recorded are {compact(names)}{suggestion(pattern, names)}"
            )
        chosen.update(matched)
    return [name for name in names if name in chosen]


def _write_csv(folder: Path, names: list[str] | None, file: Path) -> None:
    """Write a header of names and units, `plant.rate[1] [rad/s]`, and numbers with all their digits."""
    signals = read_signals(folder, names)
    header = ["time [s]", *(f"{name} [{signals.units[name] or '1'}]" for name in signals.columns)]
    table = pa.table([signals.time, *signals.columns.values()], names=header)
    csv.write_csv(table, file)


def _write_parquet(folder: Path, names: list[str] | None, file: Path) -> None:
    """Write one column for each signal, unit and description in its field; the run's attributes are in the schema."""
    signals = read_signals(folder, names)
    record, text = read_run_record(folder)
    fields = [pa.field("time", pa.float64(), metadata={"unit": "s", "description": "time at which the row is true"})]
    fields += [
        pa.field(name, kind, metadata={"unit": signals.units[name], "description": signals.descriptions[name]})
        for name, kind in ((name, pa.array(values).type) for name, values in signals.columns.items())
    ]
    about = {key: str(value) for key, value in run_attributes(record, text).items()}
    schema = pa.schema(fields, metadata=about)
    parquet.write_table(pa.table([signals.time, *signals.columns.values()], schema=schema), file)


def _write_hdf5(folder: Path, names: list[str] | None, file: Path) -> None:
    """Write a netCDF-4 file, which is HDF5: arrays with named dimensions and attributes."""
    dataset = load_dataset(folder, names)
    # a component of a nested system is named by its path; in HDF5 a slash starts a group
    dataset = dataset.rename(
        {str(n): str(n).replace("/", ".") for n in (*dataset.variables, *dataset.dims) if "/" in str(n)}
    )
    packed = {name: {"zlib": True, "complevel": 1, "shuffle": True} for name in dataset.data_vars}
    # in memory first: HDF5 crashes, and takes the process along, when it cannot write to its file
    file.write_bytes(dataset.to_netcdf(None, engine="h5netcdf", encoding=packed))


def _write_mat(folder: Path, names: list[str] | None, file: Path) -> None:
    """Write `time` and the structures `signals`, `units`, `descriptions`, `elements`, as signals.plant.wheel.speed."""
    dataset = load_dataset(folder, names)
    content: dict[str, Any] = {
        "time": dataset["time"].to_numpy(),
        "signals": _nested(dataset, lambda variable: variable.to_numpy()),
        "units": _nested(dataset, lambda variable: variable.attrs["units"]),
        "descriptions": _nested(dataset, lambda variable: variable.attrs["description"]),
        "elements": _nested(dataset, _indices, arrays_only=True),
        "run": {_field(str(key)): value for key, value in dataset.attrs.items()},
    }
    content = {name: value for name, value in content.items() if len(value)}  # not every reader takes empty structures
    savemat(file, content, long_field_names=True, do_compression=True, oned_as="column")


def _indices(variable: xr.DataArray) -> NDArray[Any]:
    """Return the index of each element, (n,); of a matrix, (n, 2), in the order in which its rows are read."""
    axes = [variable[dimension].to_numpy() for dimension in variable.dims[1:]]
    return axes[0] if len(axes) == 1 else np.array(list(product(*axes)))


def _nested(dataset: xr.Dataset, value: Callable[[xr.DataArray], Any], arrays_only: bool = False) -> dict[str, Any]:
    """Return a value of each variable, nested by the parts of their names."""
    structure: dict[str, Any] = {}
    taken: dict[tuple[str, ...], str] = {}
    for name in map(str, dataset.data_vars):
        if arrays_only and dataset[name].ndim < 2:
            continue
        path = tuple(_field(part) for part in name.split("."))
        inside = structure
        for part in path[:-1]:
            inside = inside.setdefault(part, {})
            if not isinstance(inside, dict):
                raise InputError(f"{name}: is a signal and part of another's name; export to hdf5 instead")
        if path in taken or path[-1] in inside:
            raise InputError(
                f"{name}: MATLAB cannot distinguish it from {taken.get(path, name)}; export to hdf5 instead"
            )
        taken[path] = name
        inside[path[-1]] = value(dataset[name])
    return structure


def _field(part: str) -> str:
    """Return a valid MATLAB field name: letters, digits and underscores, starting with a letter."""
    field = re.sub(r"\W", "_", part, flags=re.ASCII)
    if not field[:1].isalpha():
        field = f"x{field}"
    if len(field) > LONGEST_FIELD:
        raise InputError(f"{part}: too long for MATLAB, which takes {LONGEST_FIELD} letters; export to hdf5 instead")
    return field


WRITERS: Mapping[str, Callable[[Path, list[str] | None, Path], None]] = {
    "csv": _write_csv,
    "mat": _write_mat,
    "hdf5": _write_hdf5,
    "parquet": _write_parquet,
}
