"""Which histories of the runs are kept, and percentile bands over time, exact to a stated resolution."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep.errors import InputError
from lockstep.system.clock import SAME_TIME
from lockstep.system.unit_table import UNITS
from lockstep.system.units import conversion

from ..runs.loop_monitor import NEEDED
from .metrics import LOOP
from .toml_values import number_of, one_of, refuse_unknown, text_of, whole_of

Kept = Literal["none", "all", "worst", "bands"]
KEPT: tuple[Kept, ...] = get_args(Kept)
PERCENTILES = (1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """A signal whose percentiles over all runs are kept, at each multiple of a period."""

    signal: str  # a history of the loop, or a recorded signal
    period: float  # s
    resolution: float  # SI: values are rounded to its multiples, and their percentiles are exact
    unit: str = ""  # SI, where it is known

    @property
    def record(self) -> tuple[str, ...]:
        """Patterns of the signals that it needs."""
        return NEEDED if self.signal in LOOP else (self.signal,)


@dataclass(frozen=True, slots=True, kw_only=True)
class Histories:
    """What is kept of the histories."""

    kept: Kept = "none"
    worst: int = 0  # runs
    by: str = ""  # metric
    bands: tuple[Band, ...] = ()


def read_histories(about: Mapping[str, Any], bands: Sequence[Any], metrics: Sequence[str], where: str) -> Histories:
    """Return what a campaign file says of histories; InputError for what is wrong."""
    here = f"{where}: campaign"
    kept = one_of(about, "histories", KEPT, here, "none")
    for key in ("worst", "by"):
        if key in about and kept != "worst":
            raise InputError(f'{here}: {key}: has an effect with histories = "worst" only; leave it out')
    if bool(bands) != (kept == "bands"):
        raise InputError(f'{here}: histories: [[band]] tables and histories = "bands" belong together')
    if kept == "worst" and not whole_of(about, "worst", here, 10):
        raise InputError(f'{here}: worst = 0: must be a number of runs; none are kept with histories = "none"')
    return Histories(
        kept=next(one for one in KEPT if one == kept),
        worst=whole_of(about, "worst", here, 10) if kept == "worst" else 0,
        by=one_of(about, "by", metrics, here) if kept == "worst" else "",
        bands=tuple(_band(entry, f"{where}: band {number}") for number, entry in enumerate(bands, start=1)),
    )


def _band(entry: Any, where: str) -> Band:
    if not isinstance(entry, dict):
        raise InputError(f"{where}: must be a table; write [[band]]")
    refuse_unknown(entry, ("signal", "period", "resolution", "unit"), where)
    signal = text_of(entry, "signal", where, "")
    period, resolution = (number_of(entry, key, where) for key in ("period", "resolution"))
    if not signal or period is None or resolution is None or not period > 0.0 or not resolution > 0.0:
        raise InputError(f"{where}: needs signal, period and resolution, both > 0")
    unit = LOOP.get(signal, "")
    shown = text_of(entry, "unit", where, unit)
    if shown and not unit:
        raise InputError(f"{where}: unit = {shown!r}: the resolution of a recorded signal is in that signal's own unit;"
                         " leave it out")  # fmt: skip
    if unit:
        try:
            resolution *= conversion(UNITS[shown], UNITS[unit])[0]
        except (KeyError, ValueError):
            raise InputError(f"{where}: unit = {shown!r}: does not convert to {unit}") from None
    return Band(signal=signal, period=period, resolution=resolution, unit=unit)


def sampled(time: Array, values: Array, band: Band) -> NDArray[np.int64]:
    """Return the values of a run at the multiples of a band's period, in multiples of its resolution.

    Rows at these times are taken; where there is none, the last one before.
    """
    count = int((time[-1] + SAME_TIME) / band.period) + 1
    rows = np.searchsorted(time, np.arange(count) * band.period + SAME_TIME, side="right") - 1
    return np.asarray(np.rint(values[np.maximum(rows, 0)] / band.resolution), dtype=np.int64)


def packed(values: NDArray[np.int64]) -> bytes:
    """Return whole numbers in few bytes: they change little from one to the next."""
    return zlib.compress(np.diff(values, prepend=np.int64(0)).astype("<i8").tobytes(), 9)


def unpacked(content: bytes) -> NDArray[np.int64]:
    """Return the whole numbers that `packed` was given."""
    return np.cumsum(np.frombuffer(zlib.decompress(content), dtype="<i8"), dtype=np.int64)


def percentiles(runs: Sequence[NDArray[np.int64]], band: Band) -> dict[str, Array]:
    """Return least value, percentiles and largest value of all runs at each time, and how many runs reach it.

    A percentile is the smallest value that a run has, and which so large a share of the runs does not exceed.
    """
    count = max(map(len, runs))
    columns: dict[str, list[float]] = {name: [] for name in ("time", "runs", *_names())}
    for k in range(count):
        values = np.sort(np.array([one[k] for one in runs if len(one) > k]))
        places = [max(0, int(np.ceil(share / 100.0 * len(values) - 1e-12)) - 1) for share in PERCENTILES]
        found = [values[0], *(values[place] for place in places), values[-1]]
        columns["time"].append(k * band.period)
        columns["runs"].append(len(values))
        for name, value in zip(_names(), found, strict=True):
            columns[name].append(float(value) * band.resolution)
    return {name: np.array(column) for name, column in columns.items()}


def _names() -> tuple[str, ...]:
    return ("least", *(f"p{one:02g}" for one in PERCENTILES), "largest")
