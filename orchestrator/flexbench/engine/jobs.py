"""The runs of a study: in processes that live on, with a progress bar each, and not repeated where they are there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from lockstep import RunError, load_system, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart
from lockstep.errors import InputError
from lockstep.processes.cpu_affinity import own_thread
from lockstep.results.results_folder import claim
from lockstep.system.system import System
from lockstep.whole_file import file_digest

from ..loop.native_fmus import with_native_fmus
from ..runs.flown_design import keep_flown
from ..runs.json_file import read_json, write_json
from ..runs.metrics_file import write_paper_metrics
from ..runs.mission_monitor import watch_run
from .dispatch import dispatch
from .fingerprint import fingerprint, of_system
from .job_progress import ShownJobs, show_jobs
from .pools import LocalPool, settings_of
from .tasks import Task, TaskOutcome
from .worker import BugInWorker
from .worker_process import in_worker, report_progress

DONE = "job.json"  # in a job's folder, once it is complete: what it depends on, and what it came to


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One simulation of a flexsat system, and its results folder.

    `record` as in `simulate`. Without `metrics` the run may be short: the paper's metrics need more than 150 s.
    With a checkpoint the run begins there; without a system it is that of the checkpoint. `native`: with the native
    FMUs beside those of the system. `inputs`: files of signals for inputs.
    """

    system: Path | None
    folder: Path
    overrides: Mapping[str, Any] = field(default_factory=dict)
    stop_time: float | None = None
    record: Sequence[str] | None = None
    metrics: bool = True
    checkpoint: Path | None = None
    native: bool = False
    inputs: tuple[Path, ...] = ()
    reinitialised: tuple[str, ...] = ()  # components that do not take their state from the checkpoint

    @property
    def title(self) -> str:
        """Name in progress and messages."""
        return self.folder.name


@dataclass(frozen=True, slots=True, kw_only=True)
class Finished:
    """A completed job."""

    job: Job
    metrics: Mapping[str, float]  # SI; empty for a job without
    wall_time: float  # s
    simulated_time: float  # s
    failure: str = ""  # why the master stopped the run, if such runs are returned


def run_job(job: Job) -> Finished:
    """Simulate, and write the metrics to the results folder; read them there if it holds the same run already."""
    restart = (
        None
        if job.checkpoint is None
        else Restart(checkpoint=read_checkpoint(job.checkpoint), reinitialised=job.reinitialised)
    )
    if job.system is not None:
        system = with_native_fmus(load_system(job.system)) if job.native else load_system(job.system)
    elif restart is not None:
        system = system_of(restart.checkpoint.run)
    else:
        raise InputError(f"{job.title}: neither a system nor a checkpoint")
    mark = _mark(job, system)
    done = _done(job, mark)
    if done is not None:
        report_progress(done.simulated_time, done.simulated_time)
        return done
    own = own_thread() if in_worker() else nullcontext()  # a worker's: `run_job` is also called directly
    with own, claim(job.folder, overwrite=True) as folder:
        summary = simulate(
            system,
            folder,
            stop_time=job.stop_time,
            overrides=dict(job.overrides),
            record=job.record,
            progress=report_progress,
            restart=restart,
            watch=watch_run,
            inputs=job.inputs or None,
        )
        keep_flown(job.folder)
        metrics = write_paper_metrics(job.folder) if job.metrics else {}
        finished = Finished(
            job=job, metrics=metrics, wall_time=summary.wall_time, simulated_time=summary.simulated_time
        )
        times = {"wall_time": finished.wall_time, "simulated_time": finished.simulated_time}
        write_json(job.folder / DONE, {"depends_on": mark, "metrics": dict(metrics), **times})
    return finished


def _mark(job: Job, system: System) -> str:
    """Return what the content of a job's folder depends on."""
    checkpoint = None if job.checkpoint is None else file_digest(job.checkpoint)
    what = [job.stop_time, job.record, job.metrics, job.native, list(job.reinitialised), checkpoint]
    what += [file_digest(path) for path in job.inputs]
    return fingerprint(of_system(system), dict(job.overrides), what)


def _done(job: Job, mark: str) -> Finished | None:
    """Return a job that is complete in its folder; None if it is not, or another one."""
    try:
        content = read_json(job.folder / DONE)
        if content is None or content["depends_on"] != mark:
            return None
        return Finished(
            job=job,
            metrics=content["metrics"],
            wall_time=content["wall_time"],
            simulated_time=content["simulated_time"],
        )
    except (InputError, KeyError, TypeError):
        return None


def run_jobs(
    jobs: Sequence[Job], processes: int | None = None, *, keep_failed: bool = False, keep_all: bool = False
) -> list[Finished]:
    """Run jobs in parallel processes, and return them in the given order; those that are complete are not repeated.

    Parameters
    ----------
    jobs : their folders must differ
    processes : running at the same time; None for one per core
    keep_failed : return a run that the master stopped, with the reason, instead of raising RunError: for studies in
        which plants are lost
    keep_all : also a run that cannot begin or be evaluated, or whose process dies twice: one run does not stop others

    Raises
    ------
    RunError
        If a run fails or its process dies twice; the others are stopped, and what they simulated stays readable.
    KeyboardInterrupt
        After Ctrl-C, SIGTERM or SIGHUP, once the workers have closed their results.
    """
    reports = SimpleQueue[tuple[int, float, float]]()
    size = min(processes or len(jobs), len(jobs)) if processes else None
    pool = LocalPool(settings_of(), size, lambda *report: reports.put(report))
    tasks = [
        Task(number=number, title=job.title, function=run_job, arguments=(job,)) for number, job in enumerate(jobs)
    ]
    done: dict[int, Finished] = {}
    try:
        with show_jobs([job.title for job in jobs]) as show:
            for outcome in dispatch(tasks, pool, lambda: _drain(reports, jobs, show)):
                _drain(reports, jobs, show)
                done[outcome.number] = _result(outcome, jobs[outcome.number], keep_failed, keep_all)
                show.end(jobs[outcome.number].title, "failed" if outcome.failure else "ended")
            _drain(reports, jobs, show)
    except BaseException:
        pool.end()
        raise
    finally:
        pool.close()
    return [done[number] for number in range(len(jobs))]


def _result(outcome: TaskOutcome, job: Job, keep_failed: bool, keep_all: bool) -> Finished:
    if outcome.failure and keep_all:
        cause = str(outcome.error) if outcome.failure == "error" else f"{outcome.cause}, twice"
        return Finished(job=job, metrics={}, wall_time=0.0, simulated_time=0.0, failure=cause)
    match outcome.failure:
        case "":
            found: Finished = outcome.result
            return found
        case "error":
            if isinstance(outcome.error, InputError):
                raise InputError(f"{job.title}: {outcome.error}") from None
            assert isinstance(outcome.error, RunError)
            if not keep_failed:
                raise type(outcome.error)(f"{job.title}: {outcome.error}") from None
            return Finished(job=job, metrics={}, wall_time=0.0, simulated_time=0.0, failure=str(outcome.error))
    raise RunError(f"{job.title}: {outcome.cause}, twice; run it alone with `flexsat run` to see why")


def _drain(reports: SimpleQueue[tuple[int, float, float]], jobs: Sequence[Job], show: ShownJobs) -> None:
    latest: dict[int, tuple[float, float]] = {}
    try:
        while True:
            number, simulated, stop = reports.get_nowait()
            latest[number] = (simulated, stop)
    except Empty:
        for number, (simulated, stop) in latest.items():
            show(jobs[number].title, simulated, stop)


__all__ = ["BugInWorker", "Finished", "Job", "run_job", "run_jobs"]
