"""Carry out the order of one run in a worker process, and return its row."""

from __future__ import annotations

import atexit
import io
import pickle
import shutil
import tarfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path

from lockstep import simulate
from lockstep.errors import RunError
from lockstep.faults.read import read_scenario
from lockstep.fmi.kept_fmus import KeptFmus
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.processes.cpu_affinity import own_thread
from lockstep.results.results_folder import ResultsFolder
from lockstep.simulation.options import RunOptions
from lockstep.system.system import System
from lockstep.whole_file import DISK_FULL

from ..engine.content import File
from ..engine.tasks import DiskFull
from ..engine.worker_process import report_progress
from ..runs.flown_design import keep_flown
from ..runs.loop_monitor import watch_loop
from .measure import Measured, band_values, digest_of_all, metric
from .order import Order, moved_files, with_delays


@dataclass(frozen=True, slots=True, kw_only=True)
class Flown:
    """What a run came to."""

    metrics: Mapping[str, float | None]
    simulated_time: float  # s
    rows_sha256: str
    bands: tuple[bytes, ...] = ()
    folder: bytes = b""  # its results folder as a tar file, if its history is kept
    rises: bytes = b""  # of a branch: ticks and values at which its response rose


def fly(order: Order, paths: Mapping[File, Path]) -> Flown:
    """Simulate and measure a run in a temporary folder.

    Raises
    ------
    DiskFull
        If there is no space for that: no result of the run.
    RunError, InputError
        If the run fails, or its parameters are refused.
    """
    try:
        with temporary_folder("campaign") as temporary:
            folder = temporary / "run"
            wanted = order.wanted
            kept = wanted.histories.kept
            run = Measured(simulated(order, paths, temporary, folder, scratch=kept != "all"))
            return Flown(
                metrics={name: metric(run, source) for name, source in wanted.sources.items()},
                simulated_time=float(run.record["simulated_time"]),
                rows_sha256=digest_of_all(run.signals),
                bands=tuple(band_values(run, wanted.histories.bands)) if kept == "bands" else (),
                folder=_packed(folder) if kept == "all" else b"",
            )
    except OSError as error:
        if error.errno in DISK_FULL:
            raise DiskFull(f"{error.filename or 'temporary folder'}: {error.strerror}; free space there") from None
        raise


def simulated(
    order: Order,
    paths: Mapping[File, Path],
    temporary: Path,
    folder: Path | ResultsFolder,
    record: tuple[str, ...] | None = None,
    record_period: float | None = None,
    *,
    scratch: bool = False,
) -> Path:
    """Simulate a run into a folder and return it; recorded is what the campaign wants, unless something else is given.

    Parameters
    ----------
    paths : of the system and its files
    temporary : folder for the files of faults and commands
    scratch : whether the folder is read once and removed
    """
    wanted = replace(
        order.wanted,
        record=record or order.wanted.record,
        record_period=record_period or order.wanted.record_period,
    )
    system, options = options_of(replace(order, wanted=wanted), paths, temporary)
    with own_thread():
        try:
            summary = simulate(system, folder, replace(options, watch=watch_loop, scratch=scratch))
        except RunError as error:
            if "No space left" in str(error) or "quota exceeded" in str(error):
                raise DiskFull(str(error)) from None
            raise
    assert summary.folder is not None
    keep_flown(summary.folder)
    return summary.folder


def options_of(order: Order, paths: Mapping[File, Path], temporary: Path) -> tuple[System, RunOptions]:
    """Return the system of an order and what its run is to do; files of faults and commands are written to a folder."""
    system = with_delays(system_of(order, paths), order)
    scenarios = []
    if order.faults:
        path = temporary / "faults.toml"
        path.write_text(order.faults, encoding="utf-8")
        scenarios.append(read_scenario(path))
    commands = None
    if order.commands:
        commands = temporary / "commands.csv"
        commands.write_text(order.commands, encoding="utf-8")
    return system, RunOptions(
        stop_time=order.wanted.stop_time,
        overrides=dict(order.overrides),
        record=order.wanted.record,
        record_period=order.wanted.record_period,
        faults=scenarios,
        inputs=commands,
        progress=report_progress,
        threads=1,
        kept=_kept_fmus() if order.wanted.keep_fmus else None,
    )


def system_of(order: Order, paths: Mapping[File, Path]) -> System:
    """Return the system of an order, without its delays."""
    return _system(paths[order.system], tuple(paths.items()))


@cache
def _kept_fmus() -> KeptFmus:
    """Return the FMUs of this process, and have them freed at its end."""
    folder = temporary_folder("fmus")
    kept = KeptFmus(folder.__enter__())
    atexit.register(folder.__exit__, None, None, None)
    atexit.register(kept.close)  # first of both
    return kept


@lru_cache(8)
def _system(path: Path, places: tuple[tuple[File, Path], ...]) -> System:
    system: System = pickle.loads(path.read_bytes())
    return moved_files(system, {Path(file.name): place for file, place in places})


def _packed(folder: Path) -> bytes:
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        archive.add(folder, ".")
    return content.getvalue()


def unpack(content: bytes, folder: Path) -> None:
    """Write the results folder of a run that `Flown` holds, whole or not at all."""
    partial = folder.with_name(f".{folder.name}")
    try:
        shutil.rmtree(partial, ignore_errors=True)  # of a process that was killed
        partial.mkdir(parents=True)
        with tarfile.open(fileobj=io.BytesIO(content)) as archive:
            archive.extractall(partial, filter="data")
        shutil.rmtree(folder, ignore_errors=True)
        partial.replace(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
