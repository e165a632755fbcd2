"""Simulate the paper's six runs with the native FMUs too, and compare their times and signals with those in Python."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path

from lockstep.results.read_run_record import read_run_record

from ...engine.jobs import Job, run_jobs
from ...loop.equivalence import Difference, compare_folders
from ...runs.json_file import read_table, write_json
from .paper import plan_jobs
from .published import VariantName

FILE = "native.json"
TOLERANCE = 1e-8  # relative, over a whole run: rounding makes 3e-11 in 300 s
_SHAPE = {
    "variant": "text", "seed": "whole number", "duration": "number",
    "runs": [
        {
            "run": "text", "python_time": "number", "native_time": "number", "failure": "text",
            "differences": [{"port": "text", "scalars": "whole number", "relative": "number?", "signal": "text"}],
        }
    ],
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeRun:
    """One run, through both kinds of FMUs. Times in s; without differences if the native one failed."""

    run: str
    python_time: float
    native_time: float
    differences: tuple[Difference, ...]  # a port each
    failure: str = ""

    @property
    def largest(self) -> Difference | None:
        """The largest difference."""
        return max(self.differences, key=lambda found: found.relative, default=None)

    @property
    def met(self) -> bool:
        """Whether the run succeeded, and all differences are within the tolerance."""
        return not self.failure and all(found.met for found in self.differences)


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeStudy:
    """The runs of one variant and seed."""

    variant: VariantName
    seed: int
    duration: float  # s
    runs: tuple[NativeRun, ...]

    @property
    def met(self) -> bool:
        """Whether all runs succeeded, with differences within the tolerance."""
        return all(run.met for run in self.runs)


def run_natively(
    fmus: Path,
    folder: Path,
    variants: Sequence[VariantName],
    seed: int,
    duration: float,
    processes: int | None = None,
    without: Collection[Path] = (),
) -> NativeStudy:
    """Simulate the six runs of one variant with the native FMUs, beside those of the study in `folder`, and compare.

    The variant is the corrected one, on the full plant, if the study has it.

    Parameters
    ----------
    fmus : folder that `flexsat build` filled
    folder : of the study, whose runs are there
    variants, seed, duration, processes : of the study
    without : folders of runs that failed there, which have nothing to compare
    """
    variant: VariantName = "corrected" if "corrected" in variants else variants[0]
    planned = plan_jobs(fmus, folder, [variant], [seed], duration).values()
    jobs = [job for job in planned if job.folder not in without]
    study = NativeStudy(variant=variant, seed=seed, duration=duration, runs=compare_natively(jobs, processes))
    write_native(folder, study)
    return study


def compare_natively(jobs: Sequence[Job], processes: int | None = None) -> tuple[NativeRun, ...]:
    """Simulate with the native FMUs what jobs have simulated already, and compare; one that fails is returned too."""
    if not jobs:
        return ()
    finished = run_jobs([_native(job) for job in jobs], processes, keep_all=True)
    return tuple(
        NativeRun(
            run=job.title,
            python_time=float(read_run_record(job.folder)[0]["wall_time"]),
            native_time=done.wall_time,
            differences=() if done.failure else tuple(compare_folders(done.job.folder, job.folder, TOLERANCE)),
            failure=done.failure,
        )
        for job, done in zip(jobs, finished, strict=True)
    )


def _native(job: Job) -> Job:
    """Return the same run with the native FMUs: its folder is named so."""
    name, _, seed = job.folder.name.rpartition("-")
    return replace(job, native=True, folder=job.folder.with_name(f"{name}-native-{seed}"), metrics=False)


def write_native(folder: Path, study: NativeStudy) -> None:
    """Write the comparison to a study's folder."""
    runs = [
        {
            "run": run.run,
            "python_time": run.python_time,
            "native_time": run.native_time,
            "failure": run.failure,
            "differences": [
                {
                    "port": found.port,
                    "scalars": found.scalars,
                    "relative": found.relative if isfinite(found.relative) else None,
                    "signal": found.signal,
                }
                for found in run.differences
            ],
        }
        for run in study.runs
    ]
    content = {"variant": study.variant, "seed": study.seed, "duration": study.duration, "runs": runs}
    write_json(folder / FILE, content)


def read_native(folder: Path) -> NativeStudy | None:
    """Return the comparison that a study left in its folder, None if there is none; InputError if it is damaged."""
    content = read_table(folder / FILE, _SHAPE)
    if content is None:
        return None
    runs = tuple(
        NativeRun(
            run=run["run"],
            python_time=float(run["python_time"]),
            native_time=float(run["native_time"]),
            failure=run["failure"],
            differences=tuple(
                Difference(
                    port=found["port"],
                    scalars=found["scalars"],
                    relative=inf if found["relative"] is None else float(found["relative"]),
                    signal=found["signal"],
                    tolerance=TOLERANCE,
                )
                for found in run["differences"]
            ),
        )
        for run in content["runs"]
    )
    return NativeStudy(variant=content["variant"], seed=content["seed"], duration=content["duration"], runs=runs)
