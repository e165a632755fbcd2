"""Go on with a run that was killed or interrupted, in its own folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lockstep.checkpoint.file import Checkpoint, newest_checkpoint, read_checkpoint
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.errors import InputError
from lockstep.faults.read import read_scenario
from lockstep.faults.scenario import Scenario
from lockstep.results.read import recorded_rows
from lockstep.results.read_run_record import read_run_record
from lockstep.results.run_record import goes_on
from lockstep.run.real_time_pacing import Pacer
from lockstep.simulation import Progress, RunSummary, simulate
from lockstep.system.system import System


def resumable(folder: Path | str) -> Checkpoint:
    """Return the newest checkpoint of a results folder whose run may be resumed, or raise InputError."""
    folder = Path(folder)
    status = read_run_record(folder)[0].get("status")
    newest = newest_checkpoint(folder)
    if status == "completed":
        remedy = f"; branch from {newest} with --restart-from" if newest else ""
        raise InputError(f"{folder}: its run is complete, there is nothing to resume{remedy}")
    if goes_on(folder):
        raise InputError(f"{folder}: its run still goes on; end it before it is resumed")
    if newest is None:
        raise InputError(f"{folder}: holds no checkpoint; run it anew, with --checkpoint-every to be able to resume it")
    return read_checkpoint(newest)


def resume(
    folder: Path | str,
    system: System | None = None,
    progress: Progress | None = None,
    step_limit: float | str | None = None,
    pace: float | str | Pacer | None = None,
) -> RunSummary:
    """Go on from the newest checkpoint of a run: what was simulated after it is cut off and simulated again.

    The folder then holds the same signals, bit by bit, as if the run had never ended. Checkpoints are made as before.

    Parameters
    ----------
    folder : results folder of a run that did not complete
    system : None: loaded from where the run had it
    progress, step_limit, pace : as in `simulate`

    Raises
    ------
    InputError
        If the run is complete or goes on, there is no checkpoint, or FMUs, adapters or the system have changed.
    RunError, KeyboardInterrupt
        As `simulate`.
    """
    checkpoint = resumable(folder)
    needed = int(checkpoint.header["rows"])
    rows = recorded_rows(Path(folder), needed)
    if rows < needed:
        where = f"{rows} rows recorded, and {checkpoint.path.name} needs {needed}"
        raise InputError(f"{folder}: has {where}; remove that checkpoint to use an earlier one")
    run, wanted = checkpoint.run, checkpoint.header["checkpoints"]
    return simulate(
        system or system_of(run),
        folder,
        stop_time=run["stop_time"],
        overrides=run["overrides"],
        record=run["record"],
        record_period=run["record_period"],
        progress=progress,
        step_limit=step_limit,
        faults=[_scenario(entry) for entry in run.get("faults", [])],
        pace=pace,
        checkpoints=CheckpointSchedule(times=wanted["times"], every=wanted["every"], without=wanted["without"]),
        restart=Restart(checkpoint=checkpoint, again=True),
    )


def _scenario(told: Mapping[str, Any]) -> Scenario:
    scenario = read_scenario(Path(told["path"]))
    if scenario.sha256 != told["sha256"]:
        hashes = f"sha256 {told['sha256'][:12]} then, {scenario.sha256[:12]} now"
        raise InputError(f"{told['path']}: has changed since the run, {hashes}; put the old one back")
    return scenario
