"""Run a campaign in a folder, or go on with it: journal each run, keep histories, merge the results."""

from __future__ import annotations

import base64
import math
import pickle
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import pyarrow as pa

from lockstep.errors import InputError, RunError
from lockstep.results.results_folder import claim_shared
from lockstep.whole_file import write_whole

from ..engine.dispatch import dispatch
from ..engine.fingerprint import code, fingerprint
from ..engine.pools import LocalPool, Pool, settings_of
from ..engine.tasks import Task, TaskOutcome, TaskSettings
from ..loop.fmu_choice import PrintLine
from ..runs.json_file import read_json, write_json
from .campaign_file import read_campaign
from .flight import Flown, fly, unpack
from .histories import Histories, percentiles, unpacked
from .journal import Journals, entries
from .orders import Orders, prepare
from .progress import Counter, shown
from .result_file import ABOUT, BANDS, TIMINGS, Results, RunRow, results_of, write_results, write_table

FILE, ORDERS, RUNS = "campaign.toml", "orders.pickle", "runs"
BLOCK = 50  # runs between two looks at whether the campaign is to end
MakePool = Callable[[TaskSettings], Pool]
Until = Callable[[Results], bool]  # of the first so many runs, whether they are enough
Entry = Mapping[str, Any]  # of a journal


@dataclass(frozen=True, slots=True, kw_only=True)
class Done:
    """A campaign that has ended."""

    folder: Path
    results: Results
    stopped: bool = False  # before its last run, as the first ones were enough


def run_campaign(
    path: Path,
    folder: Path,
    make_pool: MakePool = LocalPool,
    report: PrintLine = print,
    until: Until | None = None,
) -> Done:
    """Run all runs of a campaign file that the folder does not hold yet, and write its results.

    Parameters
    ----------
    path : campaign file
    folder : for journals and results; one that holds a part of this campaign already is completed
    make_pool : returns what carries out the runs: processes of this machine, one a core, if nothing else is given
    report : called with lines of text
    until : called after every 50 runs with all so far; with True the campaign ends, without any run after them

    Raises
    ------
    InputError
        If anything in the file is wrong, or the folder holds another campaign.
    RunError
        If a disk is full, or a cluster is lost. The same call goes on then.
    KeyboardInterrupt
        After Ctrl-C or SIGTERM, in order. The same call goes on then.
    """
    campaign = read_campaign(path)
    with claim_shared(folder):
        known = read_json(folder / ABOUT)
        orders = prepare(campaign, folder, report)
        about = describe(orders)
        _same(known, about, folder)
        if known is None:
            write_whole(folder / FILE, campaign.content)
            write_whole(folder / ORDERS, pickled(orders))
            write_json(folder / ABOUT, about)
        pool = make_pool(settings_of(campaign.hang_after, folder / "files"))
        try:
            report(f"{campaign.name}: {len(orders)} runs, {pool.text}")
            with closing(Journals(folder)) as journals:
                count = _fly_all(orders, folder, pool, journals, about, until)
        except BaseException:
            pool.end()
            raise
        finally:
            pool.close()
        _keep_worst(orders, folder, make_pool, count)
        found = read_entries(folder)
        rows = [row_of(orders, found[number]) for number in range(1, count + 1)]
        _write(folder, rows, [found[row.number] for row in rows], orders, about)
        return Done(folder=folder, results=results_of(rows, about), stopped=count < len(orders))


def describe(orders: Orders) -> dict[str, Any]:
    """Return the content of campaign.json."""
    campaign = orders.campaign
    inputs = [
        {"name": one.name, "kind": one.kind, "targets": list(one.targets), "unit": one.unit,
         "distribution": one.drawn.text, "discrete": one.drawn.discrete}
        for one in campaign.inputs
    ]  # fmt: skip
    metrics = [
        {"name": one.name, "unit": one.unit, "shown_unit": one.shown_unit or one.unit, "scale": one.scale,
         "text": campaign.sources[one.name].text}
        for one in campaign.metrics
    ]  # fmt: skip
    files = {name: [file.digest for file in stored.files] for name, stored in orders.systems.items()}
    around = {
        name: path.read_bytes().hex()
        for name, path in (("faults", campaign.faults), ("commands", campaign.commands))
        if path is not None
    }
    systems = [orders.texts[name] for name in orders.systems]
    return {
        "identity": fingerprint(campaign.content.hex(), list(orders.cases), systems, around),
        "code": code(),
        "path": str(campaign.path),
        "name": campaign.name,
        "seed": campaign.seed,
        "cases": len(orders.cases),
        "runs": len(orders),
        "sampling": campaign.sampling,
        "systems": list(orders.names),
        "stop_time": campaign.stop_time,
        "inputs": inputs,
        "metrics": metrics,
        "requirements": [asdict(one) for one in campaign.requirements],
        "histories": campaign.histories.kept,
        "files": files,
    }


def _same(known: Any, about: Mapping[str, Any], folder: Path) -> None:
    """Raise InputError if a folder holds another campaign."""
    if known is None:
        return
    if not isinstance(known, dict) or known.get("identity") != about["identity"]:
        changed = "the code of flexsat" if isinstance(known, dict) and known.get("code") != about["code"] else (
            "the campaign file, or a file that it names,")  # fmt: skip
        raise InputError(f"{folder}: holds a campaign already, and {changed} has changed since; give another folder")


def _fly_all(
    orders: Orders, folder: Path, pool: Pool, journals: Journals, about: Mapping[str, Any], until: Until | None
) -> int:
    """Carry out all runs that no journal holds; return how many runs the campaign has: fewer if it ends early."""
    found = read_entries(folder)
    counter = Counter(len(orders), len(found), sum(bool(entry["failure"]) for entry in found.values()))
    complete, count = 0, len(orders)

    def enough() -> bool:
        nonlocal complete, count
        while (
            until is not None
            and complete + BLOCK < len(orders)
            and all(number in found for number in range(complete + 1, complete + BLOCK + 1))
        ):
            complete += BLOCK
            if until(results_of([row_of(orders, found[k]) for k in range(1, complete + 1)], about)):
                count = complete
                return True
        return False

    tasks = (task_of(orders, number) for number in range(1, len(orders) + 1) if number not in found)
    with shown(counter, orders.campaign.name) as show:
        counter.workers = pool.size
        if enough():
            return count
        for outcome in dispatch(tasks, pool, show.look):
            entry = entry_of(outcome)
            _keep_history(outcome, folder)
            journals.add(outcome.worker or "lost", entry)
            found[outcome.number] = entry
            counter.add(bool(outcome.failure))
            counter.workers = pool.size
            show.look()
            if enough():
                pool.end()
                break
    return count


def pickled(orders: Orders) -> bytes:
    """Return orders as `flexsat campaign rerun` reads them."""
    return pickle.dumps(orders, protocol=5)


def task_of(orders: Orders, number: int, *, histories: Histories | None = None) -> Task:
    """Return the task of a run."""
    order = orders.order(number)
    if histories is not None:
        order = replace(order, wanted=replace(order.wanted, histories=histories))
    return Task(number=number, title=f"run {number}", function=fly, arguments=(order,), files=orders.files_of(number))


def entry_of(outcome: TaskOutcome) -> Entry:
    """Return what a journal keeps of an outcome."""
    flown: Flown | None = outcome.result
    rises = {} if flown is None or not flown.rises else {"rises": base64.b85encode(flown.rises).decode()}
    return {
        "number": outcome.number,
        "failure": outcome.failure,
        "cause": outcome.cause,
        "metrics": {} if flown is None else {name: _plain(value) for name, value in flown.metrics.items()},
        "simulated_time": None if flown is None else flown.simulated_time,
        "rows_sha256": "" if flown is None else flown.rows_sha256,
        "bands": [] if flown is None else [base64.b85encode(one).decode() for one in flown.bands],
        "attempts": outcome.attempts,
        "wall_time": round(outcome.wall_time, 4),
        "worker": outcome.worker,
        "ended": round(outcome.ended, 3),
        **rises,
    }


def _plain(value: float | None) -> float | str | None:
    if value is None or math.isnan(value):
        return None
    return value if math.isfinite(value) else ("inf" if value > 0.0 else "-inf")


def read_entries(folder: Path) -> dict[int, Entry]:
    """Return the entries of all journals by number; of two of one run, which are equal but for times, the first."""
    found: dict[int, Entry] = {}
    for entry in entries(folder):
        found.setdefault(entry["number"], entry)
    return found


def rises_of(entry: Entry) -> bytes:
    """Return what a journal keeps of the rises of a branch."""
    return base64.b85decode(entry["rises"]) if "rises" in entry else b""


def row_of(orders: Orders, entry: Entry) -> RunRow:
    """Return the row of a run."""
    case, system = orders.case_of(entry["number"])
    return RunRow(
        number=entry["number"],
        case=case,
        system=system,
        inputs=orders.cases[case - 1],
        metrics={name: None if value is None else float(value) for name, value in entry["metrics"].items()},
        failure=entry["failure"],
        cause=entry["cause"],
        simulated_time=entry["simulated_time"],
        rows_sha256=entry["rows_sha256"],
    )


def _keep_history(outcome: TaskOutcome, folder: Path) -> None:
    """Write the results folder of a run, before the run counts."""
    flown: Flown | None = outcome.result
    if flown is not None and flown.folder:
        try:
            unpack(flown.folder, folder / RUNS / str(outcome.number))
        except OSError as error:
            raise RunError(f"{folder / RUNS}: cannot be written ({error.strerror}); free space there and give the same"
                           " command again") from None  # fmt: skip


def _keep_worst(orders: Orders, folder: Path, make_pool: MakePool, count: int) -> None:
    """Repeat the worst runs by a metric, with their histories kept."""
    histories = orders.campaign.histories
    if histories.kept != "worst":
        return
    found = read_entries(folder)
    rows = [row_of(orders, found[number]) for number in range(1, count + 1)]
    low = all(one.most is None for one in orders.campaign.requirements if one.metric == histories.by) and any(
        one.metric == histories.by for one in orders.campaign.requirements
    )
    ranked = [(row.metrics.get(histories.by), row.number) for row in rows]
    valued = [(value if low else -value, number) for value, number in ranked if value is not None]
    numbers = [number for _, number in sorted(valued)[: histories.worst]]
    lacking = [number for number in numbers if not (folder / RUNS / str(number) / "run.toml").is_file()]
    if not lacking:
        return
    tasks = (task_of(orders, number, histories=Histories(kept="all")) for number in lacking)
    pool = make_pool(settings_of(orders.campaign.hang_after, folder / "files"))
    try:
        for outcome in dispatch(tasks, pool):
            _keep_history(outcome, folder)
    except BaseException:
        pool.end()
        raise
    finally:
        pool.close()


def _write(folder: Path, rows: list[RunRow], found: list[Entry], orders: Orders, about: Mapping[str, Any]) -> None:
    """Merge what the journals hold."""
    kinds = {"number": pa.int64(), "attempts": pa.int64(), "wall_time": pa.float64(), "worker": pa.string(),
             "ended": pa.float64()}  # fmt: skip
    write_table(
        folder / TIMINGS, [(pa.field(name, kind), [one[name] for one in found]) for name, kind in kinds.items()]
    )
    if orders.campaign.histories.bands:
        columns: dict[str, list[Any]] = {}
        for part in _bands(rows, found, orders):
            for name, values in part.items():
                columns.setdefault(name, []).extend(values)
        texts = ("system", "signal")
        fields = [
            (pa.field(name, pa.string() if name in texts else pa.int64() if name == "runs" else pa.float64()), values)
            for name, values in columns.items()
        ]
        write_table(folder / BANDS, fields)
    write_results(folder, rows, about)  # the last file: what reads results finds the others


def _bands(rows: list[RunRow], found: list[Entry], orders: Orders) -> Iterator[dict[str, list[Any]]]:
    for system in orders.names:
        for place, band in enumerate(orders.campaign.histories.bands):
            chosen = [entry["bands"][place] for row, entry in zip(rows, found, strict=True)
                      if row.system == system and entry["bands"]]  # fmt: skip
            if not chosen:
                continue
            values = percentiles([unpacked(base64.b85decode(one)) for one in chosen], band)
            length = len(values["time"])
            yield {
                "system": [system] * length,
                "signal": [band.signal] * length,
                "time": values["time"].tolist(),
                "runs": [int(one) for one in values["runs"]],
                **{name: column.tolist() for name, column in values.items() if name not in ("time", "runs")},
            }
