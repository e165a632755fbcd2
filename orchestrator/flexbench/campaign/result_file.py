"""The files of a campaign's results: written from its journals, the same bytes whatever happened on the way."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep.errors import InputError
from lockstep.whole_file import write_whole

from ..runs.json_file import read_json
from .distributions import Value
from .statistics.sample import Metric, MetricRequirement

ABOUT, RESULTS, TIMINGS, BANDS = "campaign.json", "results.parquet", "timings.parquet", "bands.parquet"
INPUT, METRIC = "input.", "metric."


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRow:
    """One run: what it was given, and what it came to."""

    number: int
    case: int
    system: str
    inputs: Mapping[str, Value]
    metrics: Mapping[str, float | None]
    failure: str = ""  # "": it is completed
    cause: str = ""
    simulated_time: float | None = None
    rows_sha256: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """The results of a campaign, a run an element, by number."""

    about: Mapping[str, Any]  # campaign.json
    numbers: NDArray[np.int64]
    cases: NDArray[np.int64]
    systems: Sequence[str]
    inputs: Mapping[str, Sequence[Value]]
    metrics: Mapping[str, Array]  # SI; NaN: none
    failures: Sequence[str]
    causes: Sequence[str]

    @property
    def completed(self) -> NDArray[np.bool_]:
        """Which runs are completed."""
        return np.array([not one for one in self.failures], dtype=bool)

    def metric_list(self) -> tuple[Metric, ...]:
        """Return what the metrics are."""
        keys = ("name", "unit", "shown_unit", "scale")
        return tuple(Metric(**{key: one[key] for key in keys}) for one in self.about["metrics"])

    def requirement_list(self) -> tuple[MetricRequirement, ...]:
        """Return the requirements, in SI."""
        return tuple(MetricRequirement(**one) for one in self.about["requirements"])


def results_of(rows: Sequence[RunRow], about: Mapping[str, Any]) -> Results:
    """Return rows as columns."""
    inputs = [one["name"] for one in about["inputs"]]
    metrics = [one["name"] for one in about["metrics"]]
    return Results(
        about=about,
        numbers=np.array([row.number for row in rows], dtype=np.int64),
        cases=np.array([row.case for row in rows], dtype=np.int64),
        systems=[row.system for row in rows],
        inputs={name: [row.inputs[name] for row in rows] for name in inputs},
        metrics={name: np.array([_number(row.metrics.get(name)) for row in rows]) for name in metrics},
        failures=[row.failure for row in rows],
        causes=[row.cause for row in rows],
    )


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def write_results(folder: Path, rows: Sequence[RunRow], about: Mapping[str, Any]) -> Path:
    """Write results.parquet and return its path."""
    fields: list[tuple[pa.Field, list[Any]]] = [
        (pa.field("number", pa.int64()), [row.number for row in rows]),
        (pa.field("case", pa.int64()), [row.case for row in rows]),
        (pa.field("system", pa.string()), [row.system for row in rows]),
    ]
    for one in about["inputs"]:
        values = [row.inputs[one["name"]] for row in rows]
        texts = any(isinstance(value, str) for value in values)
        kind = pa.string() if texts else pa.float64()
        converted = [str(value) if texts else float(value) for value in values]
        fields.append((_field(INPUT + one["name"], kind, one["unit"]), converted))
    for one in about["metrics"]:
        numbers = [row.metrics.get(one["name"]) for row in rows]
        fields.append((_field(METRIC + one["name"], pa.float64(), one["unit"]), numbers))
    fields += [
        (pa.field("status", pa.string()), ["failed" if row.failure else "completed" for row in rows]),
        (pa.field("failure", pa.string()), [row.failure for row in rows]),
        (pa.field("cause", pa.string()), [row.cause for row in rows]),
        (pa.field("simulated_time", pa.float64()), [row.simulated_time for row in rows]),
        (pa.field("rows_sha256", pa.string()), [row.rows_sha256 for row in rows]),
    ]
    return write_table(folder / RESULTS, fields)


def write_table(path: Path, fields: Sequence[tuple[pa.Field, Sequence[Any]]]) -> Path:
    """Write a Parquet file; the same values give the same bytes."""
    arrays = [pa.array(values, type=field.type) for field, values in fields]
    table = pa.Table.from_arrays(arrays, schema=pa.schema([field for field, _ in fields]))
    content = io.BytesIO()
    pq.write_table(table, content, compression="zstd")
    write_whole(path, content.getvalue())
    return path


def _field(name: str, kind: pa.DataType, unit: str) -> pa.Field:
    return pa.field(name, kind, metadata={"unit": unit} if unit else None)


def read_results(folder: Path) -> Results:
    """Read the results of a campaign; InputError if it is not finished, or the folder holds none."""
    about = read_about(folder)
    path = folder / RESULTS
    if not path.is_file():
        raise InputError(f"{folder}: its campaign is not finished; go on with `flexsat campaign {about['path']} --out"
                         f" {folder}`")  # fmt: skip
    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise InputError(f"{path}: cannot be read ({error}); delete it and run the campaign again") from None
    columns = {name: table.column(name).to_pylist() for name in table.column_names}
    inputs = [name.removeprefix(INPUT) for name in columns if name.startswith(INPUT)]
    metrics = [name.removeprefix(METRIC) for name in columns if name.startswith(METRIC)]
    return Results(
        about=about,
        numbers=np.array(columns["number"], dtype=np.int64),
        cases=np.array(columns["case"], dtype=np.int64),
        systems=columns["system"],
        inputs={name: columns[INPUT + name] for name in inputs},
        metrics={name: np.array([_number(one) for one in columns[METRIC + name]]) for name in metrics},
        failures=columns["failure"],
        causes=columns["cause"],
    )


def read_about(folder: Path) -> dict[str, Any]:
    """Return what campaign.json of a folder says; InputError if there is none."""
    about = read_json(folder / ABOUT)
    if not isinstance(about, dict) or "identity" not in about:
        raise InputError(f"{folder}: holds no campaign; give the folder of --out")
    return about
