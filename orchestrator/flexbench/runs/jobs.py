"""Run many simulations in parallel processes, with a progress bar each."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from lockstep import RunError, load_system, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart
from lockstep.errors import InputError
from lockstep.interrupt import ENDING
from lockstep.operating_system import accept_interrupts, available_cores, end_with_parent, interrupts_held_back
from lockstep.processes.cpu_affinity import own_thread
from lockstep.results.results_folder import claim
from lockstep.standard_streams import printable, unfiltered

from ..loop.native_fmus import with_native_fmus
from .flown_design import keep_flown
from .loop_monitor import watch_loop
from .metrics_file import write_paper_metrics


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One simulation of a flexsat system, and its results folder.

    `record` as in `simulate`. Without `metrics` the run may be short: the paper's metrics need more than 150 s.
    With a checkpoint the run begins there; without a system it is that of the checkpoint. `native`: with the native
    FMUs beside those of the system.
    """

    system: Path | None
    folder: Path
    overrides: Mapping[str, Any] = field(default_factory=dict)
    stop_time: float | None = None
    record: Sequence[str] | None = None
    metrics: bool = True
    checkpoint: Path | None = None
    native: bool = False
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


_reports: Any = None  # queue to the parent, in a worker
_stopping: Any = None  # event, in a worker: no further job may start; the pool has one more in its queue


def _prepare_worker(reports: Any, stopping: Any) -> None:
    global _reports, _stopping
    _reports, _stopping = reports, stopping
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_parent()
    parent = multiprocessing.parent_process()
    if parent is not None and parent.pid != os.getppid():  # it was killed while this process started
        os._exit(1)
    with suppress(KeyboardInterrupt):  # one that waited while the worker started: the event says it too
        accept_interrupts(ENDING)


def run_job(job: Job) -> Finished:
    """Simulate, and write the metrics to the results folder."""
    if _stopping is not None and _stopping.is_set():
        raise KeyboardInterrupt

    def progress(simulated: float, stop: float) -> None:
        if _reports is not None:
            _reports.put((job.title, simulated, stop))

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
    own = own_thread() if _stopping is not None else nullcontext()  # a worker's: `run_job` is also called directly
    with own, claim(job.folder, overwrite=True) as folder:
        summary = simulate(
            system,
            folder,
            stop_time=job.stop_time,
            overrides=dict(job.overrides),
            record=job.record,
            progress=progress,
            restart=restart,
            watch=watch_loop,
        )
        keep_flown(job.folder)
        metrics = write_paper_metrics(job.folder) if job.metrics else {}
    return Finished(job=job, metrics=metrics, wall_time=summary.wall_time, simulated_time=summary.simulated_time)


def run_jobs(jobs: Sequence[Job], processes: int | None = None, *, keep_failed: bool = False) -> list[Finished]:
    """Run jobs, each in its own process, and return them in the given order.

    Parameters
    ----------
    jobs : their folders must differ
    processes : running at the same time; None for one per core
    keep_failed : return a run that the master stopped, with the reason, instead of raising RunError: for studies in
        which plants are lost

    Raises
    ------
    RunError
        If a run fails or its process dies; the others are stopped, and what they simulated stays readable.
    KeyboardInterrupt
        After Ctrl-C, SIGTERM or SIGHUP, once the workers have closed their results.
    """
    context = multiprocessing.get_context("spawn")  # FMUs keep state in their process; none may be inherited
    with interrupts_held_back(ENDING):  # also by the helper process of multiprocessing, which ends last
        reports, stopping = context.Queue(), context.Event()
    workers = min(processes or len(available_cores()), len(jobs))
    done: dict[int, Finished] = {}
    with (
        _show([job.title for job in jobs]) as show,
        ProcessPoolExecutor(
            workers,
            mp_context=context,
            initializer=_prepare_worker,
            initargs=(reports, stopping),
            max_tasks_per_child=1,
        ) as pool,
    ):
        with interrupts_held_back(ENDING):  # of processes that are not ready for them
            futures = {pool.submit(run_job, job): number for number, job in enumerate(jobs)}
        pending = set(futures)
        try:
            while pending:
                finished, pending = wait(pending, timeout=0.2, return_when=FIRST_COMPLETED)
                _drain(reports, show)
                for future in finished:
                    number = futures[future]
                    done[number] = _result(future, jobs[number], keep_failed)
        except BaseException:
            stopping.set()
            _stop(pool, pending)
            raise
    return [done[number] for number in range(len(jobs))]


def _result(future: Future[Finished], job: Job, keep_failed: bool) -> Finished:
    try:
        return future.result()
    except BrokenProcessPool:
        raise RunError(f"{job.title}: its process died; run it alone with `flexsat run` to see why") from None
    except RunError as error:
        if not keep_failed:
            raise type(error)(f"{job.title}: {error}") from None
        return Finished(job=job, metrics={}, wall_time=0.0, simulated_time=0.0, failure=str(error))
    except InputError as error:
        raise InputError(f"{job.title}: {error}") from None


def _stop(pool: ProcessPoolExecutor, pending: set[Future[Finished]]) -> None:
    """Interrupt the workers, so that they close their results, and start no other job."""
    for future in pending:
        future.cancel()
    for process in list((pool._processes or {}).values()):
        if process.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(process.pid, signal.SIGINT)
    pool.shutdown(wait=True, cancel_futures=True)


def _drain(reports: Any, show: Callable[[str, float, float], None]) -> None:
    latest: dict[str, tuple[float, float]] = {}
    with suppress(Empty):
        while True:
            title, simulated, stop = reports.get_nowait()
            latest[title] = (simulated, stop)
    for title, (simulated, stop) in latest.items():
        show(title, simulated, stop)


@contextmanager
def _show(titles: Sequence[str]) -> Iterator[Callable[[str, float, float], None]]:
    """Yield a function that shows progress: a bar for each run on a terminal, else a line for each finished run."""
    console = Console(file=unfiltered(sys.stderr))
    if not console.is_terminal:
        ended: set[str] = set()

        def line(title: str, simulated: float, stop: float) -> None:
            if simulated >= stop and title not in ended:
                ended.add(title)
                print(
                    f"{title}: {simulated:g} s simulated ({len(ended)} of {len(titles)})", file=sys.stderr, flush=True
                )

        yield line
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} s{task.fields[speed]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bars:
        tasks = {title: bars.add_task(escape(printable(title)), total=1.0, start=False, speed="") for title in titles}
        started: dict[str, float] = {}

        def bar(title: str, simulated: float, stop: float) -> None:
            if title not in started:
                started[title] = perf_counter()
                bars.start_task(tasks[title])
            speed = simulated / max(perf_counter() - started[title], 1e-3)
            bars.update(tasks[title], completed=simulated, total=stop, speed=f", {speed:.1f} x real time")

        yield bar
