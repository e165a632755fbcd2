"""The pointing budget split by source: the same run, seeds and loop, with one source on at a time.

Sources are switched by parameters of the FMUs. A run with all sources off moves by rounding alone, 1e-31 arcsec. The
loop is nearly linear, so the error histories of the sources alone should add up to that of all together; the
difference is part of the result. Two rows are not runs of their own:

- gyroscopics couple what the sources excite and excite nothing themselves: their row is the run with all sources less
  the same run without the wheels' gyroscopic torques;
- guidance is the reference less the commanded rigid profile. The pointing error is counted from the reference, so that
  this row comes on top of the total, which the user of the telescope sees. Without a slew it is nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND
from flexsat.runtime.rotations import error_rotation, mrp_from_quaternion, quaternion_from_rotation_vector
from lockstep import InputError, load_system

from ...engine.jobs import Job, run_jobs
from ...loop.fmu_choice import PrintLine, choose_fmus, silent
from ...runs import histories
from ...runs.flown_design import planned_slew
from ...runs.json_file import read_table, write_json
from ...runs.run_folder import Run, read_run
from .evaluate import INDICES, LEVELS, Budget, ErrorHistory, IndexWindows, compute_budget, since_default, steady_error

RESULT = "split.json"
# what switches each source off; every run but `all` has some
OFF: Mapping[str, Mapping[str, Any]] = {
    "sensor noise": {
        "sensors.gyro.noise": 0.0,
        "sensors.accelerometer.noise": 0.0,
        "sensors.encoder.noise": 0.0,
        "sensors.star_tracker.noise_coarse": 0.0,
        "sensors.star_tracker.noise_fine": 0.0,
    },
    # also the feed-forward: else the controller would react to jitter that is not there
    "jitter": {"sensors.jitter.enabled": False, "controller.jitter.feed_forward": False},
    "initial error and slew": {
        "plant.initial.attitude_deviation": 0.0,
        **{f"plant.initial.mrp[{axis}]": 0.0 for axis in (1, 2, 3)},
        **{f"controller.command.rotation[{axis}]": 0.0 for axis in (1, 2, 3)},
    },
}
SOURCES = tuple(OFF)
WITHOUT_GYROSCOPICS: Mapping[str, Any] = {"plant.gyroscopics": False}


@dataclass(frozen=True, slots=True, kw_only=True)
class Split:
    """Budgets by contribution. `residual` is all less the sum of the sources: the part without superposition."""

    configuration: str
    seed: int
    stop: float  # s
    start: float  # s: judged from here on
    budgets: Mapping[str, Budget]  # by source, then "all", "none", "sum of sources", "residual", ...

    def rss(self, rms: Mapping[str, float]) -> float:
        """Return the root-sum-square of the sources' values."""
        return float(np.sqrt(sum(rms[source] ** 2 for source in SOURCES)))


def plan_runs() -> dict[str, dict[str, Any]]:
    """Return what each run sets on top of the system, by name."""
    runs: dict[str, dict[str, Any]] = {"all": {}}
    for source in (*SOURCES, "none"):
        runs[source] = {
            parameter: value for other, off in OFF.items() if other != source for parameter, value in off.items()
        }
    runs["all without gyroscopics"] = dict(WITHOUT_GYROSCOPICS)
    return runs


def split_budget(
    system: Path,
    folder: Path,
    seed: int,
    stop: float,
    windows: IndexWindows,
    since: float | None = None,
    levels: Sequence[float] = LEVELS,
    processes: int | None = None,
    python: bool = False,
    report: PrintLine = silent,
) -> Split:
    """Run all, none, each source alone and all without gyroscopics; write the runs and split.json to `folder`.

    `python`: simulate the FMUs in Python; else the native ones where they are built. `report` is called with their
    kind, as a line.

    Raises
    ------
    InputError
        If the runs are too short for what is asked, or the system is not one of flexsat.
    """
    if not (np.isfinite(stop) and stop > 0.0):
        raise InputError(f"--stop-time {stop:g}: must be a time > 0 s")
    chosen = choose_fmus([load_system(system)], python)
    report(chosen.text)
    runs = plan_runs()
    jobs = {
        name: Job(
            system=system,
            folder=folder / name.replace(" ", "-"),
            overrides={"plant.seed": seed, "sensors.seed": seed, **settings},
            stop_time=stop,
            metrics=False,
            native=chosen.native,
        )
        for name, settings in runs.items()
    }
    run_jobs(list(jobs.values()), processes)
    split = compute_split({name: read_run(job.folder) for name, job in jobs.items()}, stop, windows, since, levels)
    write_split(split, folder, chosen.kind)
    return split


def compute_split(
    runs: Mapping[str, Run], stop: float, windows: IndexWindows, since: float | None, levels: Sequence[float] = LEVELS
) -> Split:
    """Return the split of finished runs, by the names of `plan_runs`."""
    whole = steady_error(runs["all"], since)
    # all from when the run with all sources is steady: without the slew others would be so earlier
    errors = {name: whole if name == "all" else steady_error(run, whole.start) for name, run in runs.items()}
    total = np.sum([errors[source].error for source in SOURCES], axis=0)
    derived = {
        "gyroscopics": whole.error - errors["all without gyroscopics"].error,
        "guidance": guidance_error(runs["all"], whole.start),
        "sum of sources": total,
        "residual": whole.error - total,
    }
    for name, error in derived.items():
        errors[name] = ErrorHistory(error=error, interval=whole.interval, start=whole.start)
    budgets = {name: compute_budget(history, windows, levels) for name, history in errors.items()}
    return Split(
        configuration=runs["all"].configuration, seed=runs["all"].seed, stop=stop, start=whole.start, budgets=budgets
    )


def guidance_error(run: Run, since: float | None) -> Array:
    """Return the reference less the commanded rigid profile, (rows, 3) [rad], body axes; zeros without a slew."""
    signals = run.loop()
    _, first, _ = since_default(run, signals.time, since, None if since is not None else run.steady_since(signals))
    time = signals.time[first:]
    command = run.command
    if command is None:
        return np.zeros((len(time), 3))
    profile = planned_slew(run.flown, command)
    turned = profile.rotation(time)[:, None] * profile.axis
    ideal = np.array([mrp_from_quaternion(quaternion_from_rotation_vector(row)) for row in turned.tolist()])
    return error_rotation(signals[histories.ATTITUDE_REFERENCE][first:], ideal)


HEADER = ("contribution", *(f"{index} RMS" for index in INDICES), "of all, APE")


def rows(split: Split) -> list[tuple[str, ...]]:
    """Return the table of the line of sight's RMS by contribution [arcsec], as texts."""
    names = (*SOURCES, "gyroscopics", "guidance", "none", "sum of sources", "residual", "all")
    table = {name: line_of_sight(split.budgets[name]) for name in names}
    table["root-sum-square of sources"] = {
        index: split.rss({source: table[source].get(index, 0.0) for source in SOURCES}) for index in table["all"]
    }
    order = (
        *SOURCES,
        "root-sum-square of sources",
        "sum of sources",
        "all",
        "residual",
        "gyroscopics",
        "guidance",
        "none",
    )
    whole = table["all"]["APE"]
    return [
        (
            name,
            *(f"{table[name][index]:.3g}" if index in table[name] else "-" for index in INDICES),
            f"{100.0 * table[name]['APE'] / whole:.1f} %" if whole > 0.0 else "-",
        )
        for name in order
    ]


def line_of_sight(budget: Budget) -> dict[str, float]:
    """Return the RMS of each index of the line of sight [arcsec]."""
    return {entry.index: entry.rms / ARCSECOND for entry in budget.entries if entry.axis == "line_of_sight"}


def write_split(split: Split, folder: Path, fmus: str) -> None:
    """Write split.json to the folder; `fmus` is the kind of the runs' FMUs."""
    content = {
        "configuration": split.configuration,
        "seed": split.seed,
        "stop": split.stop,
        "fmus": fmus,
        "start": split.start,
        "unit": "arcsec",
        "axis": "line_of_sight, RMS",
        "header": list(HEADER),
        "rows": [list(row) for row in rows(split)],
        "contributions_rad": {
            name: [
                {"index": entry.index, "axis": entry.axis, "rms": entry.rms,
                 "levels": {str(level): value for level, value in entry.levels.items()}}
                for entry in budget.entries
            ]
            for name, budget in split.budgets.items()
        },
    }  # fmt: skip
    write_json(folder / RESULT, content)


_SHAPE = {"configuration": "text", "seed": "number", "header": ["text"], "rows": [["text"]]}


def read_split(folder: Path) -> Mapping[str, Any] | None:
    """Return what `write_split` left, None if there is none."""
    return read_table(folder / RESULT, _SHAPE)
