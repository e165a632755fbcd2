"""The metrics of a campaign file: what of a run a number is taken from, how, and in which unit it is shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

from lockstep.errors import InputError
from lockstep.system.unit_table import UNITS
from lockstep.system.units import conversion

from ..runs.loop_monitor import KINDS, NEEDED
from ..studies.budget.evaluate import AXES, INDICES, IndexWindows
from ..studies.budget.requirements import LEVEL, TIMES, Time
from .toml_values import number_of, one_of, refuse_unknown, text_of

if TYPE_CHECKING:
    from .statistics.sample import Metric

LOOP = {"pointing_error": "rad", "rate_error": "rad/s", "deformation": "m", "torque": "N.m", "wheel_torque": "N.m"}
EVENTS = tuple(KINDS)
PAPER = ("total_cost", "control_cost")
TAKES = ("rms", "mean", "max", "min", "last")
WINDOWS = ("all", "steady", "slew")
_OTHER = ("settling", "budget", "event", "lost", "paper")
_KEYS = {
    "settling": (),
    "budget": ("index", "axis", "level", *get_args(Time)),
    "event": ("event", "take"),
    "lost": (),
    "paper": ("take",),
}
_HISTORY = ("take", "window")
METRIC_KEYS = {"a signal": _HISTORY, **_KEYS}  # beside `of` and `unit`


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricSource:
    """Where a metric comes from."""

    of: str  # a history of the loop, settling, budget, event, lost, paper, or a recorded signal
    take: str = "rms"  # of a history; of an event: count or seconds; of paper: which cost
    window: str | tuple[float, float] = "all"  # s
    event: str = ""
    index: str = ""
    axis: str = ""
    level: float = LEVEL
    windows: IndexWindows | None = None

    @property
    def of_signal(self) -> bool:
        """Whether it is that of a recorded signal."""
        return self.of not in LOOP and self.of not in _OTHER

    @property
    def record(self) -> tuple[str, ...]:
        """Patterns of the signals that it needs; of the paper's costs those of the system file."""
        return (self.of,) if self.of_signal else NEEDED

    @property
    def text(self) -> str:
        """The metric in words."""
        match self.of:
            case "settling":
                return "settling time"
            case "budget":
                return f"{self.index} of {self.axis} at {100.0 * self.level:g} %"
            case "event":
                return f"{KINDS[self.event]}, {self.take}"
            case "lost":
                return "1 for a lost loop"
            case "paper":
                return self.take.replace("_", " ")
        span = self.window if isinstance(self.window, str) else f"{self.window[0]:g} to {self.window[1]:g} s"
        return f"{self.take} of {self.of}, {span}"


def read_metrics(tables: Mapping[str, Any], where: str) -> tuple[tuple[Metric, ...], dict[str, MetricSource]]:
    """Return the metrics of a campaign file and where each comes from; InputError for what is wrong."""
    from .statistics.sample import Metric  # imports scipy.stats, which no worker needs

    metrics, sources = [], {}
    for name, entry in tables.items():
        here = f"{where}: metric.{name}"
        if not isinstance(entry, dict):
            raise InputError(f"{here}: must be a table, got {entry!r}")
        source = _source(entry, here)
        unit = _unit_of(source)
        shown = text_of(entry, "unit", here, unit)
        scale = 1.0 if source.of_signal else _scale(shown, unit, here)
        sources[name] = source
        metrics.append(Metric(name=name, unit=shown if source.of_signal else unit, shown_unit=shown, scale=scale))
    return tuple(metrics), sources


def _source(entry: Mapping[str, Any], where: str) -> MetricSource:
    of = text_of(entry, "of", where, "")
    if not of:
        raise InputError(f"{where}: of: missing; give {', '.join((*LOOP, *_OTHER))}, or a recorded signal")
    refuse_unknown(entry, ("of", "unit", *_KEYS.get(of, _HISTORY)), where)
    match of:
        case "settling" | "lost":
            return MetricSource(of=of)
        case "paper":
            return MetricSource(of=of, take=one_of(entry, "take", PAPER, where))
        case "event":
            event = one_of(entry, "event", EVENTS, where)
            return MetricSource(of=of, event=event, take=one_of(entry, "take", ("count", "seconds"), where, "seconds"))
        case "budget":
            return _of_budget(entry, where)
    take = text_of(entry, "take", where, "rms")
    if take not in TAKES and not _percentile(take):
        raise InputError(f"{where}: take = {take!r}: must be {', '.join(TAKES)}, or a percentile such as p95")
    return MetricSource(of=of, take=take, window=_window(entry.get("window", "all"), where))


def _of_budget(entry: Mapping[str, Any], where: str) -> MetricSource:
    index = one_of(entry, "index", INDICES, where, "APE")
    level = number_of(entry, "level", where, LEVEL) or 0.0
    if not 0.0 < level < 1.0:
        raise InputError(f"{where}: level = {level!r}: must be between 0 and 1, for example {LEVEL}")
    times = {key: value for key in get_args(Time) if (value := number_of(entry, key, where)) is not None}
    for key, value in times.items():
        if key not in TIMES[next(one for one in INDICES if one == index)]:
            raise InputError(f"{where}: {key} = {value:g}: {index} has none; leave it out")
    if "window" in times and "observation" not in times:
        times["observation"] = max(times["window"], IndexWindows().observation)
    axis = one_of(entry, "axis", tuple(AXES), where, "line_of_sight")
    try:
        windows = IndexWindows(**times)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    return MetricSource(of="budget", index=index, axis=axis, level=level, windows=windows)


def _window(value: Any, where: str) -> str | tuple[float, float]:
    if isinstance(value, str) and value in WINDOWS:
        return value
    if isinstance(value, list) and len(value) == 2 and all(isinstance(one, int | float) for one in value):
        begin, end = map(float, value)
        if 0.0 <= begin < end:
            return begin, end
    raise InputError(f"{where}: window = {value!r}: must be {', '.join(WINDOWS)}, or [from, to] in seconds")


def _percentile(take: str) -> float | None:
    """Return the share of a take such as p95; None for another."""
    try:
        share = float(take.removeprefix("p")) / 100.0
    except ValueError:
        return None
    return share if take.startswith("p") and 0.0 < share < 1.0 else None


def share_of(take: str) -> float:
    """Return the share of a take that is a percentile."""
    share = _percentile(take)
    assert share is not None
    return share


def _unit_of(source: MetricSource) -> str:
    """Return the SI unit of a metric; of a signal "", as its FMU knows it."""
    match source.of:
        case "settling":
            return "s"
        case "budget":
            return "rad"
        case "event":
            return "s" if source.take == "seconds" else "1"
        case "lost" | "paper":
            return "1"
    return LOOP.get(source.of, "")


def _scale(shown: str, unit: str, where: str) -> float:
    if shown not in UNITS:
        raise InputError(f"{where}: unit = {shown!r}: no such unit; give {unit} or one that converts to it")
    try:
        return conversion(UNITS[shown], UNITS[unit])[0]
    except ValueError as error:
        raise InputError(f"{where}: unit = {shown!r}: {error}; give {unit} or one that converts to it") from None
