"""A run as an xarray Dataset: arrays of signals with named dimensions, units, and where the run came from."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from lockstep import InputError, read_signals
from lockstep.array_names import Index, by_array, grid_axes

AXES = (1, 2, 3)  # indices of a vector in body axes
# words in a name that say what its elements are, before all rules
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
    manifest, text = read_manifest(folder)
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
    return xr.Dataset(variables, coordinates, run_attributes(manifest, text))


def _dimensions(name: str, elements: Iterable[Index], coordinates: dict[str, Any]) -> list[str]:
    """Return the names of an array's dimensions, and enter their indices among the coordinates."""
    indices = list(elements)
    axes = grid_axes(indices)
    if axes is None:  # a part of a matrix
        dimension = f"{name} element"
        coordinates[dimension] = (dimension, np.array([",".join(map(str, index)) for index in indices]))
        return [dimension]
    if len(axes) == 1:
        names = [dimension_of(name, axes[0])]
        known = coordinates.get(names[0])
        if known is not None and tuple(known[1]) != axes[0]:  # recorded in parts: an index of its own
            names = [f"{name} element"]
    else:
        words = ("row", "column") if len(axes) == 2 else [f"index {number}" for number in range(1, len(axes) + 1)]
        names = [f"{name} {word}" for word in words]
    for dimension, values in zip(names, axes, strict=True):
        coordinates.setdefault(dimension, (dimension, np.array(values)))
    return names


def read_manifest(folder: Path) -> tuple[Mapping[str, Any], str]:
    """Return run.toml of a results folder, understood and as text; raise InputError if there is none."""
    path = folder / "run.toml"
    if not path.is_file():
        raise InputError(f"{folder}: holds no run.toml; give the folder of a run")
    text = path.read_text(encoding="utf-8")
    try:
        return tomllib.loads(text), text
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: is no TOML ({error}); run again, or restore the file") from None


def dimension_of(name: str, indices: Sequence[int]) -> str:
    """Name what the elements of an array are: axis, wheel, mode, or the word before the quantity, as gyro."""
    words = name.split(".")
    for word in reversed(words):
        if word in DIMENSIONS and tuple(indices) != AXES:
            return DIMENSIONS[word]
    if tuple(indices) == AXES:
        return "axis"
    return words[-2] if len(words) > 2 else f"{name} element"


def run_attributes(manifest: Mapping[str, Any], text: str) -> dict[str, str | int | float]:
    """Return what a run is, as text and numbers: system, seed, versions, hashes; `run_toml` holds all of it."""
    components = manifest.get("component", [])
    seeds = {c["name"]: c["parameters"]["seed"] for c in components if "seed" in c.get("parameters", {})}
    attributes: dict[str, str | int | float] = {
        "system": manifest.get("system", {}).get("name", ""),
        "status": manifest.get("status", ""),
        "simulated_time": float(manifest.get("simulated_time", 0.0)),
        "started": manifest.get("started", ""),
        "versions": ", ".join(f"{name} {value}" for name, value in manifest.get("versions", {}).items()),
        "fmu_sha256": json.dumps({c["name"]: c.get("sha256", "") for c in components}),
        "run_toml": text,
    }
    if seeds:
        same = len(set(seeds.values())) == 1
        attributes["seed"] = int(next(iter(seeds.values()))) if same else json.dumps(seeds)
    return attributes
