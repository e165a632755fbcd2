"""Read a campaign file, or refuse it in one line that names the table, the key, the value and the remedy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from lockstep.data_text import parse_toml
from lockstep.errors import InputError, suggestion

from .distributions import CASE, Drawn, read_drawn
from .histories import Histories, read_histories
from .metrics import METRIC_KEYS, MetricSource, read_metrics
from .statistics.sample import Metric, MetricRequirement
from .toml_values import flag_of, number_of, one_of, refuse_unknown, text_of, texts_of, whole_of

Sampling = Literal["random", "latin-hypercube", "sobol", "saltelli", "grid", "one-at-a-time", "table"]
Kind = Literal["parameter", "fault", "delay", "command", "system", "spacecraft"]
SAMPLINGS: tuple[Sampling, ...] = get_args(Sampling)
KINDS: tuple[Kind, ...] = get_args(Kind)
COUNTED = ("random", "latin-hypercube", "sobol", "saltelli")  # samplings of as many cases as the file says
_TABLES = ("campaign", "systems", "set", "input", "correlation", "metric", "requirement", "band")
_KEYS = ("name", "seed", "cases", "sampling", "table", "stop_time", "record", "record_period", "faults", "commands",
         "scenario", "histories", "worst", "by", "hang_after", "python", "keep_fmus", "branch_seeds")  # fmt: skip
_REQUIREMENT = ("name", "metric", "most", "least", "unit", "probability", "confidence")
FILE_KEYS = {  # for the reference
    "(tables)": _TABLES,
    "[campaign]": _KEYS,
    "[systems], [set]": ("NAME = file", "component.parameter = value"),
    "[input.NAME]": (*KINDS, "unit", "distribution", "values", "nominal", "round"),
    "[[correlation]]": ("of", "value"),
    **{f'[metric.NAME] with of = "{of}"': ("of", "unit", *keys) for of, keys in METRIC_KEYS.items()},
    "[[requirement]]": _REQUIREMENT,
    "[[band]]": ("signal", "period", "resolution", "unit"),
    "values of sampling": SAMPLINGS,
}
MOST = 10_000_000  # runs; more is a typing error


@dataclass(frozen=True, slots=True, kw_only=True)
class Input:
    """Something that differs between cases."""

    name: str  # of its column
    kind: Kind
    targets: tuple[str, ...]  # component.parameter, fault.key, from:to, row:column, bus.mass; of a system none
    unit: str  # of the values; "": that of what they are given to
    drawn: Drawn


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """What a campaign file says. Paths are absolute."""

    path: Path
    content: bytes
    name: str
    seed: int
    cases: int | None  # None: as many as grid or table have
    sampling: Sampling
    table: Path | None
    stop_time: float | None  # s; None: that of each system
    record: tuple[str, ...]  # patterns of signals beside those that the metrics need
    record_period: float | None  # s
    faults: Path | None
    commands: Path | None  # a CSV file of inputs over time
    scenario: str  # of spacecraft files among the systems
    systems: Mapping[str, Path]  # empty: an input of kind system draws them
    settings: Mapping[str, Any]  # parameters of all runs
    inputs: tuple[Input, ...]
    correlations: Mapping[tuple[str, str], float]
    metrics: tuple[Metric, ...]
    sources: Mapping[str, MetricSource]  # of each metric
    requirements: tuple[MetricRequirement, ...]
    histories: Histories
    hang_after: float = 60.0  # s of wall time without progress
    python: bool = False  # the FMUs of the system files, even if there are native ones beside them
    keep_fmus: bool = True  # between runs, where they can be reset
    branch_seeds: tuple[str, ...] = ()  # component.parameter: seeds that get new values where a run is branched


def read_campaign(path: Path) -> Campaign:
    """Read a campaign file.

    Raises
    ------
    InputError
        If it cannot be read, or anything in it is wrong.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a campaign file") from None
    tables = parse_toml(content, str(path))
    where = path.name
    refuse_unknown(tables, _TABLES, where)
    about = _table(tables, "campaign", where)
    refuse_unknown(about, _KEYS, f"{where}: campaign")
    inputs = tuple(_input(name, entry, path) for name, entry in _table(tables, "input", where).items())
    metrics, sources = read_metrics(_table(tables, "metric", where), where)
    names = [one.name for one in metrics]
    sampling = one_of(about, "sampling", SAMPLINGS, f"{where}: campaign", "random")
    campaign = Campaign(
        path=path.absolute(),
        content=content,
        name=text_of(about, "name", f"{where}: campaign", path.stem),
        seed=whole_of(about, "seed", f"{where}: campaign", 1),
        cases=whole_of(about, "cases", f"{where}: campaign", 0) or None,
        sampling=next(one for one in SAMPLINGS if one == sampling),
        table=_path(about, "table", path),
        stop_time=_positive(about, "stop_time", f"{where}: campaign"),
        record=texts_of(about, "record", f"{where}: campaign"),
        record_period=_positive(about, "record_period", f"{where}: campaign"),
        faults=_path(about, "faults", path),
        commands=_path(about, "commands", path),
        scenario=text_of(about, "scenario", f"{where}: campaign", "fine_pointing"),
        systems={name: _system(name, value, path) for name, value in _table(tables, "systems", where).items()},
        settings=_table(tables, "set", where),
        inputs=inputs,
        correlations=_correlations(tables.get("correlation", []), [one.name for one in inputs], where),
        metrics=metrics,
        sources=sources,
        requirements=tuple(_requirement(entry, metrics, f"{where}: requirement {number}")
                           for number, entry in enumerate(_list(tables, "requirement", where), start=1)),
        histories=read_histories(about, _list(tables, "band", where), names, where),
        hang_after=_positive(about, "hang_after", f"{where}: campaign") or 60.0,
        python=flag_of(about, "python", f"{where}: campaign", False),
        keep_fmus=flag_of(about, "keep_fmus", f"{where}: campaign", True),
        branch_seeds=texts_of(about, "branch_seeds", f"{where}: campaign"),
    )  # fmt: skip
    _check(campaign, where)
    _check_idle(campaign, about, where)
    return campaign


def is_spacecraft(path: Path) -> bool:
    """Return whether a system is given by a spacecraft's file, whose FMUs are built first."""
    return path.suffix == ".toml"


def _check_targets(campaign: Campaign, where: str) -> None:
    """Refuse a value that is given twice: one of both would be without effect."""
    given = {("parameter", name): f"[set] {name}" for name in campaign.settings}
    for one in campaign.inputs:
        for target in one.targets:
            if earlier := given.get((one.kind, target)):
                raise InputError(f"{where}: input.{one.name}: {target} is given by {earlier} too; leave one out")
            given[one.kind, target] = f"input.{one.name}"


def _check_idle(campaign: Campaign, about: Mapping[str, Any], where: str) -> None:
    """Refuse keys of [campaign], and correlations, that have no effect beside the others."""
    drawn = (Path(str(path)) for one in campaign.inputs if one.kind == "system" for path in one.drawn.values)
    idle = {
        "scenario": not any(map(is_spacecraft, (*campaign.systems.values(), *drawn)))
        and "it chooses among the systems that are built of spacecraft files, and there is none",
        "record": any(one.of == "paper" for one in campaign.sources.values())
        and 'beside a metric of = "paper" all is recorded that the system file says',
    }
    for key, reason in idle.items():
        if key in about and reason:
            raise InputError(f"{where}: campaign: {key}: has no effect: {reason}; leave it out")
    if campaign.correlations and campaign.sampling not in COUNTED:
        raise InputError(f"{where}: correlation: sampling = {campaign.sampling!r} draws nothing; leave it out")
    for one in campaign.inputs:
        if one.drawn.distribution == CASE and any(one.name in pair for pair in campaign.correlations):
            raise InputError(f"{where}: correlation: {one.name} is the number of the case, and not drawn; leave it out")


def _check(campaign: Campaign, where: str) -> None:
    systems = [one for one in campaign.inputs if one.kind == "system"]
    if not campaign.metrics:
        raise InputError(f"{where}: has no metric; write a [metric.NAME] table for each number that a run is to give")
    if bool(campaign.systems) == bool(systems) or len(systems) > 1:
        raise InputError(f"{where}: systems: write either [systems] with one or more files, or one input with"
                         ' system = ["a.ssd", "b.ssd"]')  # fmt: skip
    if systems and (fields := [one.name for one in campaign.inputs if one.kind == "spacecraft"]):
        raise InputError(f"{where}: input.{fields[0]}: changes the spacecraft files under [systems]; leave out"
                         f" input.{systems[0].name}")  # fmt: skip
    _check_targets(campaign, where)
    if (campaign.cases is None) == (campaign.sampling in COUNTED):
        what = "missing; give how many" if campaign.cases is None else f"{campaign.cases}: leave it out"
        raise InputError(f"{where}: campaign: cases: {what}, with sampling = {campaign.sampling!r}")
    if (campaign.table is None) == (campaign.sampling == "table"):
        raise InputError(f'{where}: campaign: table: belongs to sampling = "table", and that needs it')
    doubled = campaign.sampling in ("sobol", "saltelli")
    if doubled and campaign.cases is not None and campaign.cases & (campaign.cases - 1):
        raise InputError(f"{where}: campaign: cases = {campaign.cases}: Sobol sequences need a power of 2, such as"
                         f" {2 ** (campaign.cases - 1).bit_length()}")  # fmt: skip
    if (campaign.cases or 1) * max(1, len(campaign.systems)) > MOST:
        raise InputError(f"{where}: campaign: cases = {campaign.cases}: more than {MOST} runs")
    if campaign.sampling == "saltelli" and campaign.correlations:
        raise InputError(f"{where}: correlation: Sobol indices are those of independent inputs; leave it out")
    for one in campaign.inputs:
        one.drawn.check(campaign.sampling, f"{where}: input.{one.name}")
    for file, kind in ((campaign.faults, "fault"), (campaign.commands, "command")):
        if file is None and any(one.kind == kind and one.targets for one in campaign.inputs):
            raise InputError(f"{where}: campaign: {kind}s: missing; an input changes that file, so name it")


def _input(name: str, entry: Any, path: Path) -> Input:
    where = f"{path.name}: input.{name}"
    if not isinstance(entry, dict):
        raise InputError(f"{where}: must be a table, got {entry!r}")
    kinds = [kind for kind in KINDS if kind in entry]
    if len(kinds) != 1:
        raise InputError(f"{where}: write one of {', '.join(KINDS)}, for example parameter = 'plant.seed'")
    (kind,) = kinds
    rest = {key: value for key, value in entry.items() if key not in (kind, "unit")}
    targets = texts_of(entry, kind, where)
    if kind == "system":
        if rest:
            raise InputError(f"{where}: {next(iter(rest))}: a system is chosen from its list; leave it out")
        rest, targets = {"values": [str(_system(name, one, path)) for one in targets]}, ()
    elif not targets:
        raise InputError(f"{where}: {kind} = []: name what it gives values to")
    unit = text_of(entry, "unit", where, "")
    if unit and kind not in ("parameter", "spacecraft"):
        raise InputError(f"{where}: unit = {unit!r}: values of a {kind} are in the unit of its file; leave it out")
    return Input(name=name, kind=kind, targets=targets, unit=unit, drawn=read_drawn(rest, where))


def _correlations(entries: Any, names: Sequence[str], where: str) -> dict[tuple[str, str], float]:
    found: dict[tuple[str, str], float] = {}
    for number, entry in enumerate(entries if isinstance(entries, list) else [entries], start=1):
        here = f"{where}: correlation {number}"
        if not isinstance(entry, dict):
            raise InputError(f"{here}: must be a table; write [[correlation]]")
        refuse_unknown(entry, ("of", "value"), here)
        pair, value = entry.get("of"), number_of(entry, "value", here)
        if not isinstance(pair, list) or len(pair) != 2 or pair[0] == pair[1]:
            raise InputError(f"{here}: of = {pair!r}: must be the names of two inputs")
        for name in pair:
            if name not in names:
                raise InputError(
                    f"{here}: {name}: no such input; there are {', '.join(names)}{suggestion(name, names)}"
                )
        if value is None or not -1.0 < value < 1.0:
            raise InputError(f"{here}: value = {value!r}: must be between -1 and 1")
        if found.setdefault((min(pair), max(pair)), value) != value:
            raise InputError(f"{here}: {pair[0]} and {pair[1]} have another correlation above; leave one out")
    return found


def _requirement(entry: Any, metrics: Sequence[Metric], where: str) -> MetricRequirement:
    if not isinstance(entry, dict):
        raise InputError(f"{where}: must be a table; write [[requirement]]")
    refuse_unknown(entry, _REQUIREMENT, where)
    known = {one.name: one for one in metrics}
    metric = known[one_of(entry, "metric", list(known), where)]
    limits = {key: number_of(entry, key, where) for key in ("most", "least")}
    if all(value is None for value in limits.values()):
        raise InputError(f"{where}: most: missing; give most or least")
    unit = text_of(entry, "unit", where, metric.shown_unit)
    if unit not in (metric.unit, metric.shown_unit):
        raise InputError(f"{where}: unit = {unit!r}: must be {metric.shown_unit}, as in metric.{metric.name}")
    scale = metric.scale if unit == metric.shown_unit else 1.0
    shares = {key: number_of(entry, key, where) for key in ("probability", "confidence")}
    for key, value in shares.items():
        if value is not None and not 0.0 < value < 1.0:
            raise InputError(f"{where}: {key} = {value!r}: must be between 0 and 1")
    return MetricRequirement(
        name=text_of(entry, "name", where, metric.name),
        metric=metric.name,
        most=None if limits["most"] is None else limits["most"] * scale,
        least=None if limits["least"] is None else limits["least"] * scale,
        probability=shares["probability"],
        **({} if shares["confidence"] is None else {"confidence": shares["confidence"]}),
    )


def _table(tables: Mapping[str, Any], name: str, where: str) -> dict[str, Any]:
    value = tables.get(name, {})
    if not isinstance(value, dict):
        raise InputError(f"{where}: {name}: must be a table; write [{name}]")
    return value


def _list(tables: Mapping[str, Any], name: str, where: str) -> list[Any]:
    value = tables.get(name, [])
    if not isinstance(value, list):
        raise InputError(f"{where}: {name}: must be a list of tables; write [[{name}]]")
    return value


def _path(table: Mapping[str, Any], key: str, path: Path) -> Path | None:
    value = text_of(table, key, f"{path.name}: campaign", "")
    return (path.parent / value).absolute() if value else None


def _system(name: str, value: Any, path: Path) -> Path:
    if not isinstance(value, str):
        raise InputError(f"{path.name}: systems: {name} = {value!r}: must be the path of a system or spacecraft file")
    return (path.parent / value).absolute()


def _positive(table: Mapping[str, Any], key: str, where: str) -> float | None:
    value = number_of(table, key, where)
    if value is not None and not value > 0.0:
        raise InputError(f"{where}: {key} = {value!r}: must be a time > 0 s")
    return value
