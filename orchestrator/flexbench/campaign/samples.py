"""The results of a campaign as samples: for each system its inputs, metrics and lost runs, by number; and its bands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep import InputError

from .result_file import BANDS, RESULTS, Results, read_results
from .statistics.sample import Metric, MetricRequirement, Sample, direction


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignResults:
    """A merged campaign: what was asked, and the runs of each system."""

    folder: Path
    content: Mapping[str, Any]  # of campaign.json
    metrics: tuple[Metric, ...]
    requirements: tuple[MetricRequirement, ...]
    samples: tuple[Sample, ...]  # of each system, in the order of the campaign

    @property
    def name(self) -> str:
        """The name of the campaign."""
        return str(self.content["name"])


def load_samples(folder: Path) -> CampaignResults:
    """Return the results of a campaign.

    Raises
    ------
    InputError
        If the folder holds no merged campaign, or one that cannot be read.
    """
    results = read_results(folder)
    if not len(results.numbers):
        raise InputError(f"{folder / RESULTS}: no runs")
    requirements = results.requirement_list()
    return CampaignResults(
        folder=folder,
        content=results.about,
        metrics=tuple(replace(one, worse=direction(one.name, requirements)) for one in results.metric_list()),
        requirements=requirements,
        samples=samples_of(results),
    )


def samples_of(results: Results) -> tuple[Sample, ...]:
    """Return the runs of each system, in the order in which systems first come."""
    systems = np.array(results.systems)
    return tuple(_sample(name, np.flatnonzero(systems == name), results) for name in dict.fromkeys(results.systems))


def _sample(system: str, rows: NDArray[np.intp], results: Results) -> Sample:
    columns = {name: [values[i] for i in rows] for name, values in results.inputs.items()}
    texts = {name for name, values in columns.items() if any(isinstance(one, str) for one in values)}
    return Sample(
        system=system,
        numbers=results.numbers[rows],
        inputs={name: np.array(values, dtype=float) for name, values in columns.items() if name not in texts},
        choices={name: [str(one) for one in columns[name]] for name in columns if name in texts},
        units={str(one["name"]): str(one.get("unit") or "") for one in results.about["inputs"]},
        metrics={name: values[rows] for name, values in results.metrics.items()},
        causes=[results.causes[i] for i in rows],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """Percentiles over time of one signal over the runs of one system."""

    system: str
    signal: str
    runs: int
    time: Array  # (n,) [s]
    levels: Mapping[str, Array]  # (n,) each, by name: least, p05, ..., largest, in rising order


def load_bands(folder: Path) -> list[Band]:
    """Return the bands that a campaign kept; none if it kept none.

    Raises
    ------
    InputError
        If there is a file of bands that cannot be read.
    """
    file = folder / BANDS
    if not file.is_file():
        return []
    table = _read(file)
    names = [name for name in table.column_names if name not in ("system", "signal", "time", "runs", "unit")]
    systems, signals = (np.array(table[name].to_pylist()) for name in ("system", "signal"))
    runs = np.asarray(table["runs"].to_numpy())
    columns = {name: _column(table[name]) for name in ("time", *names)}
    bands = []
    for signal, system in dict.fromkeys(zip(signals.tolist(), systems.tolist(), strict=True)):
        rows = np.flatnonzero((signals == signal) & (systems == system))
        levels = {name: columns[name][rows] for name in names}
        bands.append(
            Band(system=system, signal=signal, runs=int(runs[rows].max()), time=columns["time"][rows], levels=levels)
        )
    return bands


def _read(file: Path) -> pa.Table:
    try:
        return pq.read_table(file)
    except (OSError, pa.ArrowException) as error:
        raise InputError(f"{file}: cannot be read ({error}); run the campaign again") from None


def _column(column: pa.ChunkedArray) -> Array:
    """Return a column as floats, null as NaN."""
    return np.array(column.to_numpy(), dtype=float)
