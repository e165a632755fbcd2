"""Read the results of a campaign as samples: for each system its inputs, metrics and lost runs, by number."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from flexbench.runs.json_file import read_table
from flexsat.arrays import Array
from lockstep import InputError

from .statistics.sample import Metric, Requirement, Sample, direction

CONTENT, RESULTS, BANDS = "campaign.json", "results.parquet", "bands.parquet"
_SHAPE = {
    "name": "text", "?sampling": "text",
    "inputs": [{"name": "text", "?unit": "text?"}],
    "metrics": [{"name": "text", "?unit": "text?", "?shown_unit": "text?", "?scale": "number?"}],
    "requirements": [{"name": "text", "metric": "text", "?most": "number?", "?least": "number?",
                      "?probability": "number?", "?confidence": "number?"}],
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignResults:
    """A merged campaign: what was asked, and the runs of each system."""

    folder: Path
    content: Mapping[str, Any]  # of campaign.json
    metrics: tuple[Metric, ...]
    requirements: tuple[Requirement, ...]
    samples: tuple[Sample, ...]  # of each system, in the order of the campaign

    @property
    def name(self) -> str:
        """The name of the campaign."""
        return str(self.content["name"])


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


def load_samples(folder: Path) -> CampaignResults:
    """Return the results of a campaign.

    Raises
    ------
    InputError
        If the folder holds no merged campaign, or one that cannot be read.
    """
    content = read_table(folder / CONTENT, _SHAPE)
    if content is None:
        raise InputError(f"{folder}: no campaign; it has no {CONTENT}. Give the folder that `flexsat campaign` wrote")
    if not (folder / RESULTS).is_file():
        raise InputError(f"{folder / RESULTS}: not there; run the campaign to its end with the same command")
    table = _read(folder / RESULTS)
    if table.num_rows == 0:
        raise InputError(f"{folder / RESULTS}: no runs")
    requirements = tuple(_requirement(one) for one in content["requirements"])
    metrics = tuple(
        Metric(
            name=str(one["name"]),
            unit=str(one.get("unit") or ""),
            shown_unit=str(one.get("shown_unit") or one.get("unit") or ""),
            scale=float(one.get("scale") or 1.0),
            worse=direction(str(one["name"]), requirements),
        )
        for one in content["metrics"]
    )
    systems = np.array(table["system"].to_pylist())
    names = list(dict.fromkeys(systems.tolist()))
    samples = tuple(_sample(name, table.filter(pa.array(systems == name)), content) for name in names)
    return CampaignResults(folder=folder, content=content, metrics=metrics, requirements=requirements, samples=samples)


def _requirement(one: Mapping[str, Any]) -> Requirement:
    confidence = one.get("confidence")
    return Requirement(
        name=str(one["name"]),
        metric=str(one["metric"]),
        most=one.get("most"),
        least=one.get("least"),
        probability=one.get("probability"),
        **({} if confidence is None else {"confidence": confidence}),
    )


def _sample(system: str, table: pa.Table, content: Mapping[str, Any]) -> Sample:
    table = table.sort_by("number")
    names = [str(one["name"]) for one in content["inputs"] if f"input.{one['name']}" in table.column_names]
    texts = [name for name in names if not pa.types.is_floating(table[f"input.{name}"].type)]
    return Sample(
        system=system,
        numbers=np.asarray(table["number"].to_numpy(), dtype=np.int64),
        inputs={name: _column(table[f"input.{name}"]) for name in names if name not in texts},
        choices={name: [str(one) for one in table[f"input.{name}"].to_pylist()] for name in texts},
        units={str(one["name"]): str(one.get("unit") or "") for one in content["inputs"]},
        metrics={str(one["name"]): _column(table[f"metric.{one['name']}"]) for one in content["metrics"]},
        causes=["" if cause is None else str(cause) for cause in table["cause"].to_pylist()],
    )


def _column(column: pa.ChunkedArray) -> Array:
    """Return a column as floats, null as NaN."""
    return np.array(column.to_numpy(), dtype=float)
