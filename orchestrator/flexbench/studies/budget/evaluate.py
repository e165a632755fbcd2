"""The pointing budget of a run: every index, per axis, of the line of sight and of the whole angle, at given levels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flexsat.arrays import Array
from lockstep import InputError
from lockstep.system.clock import SAME_TIME

from ...runs import histories
from ...runs.metrics import SETTLED_FROM
from ...runs.run_folder import Run
from . import indices

IndexName = Literal["APE", "MPE", "RPE", "PDE", "PRE"]
INDICES: tuple[IndexName, ...] = ("APE", "MPE", "RPE", "PDE", "PRE")
AxisName = Literal["x", "y", "z", "line_of_sight", "angle"]
# components of the rotation vector whose norm counts; the line of sight is along z
AXES: Mapping[AxisName, tuple[int, ...]] = {
    "x": (0,),
    "y": (1,),
    "z": (2,),
    "line_of_sight": (0, 1),
    "angle": (0, 1, 2),
}
SHORT = 200.0  # s: a shorter run is judged over its second half
LEVELS = (0.95, 0.9973)  # 2 and 3 sigma of a normal error
INTERPRETATION = (
    "Temporal interpretation of ECSS-E-ST-60-10C: the value that the index does not exceed for the share of the"
    " times or windows of one run that the level gives."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexWindows:
    """Times that the indices refer to [s]. Defaults: an exposure, a drift and an observation that 150 s can show."""

    window: float = 10.0  # of the mean: MPE, RPE, PDE, PRE
    separation: float = 60.0  # from the start of one window to that of the other: PDE
    observation: float = 50.0  # PRE

    def __post_init__(self) -> None:
        for name in ("window", "separation", "observation"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{name} {value!r}: must be a time > 0 s")
        if self.observation < self.window:
            raise InputError(
                f"observation {self.observation:g} s: must hold a window of {self.window:g} s; give a longer one"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorHistory:
    """The pointing error from which a budget is computed."""

    error: Array  # (rows, 3) [rad]: rotation vector from reference to attitude, body axes
    interval: float  # s between rows
    start: float  # s, of the run, of the first row

    def samples(self, duration: float, what: str) -> int:
        """Return how many rows a duration [s] is; raise InputError if it is not a whole number of them."""
        count = round(duration / self.interval)
        if count < 1 or abs(count * self.interval - duration) > 1e-6 * self.interval:
            raise InputError(
                f"{what} {duration:g} s: must be a whole multiple of the record period, {self.interval:g} s"
            )
        return count


def since_default(run: Run, time: Array, since: float | None, settled: float | None = None) -> tuple[float, int, float]:
    """Return from when on a run is judged [s], which row that is, and the interval between rows [s].

    None takes `settled`, when the run has settled after its last slew [s]; or, for a run without a slew, 150 s, or half
    of a run that is shorter than 200 s.

    Raises
    ------
    InputError
        If nothing is left of the run.
    """
    if len(time) < 2:
        raise InputError(f"{run.folder}: holds {len(time)} rows; simulate longer")
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    if since is None and settled is not None:
        since = settled
    elif since is None:
        since = SETTLED_FROM if time[-1] >= SHORT - 1.5 * interval else 0.5 * float(time[-1] + interval)
    first = int(np.searchsorted(time, since - SAME_TIME))
    if not since >= 0.0 or len(time) - first < 2:
        raise InputError(f"--from {since:g}: must be a time from 0 s to before the end of the run, {time[-1]:g} s")
    return float(time[first]), first, interval


def steady_error(run: Run, since: float | None = None) -> ErrorHistory:
    """Return the pointing error of a run from `since` [s] on, or as `since_default` says.

    Raises
    ------
    InputError
        If nothing is left of the run, or a signal was not recorded.
    """
    signals = run.loop()
    start, first, interval = since_default(
        run, signals.time, since, None if since is not None else run.steady_since(signals)
    )
    return ErrorHistory(error=histories.pointing_error_vector(signals)[first:], interval=interval, start=start)


def index_values(history: ErrorHistory, index: IndexName, windows: IndexWindows) -> Array:
    """Return every value of an index, (values, 3) [rad]; none where the history is too short for it."""
    if index == "APE":
        return indices.absolute(history.error)
    samples = history.samples(windows.window, "window")
    match index:
        case "MPE":
            return indices.window_means(history.error, samples)
        case "RPE":
            return indices.window_deviations(history.error, samples)
        case "PDE":
            return indices.drifts(history.error, samples, history.samples(windows.separation, "separation"))
        case "PRE":
            observation = history.samples(windows.observation, "observation")
            return indices.reproducibility(history.error, samples, observation)


def sizes(values: Array, axis: AxisName) -> Array:
    """Return the size of an index on an axis, (values,) [rad]."""
    return np.asarray(np.linalg.norm(values[:, AXES[axis]], axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class BudgetEntry:
    """One index on one axis."""

    index: IndexName
    axis: AxisName
    count: int  # of values that it was taken from
    rms: float  # rad
    levels: Mapping[float, float]  # rad, by level

    def sampled_enough(self, level: float) -> bool:
        """Whether the value at a level rests on more than the largest value alone."""
        return self.count * (1.0 - level) >= 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """All indices of one error history. Indices that it is too short for are absent."""

    windows: IndexWindows
    levels: Sequence[float]
    start: float  # s
    duration: float  # s
    entries: Sequence[BudgetEntry]

    def entry(self, index: IndexName, axis: AxisName) -> BudgetEntry | None:
        """Return one entry, None if the run is too short for the index."""
        return next((entry for entry in self.entries if (entry.index, entry.axis) == (index, axis)), None)


def compute_budget(history: ErrorHistory, windows: IndexWindows, levels: Sequence[float] = LEVELS) -> Budget:
    """Return every index on every axis.

    Raises
    ------
    InputError
        If a window is no whole number of samples or a level no share.
    """
    for level in levels:
        if not 0.0 < level < 1.0:
            raise InputError(f"level {level!r}: must be between 0 and 1, for example 0.9973")
    entries = []
    for index in INDICES:
        values = index_values(history, index, windows)
        if not len(values):
            continue
        for axis in AXES:
            size = sizes(values, axis)
            entries.append(
                BudgetEntry(
                    index=index,
                    axis=axis,
                    count=len(size),
                    rms=float(np.sqrt(np.mean(size**2))),
                    levels={level: indices.at_level(size, level) for level in levels},
                )
            )
    duration = len(history.error) * history.interval
    return Budget(windows=windows, levels=tuple(levels), start=history.start, duration=duration, entries=entries)
