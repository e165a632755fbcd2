"""Load a run as an xarray Dataset: arrays with named dimensions and units, and the run's system, seed and versions."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from lockstep import read_signals
from lockstep.array_names import Index, by_array, grid_axes
from lockstep.results.read_run_record import read_run_record

AXES = (1, 2, 3)  # indices of a vector in body axes
# words in the name of an array that name its dimension; they come before the other rules
DIMENSIONS = {"wheel": "wheel", "modal": "mode", "torque": "wheel"}


def load_dataset(folder: Path | str, signals: Sequence[str] | None = None) -> xr.Dataset:
    """Return a run's signals, each array `component.variable[1..n]` as one variable (time, n), a matrix with two more.

    Parameters
    ----------
    folder : results folder of a run, also of one that still runs or was killed
    signals : names of signals or of whole arrays; None for all

    Returns
    -------
    Dataset
        Coordinates are `time` [s] and the FMI index of each dimension, from 1. Each variable has the attributes
        `units` and `description`, the dataset those of `run_attributes`.

    Raises
    ------
    InputError
        If the folder holds no run, or a signal was not recorded.
    """
    folder = Path(folder)
    record, text = read_run_record(folder)
    recorded = read_signals(folder, signals)
    time = ("time", recorded.time, {"units": "s", "description": "time at which the row is true"})
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": time}
    for name, elements in by_array(recorded.columns).items():
        first = next(iter(elements.values()), name)
        about = {"units": recorded.units[first], "description": recorded.descriptions[first]}
        if not elements:
            variables[name] = ("time", recorded.columns[name], about)
            continue
        dimensions = _dimensions(name, elements, coordinates)
        values = np.column_stack([recorded.columns[element] for element in elements.values()])
        sizes = [len(coordinates[dimension][1]) for dimension in dimensions]
        variables[name] = (("time", *dimensions), values.reshape(len(values), *sizes), about)
    return xr.Dataset(variables, coordinates, run_attributes(record, text))


def _dimensions(name: str, elements: Iterable[Index], coordinates: dict[str, Any]) -> list[str]:
    """Return the names of an array's dimensions, and add their indices to the coordinates."""
    indices = list(elements)
    axes = grid_axes(indices)
    if axes is None:  # a part of a matrix
        dimension = f"{name} element"
        coordinates[dimension] = (dimension, np.array([",".join(map(str, index)) for index in indices]))
        return [dimension]
    if len(axes) == 1:
        names = [dimension_of(name, axes[0])]
        known = coordinates.get(names[0])
        if known is not None and tuple(known[1]) != axes[0]:  # recorded in part: it needs its own index
            names = [f"{name} element"]
    else:
        words = ("row", "column") if len(axes) == 2 else [f"index {number}" for number in range(1, len(axes) + 1)]
        names = [f"{name} {word}" for word in words]
    for dimension, values in zip(names, axes, strict=True):
        coordinates.setdefault(dimension, (dimension, np.array(values)))
    return names


def dimension_of(name: str, indices: Sequence[int]) -> str:
    """Return the name of an array's dimension: axis, wheel, mode, or the word before the quantity, such as gyro."""
    words = name.split(".")
    for word in reversed(words):
        if word in DIMENSIONS and tuple(indices) != AXES:
            return DIMENSIONS[word]
    if tuple(indices) == AXES:
        return "axis"
    return words[-2] if len(words) > 2 else f"{name} element"


def run_attributes(record: Mapping[str, Any], text: str) -> dict[str, str | int | float]:
    """Return system, seed, versions and hashes of a run, as texts and numbers; `run_toml` holds the whole record."""
    components = record.get("component", [])
    seeds = {c["name"]: c["parameters"]["seed"] for c in components if "seed" in c.get("parameters", {})}
    attributes: dict[str, str | int | float] = {
        "system": record.get("system", {}).get("name", ""),
        "status": record.get("status", ""),
        "simulated_time": float(record.get("simulated_time", 0.0)),
        "started": record.get("started", ""),
        "versions": ", ".join(f"{name} {value}" for name, value in record.get("versions", {}).items()),
        "fmu_sha256": json.dumps({c["name"]: c.get("sha256", "") for c in components}),
        "run_toml": text,
    }
    if seeds:
        same = len(set(seeds.values())) == 1
        attributes["seed"] = int(next(iter(seeds.values()))) if same else json.dumps(seeds)
    return attributes
