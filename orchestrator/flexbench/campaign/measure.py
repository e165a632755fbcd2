"""Measure one run of a campaign: its metrics, the hash of its rows, and its share of the bands."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep import InputError, Signals, read_signals
from lockstep.faults.windows import fault_windows
from lockstep.results.read_run_record import read_run_record
from lockstep.system.clock import SAME_TIME

from ..runs.loop_monitor import means_lost
from ..runs.loop_numbers import QUANTITIES, LoopNumbers, numbers_of, settling_band
from ..runs.loop_signals import LoopSignals, read_loop
from ..runs.run_folder import read_run
from ..studies.budget.evaluate import AXES as AXES_OF_BUDGET
from ..studies.budget.evaluate import INDICES, ErrorHistory, IndexWindows, index_values, sizes, steady_error
from ..studies.budget.indices import at_level
from .histories import Band, packed, sampled
from .metrics import LOOP, MetricSource, share_of

_LOOP = {one.key: one.of for one in QUANTITIES}


@dataclass(frozen=True)
class Measured:
    """A run in its results folder; what metrics share is computed once."""

    folder: Path

    @cached_property
    def record(self) -> Mapping[str, Any]:
        """The content of run.toml."""
        return read_run_record(self.folder)[0]

    @cached_property
    def signals(self) -> Signals:
        """The recorded signals."""
        return read_signals(self.folder)

    @cached_property
    def loop(self) -> LoopSignals:
        """The signals of the loop; InputError for a run without a plant of flexsat."""
        loop = read_loop(self.folder)
        if loop is None:
            raise InputError(
                f"{self.record.get('name', 'system')}: has no plant of flexsat; take metrics of its signals"
            )
        return loop

    @cached_property
    def numbers(self) -> LoopNumbers:
        """The numbers of the loop."""
        faults = [(window.begin, window.end) for window in fault_windows(self.folder)]
        return numbers_of(self.loop, faults, settling_band(self.record))

    @cached_property
    def error(self) -> ErrorHistory:
        """The pointing error that budgets are computed from."""
        return steady_error(read_run(self.folder))

    @property
    def found(self) -> Sequence[Mapping[str, Any]]:
        """What the monitor of the loop found."""
        return tuple(self.record.get("found", ()))

    def history(self, name: str) -> tuple[Array, Array]:
        """Return times [s] and values of a history of the loop, or of a recorded signal; of a vector its norm."""
        if name in LOOP:
            return self.loop.signals.time, _LOOP[name](self.loop.signals)
        values = np.asarray(self.signals[name], dtype=float)
        return self.signals.time, values if values.ndim == 1 else np.asarray(np.linalg.norm(values, axis=1))


def metric(run: Measured, source: MetricSource) -> float | None:
    """Return a metric of a run in SI; None if the run does not have it, infinity for a time that did not come.

    Raises
    ------
    InputError
        If what it is computed from was not recorded.
    """
    match source.of:
        case "settling":
            times = run.numbers.settlings
            return math.inf if not times or times[-1].time is None else times[-1].time
        case "budget":
            return _budget(run.error, source)
        case "event":
            events = [one for one in run.found if one["event"] == source.event]
            return float(sum(one[source.take] for one in events))
        case "lost":
            return float(any(map(means_lost, run.found)))
        case "paper":
            return read_run(run.folder).metrics().get(source.take)
    time, values = run.history(source.of)
    rows = _rows(run, time, source.window)
    return _taken(values[rows], source.take) if np.any(rows) else None


def _rows(run: Measured, time: Array, window: str | tuple[float, float]) -> NDArray[np.bool_]:
    if not isinstance(window, str):
        return np.asarray((time >= window[0] - SAME_TIME) & (time < window[1] + SAME_TIME))
    if window == "all":
        return np.ones(len(time), dtype=bool)
    if window == "steady":
        chosen = None if run.numbers.steady is None else run.numbers.steady.window
    else:
        chosen = next((one.window for one in run.numbers.windows if one.window.name.startswith("slew")), None)
    return np.zeros(len(time), dtype=bool) if chosen is None else chosen.rows(time)


def _taken(values: Array, take: str) -> float:
    match take:
        case "rms":
            return float(np.sqrt(np.mean(values**2)))
        case "mean":
            return float(np.mean(values))
        case "max":
            return float(np.max(values))
        case "min":
            return float(np.min(values))
        case "last":
            return float(values[-1])
    return float(np.quantile(values, share_of(take), method="inverted_cdf"))


def _budget(history: ErrorHistory, source: MetricSource) -> float | None:
    index = next(one for one in INDICES if one == source.index)
    axis = next(one for one in AXES_OF_BUDGET if one == source.axis)
    values = index_values(history, index, source.windows or IndexWindows())
    return float(at_level(sizes(values, axis), source.level)) if len(values) else None


def rows_digest(signals: Signals, names: Sequence[str], times: Array) -> str:
    """Return the hash of the rows of some signals at some times; an empty text if a signal or a row is missing."""
    rows = np.searchsorted(signals.time, times)
    if not set(names) <= set(signals.columns) or np.any(rows >= len(signals.time)):
        return ""
    if not np.array_equal(signals.time[rows], times):
        return ""
    digest = hashlib.sha256(np.ascontiguousarray(times, dtype="<f8").tobytes())
    for name in sorted(names):
        digest.update(name.encode() + b"\0")
        column = np.asarray(signals.columns[name])[rows]
        digest.update(repr(column.tolist()).encode() if column.dtype == object else column.tobytes())
    return digest.hexdigest()


def digest_of_all(signals: Signals) -> str:
    """Return the hash of all rows of all signals."""
    return rows_digest(signals, list(signals.columns), signals.time)


def band_values(run: Measured, bands: Sequence[Band]) -> list[bytes]:
    """Return a run's share of each band."""
    return [packed(sampled(*run.history(one.signal), one)) for one in bands]
