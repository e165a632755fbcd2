"""Simulate a system in one call: check it, start the FMUs, step them in lockstep, and record the results."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Unpack

from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.resume import earlier_options, refuse_missing_rows, resumable
from lockstep.interrupt import deferred_interrupt
from lockstep.results.monitor import Watch
from lockstep.results.results_folder import ResultsFolder, claim_earlier
from lockstep.run.real_time_pacing import Pacer
from lockstep.simulation.open_run import open_run
from lockstep.simulation.options import NamedOptions, Progress, RunOptions, chosen_options
from lockstep.simulation.summary import RunSummary
from lockstep.simulation.system_of_fmus import Delays, Fmus, Pairs, Periods, as_system
from lockstep.system.component import Kind
from lockstep.system.system import System


def simulate(
    system: System | Path | str | Fmus,
    folder: Path | str | ResultsFolder | None = None,
    options: RunOptions | None = None,
    *,
    connections: Pairs = (),
    periods: Periods | None = None,
    delays: Delays | None = None,
    kinds: Mapping[str, Kind] | None = None,
    **named: Unpack[NamedOptions],
) -> RunSummary:
    """Simulate a system from its start time, or from a checkpoint, to the stop time, and return its signals.

    Parameters
    ----------
    system : what `load_system` returns, the path of a system file or of an FMU, or FMUs by name
    folder : results folder to make or to fill; it must be empty, or hold a run and `overwrite` be given. Or what
        `claim` of `lockstep.results.results_folder` returned, which the caller then holds beyond the end of the run.
        None: the recorded signals stay in memory
    connections, periods, delays, kinds : see `lockstep.simulation.system_of_fmus.as_system`
    options : what the run is to do, see `RunOptions`
    named : fields of `RunOptions` by name, which replace those of `options`: `simulate(system, "out", stop_time=10.0)`

    A run from a checkpoint keeps the overrides, input files, tolerances, stop time and recording of the checkpoint's
    run where none are given; the recording only if no component is reinitialised.

    Raises
    ------
    InputError
        If anything in the input is wrong. Nothing is left on disk.
    RunError
        If a component, a value or the disk ends the run. What was simulated stays readable.
    KeyboardInterrupt
        After Ctrl-C, SIGTERM or SIGHUP, with the folder closed in the same way.

    Examples
    --------
    Signals of a system file, and of FMUs connected by pairs of names::

        simulate("loop.ssd", stop_time=10.0)["plant.rate"]
        simulate({"plant": "plant.fmu", "controller": "controller.fmu"},
                 connections=[("plant.rate", "controller.rate"), ("controller.torque", "plant.torque")],
                 periods={"plant": 0.001, "controller": 0.01}, stop_time=10.0)
    """
    chosen = chosen_options(options, named)
    system = as_system(system, connections, periods, delays, kinds)
    with ExitStack() as stack:
        interrupt = stack.enter_context(deferred_interrupt())
        run = open_run(system, folder, chosen, interrupt, stack)
        try:
            run.advance(run.plan.ticks)
        except BaseException as error:
            run.fail(error)
        return run.complete()


def resume(
    folder: Path | str | ResultsFolder,
    system: System | None = None,
    progress: Progress | None = None,
    step_limit: float | str | None = None,
    pace: float | str | Pacer | None = None,
    watch: Watch | None = None,
    realtime_priority: int | str | None = None,
    core: int | str | None = None,
    tick: str = "auto",
    threads: int | str | None = None,
    profile: bool = False,
) -> RunSummary:
    """Resume a run from its newest checkpoint: what was simulated after that is cut off and simulated again.

    The folder then holds the same signals, bit by bit, as if the run had never ended. Checkpoints are saved as before.

    Parameters
    ----------
    folder : results folder of a run that did not complete, or what `claim_earlier` returned for it
    system : None: loaded from where the run had it
    progress, step_limit, pace, watch, realtime_priority, core, tick, threads, profile : as in `RunOptions`

    Raises
    ------
    InputError
        If the run is complete or still going on, there is no checkpoint, or FMUs, adapters or the system have changed.
    RunError, KeyboardInterrupt
        As `simulate`.
    """
    if not isinstance(folder, ResultsFolder):
        with claim_earlier(folder) as claimed:
            return resume(claimed, system, progress, step_limit, pace, watch, realtime_priority, core, tick, threads)
    checkpoint = resumable(folder.path)
    refuse_missing_rows(folder.path, checkpoint)
    options = RunOptions(
        progress=progress,
        step_limit=step_limit,
        pace=pace,
        watch=watch,
        realtime_priority=realtime_priority,
        core=core,
        tick=tick,
        threads=threads,
        profile=profile,
        **earlier_options(checkpoint),
    )
    return simulate(system or system_of(checkpoint.run), folder, options)
