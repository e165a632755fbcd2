"""Find where a run that was killed or interrupted can be resumed, and how it was set up."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lockstep.checkpoint.file import Checkpoint, newest_checkpoint, read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.errors import InputError
from lockstep.faults.read import read_scenario
from lockstep.faults.scenario import Scenario
from lockstep.results.read import recorded_rows
from lockstep.results.read_run_record import read_run_record
from lockstep.results.run_record import EVENTS


def resumable(folder: Path | str) -> Checkpoint:
    """Return the newest checkpoint of a results folder whose run may be resumed, or raise InputError."""
    folder = Path(folder)
    status = read_run_record(folder)[0].get("status")
    newest = newest_checkpoint(folder)
    if status in ("completed", "terminated"):
        remedy = f"; branch from {newest} with --restart-from" if newest else ""
        raise InputError(f"{folder}: its run is complete, there is nothing to resume{remedy}")
    if newest is None:
        raise InputError(f"{folder}: holds no checkpoint; run it anew, with --checkpoint-every to be able to resume it")
    return read_checkpoint(newest)


def refuse_missing_rows(folder: Path, checkpoint: Checkpoint) -> None:
    """Raise InputError if the folder holds fewer rows, or less of its events, than had been there at the checkpoint."""
    events, size = folder / EVENTS, int(checkpoint.header["events"]["size"])
    if (found := events.stat().st_size if events.is_file() else 0) < size:
        remedy = "restore it, or remove that checkpoint to use an earlier one"
        raise InputError(f"{events}: has {found} bytes, and {checkpoint.path.name} needs {size}; {remedy}")
    needed = int(checkpoint.header["rows"])
    rows = recorded_rows(folder, needed)
    if rows < needed:
        difference = f"{rows} rows recorded, and {checkpoint.path.name} needs {needed}"
        raise InputError(f"{folder}: has {difference}; remove that checkpoint to use an earlier one")


def earlier_options(checkpoint: Checkpoint) -> dict[str, Any]:
    """Return the options of `simulate` that continue the run of a checkpoint in its folder. Raises InputError."""
    run, schedule = checkpoint.run, checkpoint.header["checkpoints"]
    return {
        **{name: run[name] for name in ("stop_time", "overrides", "record", "record_period")},
        "faults": [_scenario(entry) for entry in run.get("faults", [])],
        "checkpoints": CheckpointSchedule(
            times=schedule["times"], every=schedule["every"], without=schedule["without"]
        ),
        "restart": Restart(checkpoint=checkpoint, same_run=True),
    }


def _scenario(entry: Mapping[str, Any]) -> Scenario:
    """Read a scenario file again; InputError if it has changed since the run."""
    scenario = read_scenario(Path(entry["path"]))
    if scenario.sha256 != entry["sha256"]:
        hashes = f"sha256 {entry['sha256'][:12]} then, {scenario.sha256[:12]} now"
        raise InputError(f"{entry['path']}: has changed since the run, {hashes}; restore the old one")
    return scenario
