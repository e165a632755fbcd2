"""Find and read results folders for a page: of flexsat systems and of any other system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flexbench.runs.json_file import read_table
from flexbench.runs.metrics import SETTLED_FROM
from flexbench.runs.run_folder import METRICS, Run, read_run
from lockstep import InputError, Signals, read_signals
from lockstep.results.read_events import read_events
from lockstep.results.read_run_record import read_run_record
from lockstep.results.run_record import RUN

from .layouts_page import shown_runs

MOST_RUNS = 24  # on a page: more colours cannot be distinguished


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """A results folder as the page sees it."""

    folder: Path
    name: str  # unique on the page; of one among several that did not complete, with how it ended
    record: Mapping[str, Any]  # run.toml
    text: str  # of run.toml
    events: Sequence[Mapping[str, Any]]
    run: Run | None  # None for a system that is not flexsat's

    def signals(self) -> Signals:
        """Return the recorded numbers, without texts, which cannot be plotted. Large: read where needed, not kept."""
        found = read_signals(self.folder)
        numbers = {name: np.asarray(v, np.float64) for name, v in found.columns.items() if v.dtype != object}
        return replace(found, columns=numbers)

    def metrics(self) -> Mapping[str, float]:
        """Return the run's metrics in SI; empty for a short run and for a system that is not flexsat's."""
        if self.run is None:
            return {}
        stored = read_table(self.folder / METRICS, {"metrics": {"*": "number"}})
        if stored is not None:
            return dict(stored["metrics"])
        if float(self.record.get("simulated_time", 0.0)) <= SETTLED_FROM:
            return {}
        try:
            return self.run.metrics()
        except InputError:  # a signal that they need was not recorded, or in part
            return {}


@dataclass(frozen=True, slots=True, kw_only=True)
class Unread:
    """A results folder that could not be read, and why."""

    name: str
    reason: str


def load_results(paths: Sequence[Path]) -> tuple[list[Result], list[Unread]]:
    """Read results folders; a folder that holds them stands for all, that of a comparison for one seed's.

    Of several, those that cannot be read are returned beside the others.

    Raises
    ------
    InputError
        If a path holds no run, runs are too many, one is named twice, or none can be read.
    """
    folders: list[Path] = []
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: no such folder; give results folders of runs")
        if (path / RUN).is_file():
            folders.append(path)
            continue
        inside = shown_runs(path) or sorted(
            child.parent for child in path.glob(f"*/{RUN}") if not child.parent.name.startswith(".")
        )
        if not inside:
            raise InputError(f"{path}: holds no {RUN}, nor does a folder in it; give results folders of runs")
        folders += inside
    resolved = [folder.resolve() for folder in folders]
    for number, folder in enumerate(resolved):
        if folder in resolved[:number]:
            raise InputError(f"{folders[number]}: given twice; give each results folder once")
    if len(folders) > MOST_RUNS:
        raise InputError(f"{len(folders)} runs: a page takes {MOST_RUNS} at most; give fewer results folders")
    names = [folder.name for folder in resolved]
    read: list[Result] = []
    unread: list[Unread] = []
    for folder, full, short in zip(folders, resolved, names, strict=True):
        name = short if names.count(short) == 1 else f"{full.parent.name}/{short}"
        try:
            read.append(_read(folder, name, marked=len(folders) > 1))
        except InputError as error:
            if len(folders) == 1:
                raise
            unread.append(Unread(name=name, reason=str(error)))
    if not read:
        raise InputError("; ".join(one.reason for one in unread))
    return read, unread


def _read(folder: Path, name: str, marked: bool) -> Result:
    record, text = read_run_record(folder)
    status = str(record.get("status", ""))
    if marked and status not in ("", "completed"):
        ended = "without end" if status == "running" else f"{status} at {record.get('simulated_time', 0.0):.4g} s"
        name = f"{name} ({ended})"
    try:
        run = read_run(folder)
    except (InputError, KeyError):  # another system: the page shows its signals
        run = None
    return Result(folder=folder, name=name, record=record, text=text, events=read_events(folder), run=run)
