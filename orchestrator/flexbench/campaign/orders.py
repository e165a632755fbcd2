"""Make of each number of a campaign the order of one run: parameters, faults, delays, commands, system."""

from __future__ import annotations

import csv
import io
import pickle
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lockstep import load_system
from lockstep.data_text import parse_toml
from lockstep.errors import InputError, suggestion
from lockstep.plan.plan import Plan
from lockstep.results.run_record import to_toml
from lockstep.system.system import System

from ..engine.content import File, put
from ..engine.fingerprint import files_of, of_system
from ..loop.fmu_choice import PrintLine, choose_fmus
from .campaign_file import Campaign, Input, is_spacecraft
from .distributions import Value, with_unit
from .order import Order, Wanted, moved_files, with_delays
from .sampling import Case, draw
from .signal_units import check_signal_units

DRAWN = "drawn"  # name of the systems of a campaign whose cases draw one each
_TICKS = "FROM:TO, for example sensors:controller"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stored:
    """A system in the store: the system itself with files by name, and its files."""

    system: File
    files: tuple[File, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Orders:
    """All runs of a campaign by number, from 1."""

    campaign: Campaign
    cases: Sequence[Case]
    systems: Mapping[str, Stored]  # by name; or, where cases draw one, by path
    texts: Mapping[str, Any]  # what each system is, as plain values
    wanted: Wanted
    builds: Sequence[
        Mapping[str, str]
    ] = ()  # of each case whose spacecraft files are its own: key in `systems`, by name

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the systems that each case is simulated with."""
        return tuple(self.campaign.systems) or (DRAWN,)

    def __len__(self) -> int:
        return len(self.cases) * len(self.names)

    def case_of(self, number: int) -> tuple[int, str]:
        """Return the number of the case of a run, from 1, and the name of its system."""
        case, system = divmod(number - 1, len(self.names))
        return case + 1, self.names[system]

    def files_of(self, number: int) -> tuple[File, ...]:
        """Return the files that a run needs."""
        stored = self._stored(number)
        return (stored.system, *stored.files)

    def order(self, number: int) -> Order:
        """Return the order of a run; InputError if a value does not fit what it is given to."""
        if not 1 <= number <= len(self):
            raise InputError(f"{number}: no such run; the campaign has 1 to {len(self)}")
        case, _ = self.case_of(number)
        values = self.cases[case - 1]
        campaign = self.campaign
        chosen = {kind: [one for one in campaign.inputs if one.kind == kind] for kind in ("fault", "command", "delay")}
        overrides = dict(campaign.settings)
        for one in campaign.inputs:
            if one.kind == "parameter":
                overrides |= dict.fromkeys(one.targets, with_unit(values[one.name], one.unit))
        return Order(
            number=number,
            system=self._stored(number).system,
            overrides=overrides,
            delays={_ends(target): _ticks(values[one.name], one) for one in chosen["delay"] for target in one.targets},
            faults=_faults(campaign, chosen["fault"], values),
            commands=_commands(campaign, chosen["command"], values),
            wanted=self.wanted,
        )

    def _stored(self, number: int) -> Stored:
        case, name = self.case_of(number)
        if self.builds:
            return self.systems[self.builds[case - 1][name]]
        if name in self.systems:
            return self.systems[name]
        drawn = next(one.name for one in self.campaign.inputs if one.kind == "system")
        return self.systems[str(self.cases[case - 1][drawn])]


def prepare(campaign: Campaign, folder: Path, report: PrintLine) -> Orders:
    """Draw all cases, load the systems, and copy their files to the store in a folder.

    Raises
    ------
    InputError
        If a system, a name or a value is refused; the first case is planned with every system.
    """
    cases = draw(campaign)
    drawn = next((one for one in campaign.inputs if one.kind == "system"), None)
    keys: Sequence[Mapping[str, str]] = ()
    paths = dict(campaign.systems) if drawn is None else {str(one): Path(str(one)) for one in drawn.drawn.values}
    if any(one.kind == "spacecraft" for one in campaign.inputs) or any(is_spacecraft(path) for path in paths.values()):
        from .spacecraft_builds import build_spacecraft

        keys, paths = build_spacecraft(campaign, cases, paths, folder, report)
    first = tuple(keys[0].values()) if keys else tuple(paths)
    loaded = {name: load_system(path) for name, path in paths.items()}
    check_signal_units(campaign.metrics, campaign.sources, [loaded[name] for name in first], campaign.path.name)
    chosen = choose_fmus(list(loaded.values()), campaign.python)
    report(chosen.text)
    systems = {name: chosen.of(system) for name, system in loaded.items()}
    store = folder / "files"
    orders = Orders(
        campaign=campaign,
        cases=cases,
        systems={name: _store(system, store) for name, system in systems.items()},
        texts={name: of_system(system) for name, system in systems.items()},
        wanted=Wanted(
            stop_time=campaign.stop_time,
            record=_record(campaign),
            record_period=campaign.record_period,
            sources=campaign.sources,
            histories=campaign.histories,
            keep_fmus=campaign.keep_fmus,
        ),
        builds=keys,
    )
    _plan_first(orders, {name: systems[name] for name in first}, drawn)
    return orders


def _record(campaign: Campaign) -> tuple[str, ...] | None:
    """Return what is recorded: what metrics and bands need; all that the system file says for the paper's costs."""
    if any(source.of == "paper" for source in campaign.sources.values()):
        return None
    needed = [*(source.record for source in campaign.sources.values()),
              *(band.record for band in campaign.histories.bands), campaign.record]  # fmt: skip
    return tuple(dict.fromkeys(name for names in needed for name in names))


def _plan_first(orders: Orders, systems: Mapping[str, System], drawn: Input | None) -> None:
    """Plan the first case with every system, which checks all names and the values of that case."""
    order = orders.order(1)
    wanted = orders.wanted
    for name, system in systems.items():
        try:
            Plan(with_delays(system, order), wanted.stop_time, dict(order.overrides), wanted.record,
                 wanted.record_period)  # fmt: skip
        except InputError as error:
            where = Path(name).name if drawn else f"systems.{name}"
            raise InputError(f"{orders.campaign.path.name}: {where}: {error}") from None


def _store(system: System, store: Path) -> Stored:
    files = {path: put(path, store) for path in sorted(files_of(system))}
    moved = moved_files(system, {path: Path(file.name) for path, file in files.items()})
    store.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=store) as folder:
        path = Path(folder, "system.pickle")
        path.write_bytes(pickle.dumps(moved, protocol=5))
        kept = put(path, store)
    return Stored(system=kept, files=tuple(sorted(files.values())))


def _ends(target: str) -> tuple[str, str]:
    start, colon, end = target.partition(":")
    if not (start and colon and end):
        raise InputError(f"delay = {target!r}: write {_TICKS}")
    return start, end


def _ticks(value: Value, one: Input) -> int:
    if isinstance(value, bool | str) or value < 0 or value != int(value):
        raise InputError(f"input.{one.name}: {value!r}: a delay is a whole number of ticks; set round = true")
    return int(value)


def _faults(campaign: Campaign, inputs: Sequence[Input], values: Case) -> str:
    """Return the scenario file with the values of a case; it is unchanged where no input concerns it."""
    if campaign.faults is None:
        return ""
    text = _read(campaign.faults)
    tables = parse_toml(text.encode(), str(campaign.faults))
    entries = tables.get("fault", [])
    for one in inputs:
        for target in one.targets:
            name, _, key = target.rpartition(".")
            found = [entry for entry in entries if isinstance(entry, dict) and entry.get("name") == name]
            if len(found) != 1:
                known = [str(entry.get("name")) for entry in entries if isinstance(entry, dict)]
                raise InputError(f"input.{one.name}: fault = {target!r}: {campaign.faults.name} has no fault {name!r};"
                                 f" there are {', '.join(known)}{suggestion(name, known)}")  # fmt: skip
            found[0][key] = values[one.name]
    return to_toml(tables) if inputs else text


def _commands(campaign: Campaign, inputs: Sequence[Input], values: Case) -> str:
    """Return the file of inputs over time with the values of a case."""
    if campaign.commands is None:
        return ""
    text = _read(campaign.commands)
    rows = list(csv.reader(io.StringIO(text)))
    for one in inputs:
        for target in one.targets:
            row, _, column = target.partition(":")
            names = [name.split("[unit")[0].strip() for name in rows[0]]
            if not row.isdecimal() or not 1 <= int(row) < len(rows) or column not in names:
                raise InputError(f"input.{one.name}: command = {target!r}: write ROW:COLUMN; {campaign.commands.name}"
                                 f" has rows 1 to {len(rows) - 1}, columns {', '.join(names)}")  # fmt: skip
            rows[int(row)][names.index(column)] = repr(values[one.name])
    if not inputs:
        return text
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error})") from None
