"""Simulate a system: check it, start the FMUs, step them in lockstep, and record the results in a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypedDict, Unpack

from lockstep.adapter.component import with_adapter
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.resume import earlier_options, refuse_missing_rows, resumable
from lockstep.checkpoint.save import Saver
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.errors import EndOfSimulation, InputError, RunError
from lockstep.faults.inject import Faults
from lockstep.faults.resolve import resolve
from lockstep.faults.scenario import Scenario
from lockstep.fmi.slave import Slave
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.interrupt import Interrupt, deferred_interrupt
from lockstep.plan.input_files import Paths, listed
from lockstep.plan.overrides import Override
from lockstep.plan.plan import Plan
from lockstep.processes.start_slave import SharedProcess, limits_given, start_slave, wait_until_ready
from lockstep.processes.watched_process import Limits
from lockstep.results.monitor import Observed, Watch
from lockstep.results.recorder import Recorder
from lockstep.results.results_folder import ResultsFolder, claim_earlier, held
from lockstep.results.run_record import Events, describe_run
from lockstep.run.batched_steps import Batches
from lockstep.run.exchange import Exchange
from lockstep.run.final_row import components_before, record_end, record_stop
from lockstep.run.initialise import initialise
from lockstep.run.input_signals import InputSignals
from lockstep.run.loop import Action, Loop
from lockstep.run.real_time_pacing import Pacer, pacer_given
from lockstep.run.recorded_run import RecordedRun
from lockstep.shadow.component import Tolerances, with_shadow_components, with_shadows, with_tolerances
from lockstep.system.clock import seconds
from lockstep.system.system import System

Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """What a run is to do. All may be left out."""

    stop_time: float | str | None = None  # [s]; None: the system file's
    overrides: Mapping[str, Override] = field(default_factory=dict)  # by `component.parameter`, or an array's name
    record: Sequence[str] | None = None  # patterns on `component.variable`, or `all`; None: the system file's
    record_period: float | str | None = None  # [s]; None: the system file's, or every tick
    progress: Progress | None = None  # called with simulated and final time [s], at most ten times in a second
    overwrite: bool = False  # replace the folder of an earlier run, once the new one has started
    step_limit: float | str | None = None  # wall time of one call of an isolated FMU [s]; None: 60
    faults: Sequence[Scenario] = ()  # to inject: `lockstep.faults`
    pace: float | str | Pacer | None = None  # most times real time; None or 0: as fast as possible
    checkpoints: CheckpointSchedule = field(default_factory=CheckpointSchedule)  # when to save, in the results folder
    restart: Restart | None = None  # checkpoint to start from, instead of the start time
    tolerance: Tolerances | None = None  # of the FMUs' integration, for all or by component; None: what they declare
    strict_inputs: bool = False  # refuse inputs without connection and value, which else keep their start values
    inputs: Paths | None = None  # CSV or Parquet files that feed inputs: `lockstep.plan.input_files`
    strict: bool = False  # refuse system files and model descriptions with offences that are else amended
    watch: Watch | None = None  # returns what looks at the recorded rows: `lockstep.results.monitor`
    check: Callable[[Plan], None] | None = None  # called before any FMU is started; it may raise InputError


class _Named(TypedDict, total=False):
    """The fields of `RunOptions`, as keyword arguments."""

    stop_time: float | str | None
    overrides: Mapping[str, Override]
    record: Sequence[str] | None
    record_period: float | str | None
    progress: Progress | None
    overwrite: bool
    step_limit: float | str | None
    faults: Sequence[Scenario]
    pace: float | str | Pacer | None
    checkpoints: CheckpointSchedule
    restart: Restart | None
    tolerance: Tolerances | None
    strict_inputs: bool
    inputs: Paths | None
    strict: bool
    watch: Watch | None
    check: Callable[[Plan], None] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """Key figures of a completed run."""

    folder: Path
    simulated_time: float  # [s]
    wall_time: float  # [s] of the loop, without start and end
    ticks: int
    rows: int  # recorded
    start_time: float = 0.0  # [s] simulated: that of the system, or of the checkpoint that it was started from
    pacer: Pacer | None = None  # how well real time was kept
    warnings: tuple[str, ...] = ()  # what was amended in the system file, and inputs that keep their start values
    terminated: str | None = None  # why it ended before the stop time, if a component asked for that


def simulate(
    system: System, folder: Path | str | ResultsFolder, options: RunOptions | None = None, **named: Unpack[_Named]
) -> RunSummary:
    """Simulate a system from its start time, or from a checkpoint, to the stop time and leave a results folder.

    Parameters
    ----------
    system : what `load_system` returns
    folder : results folder to make or to fill; it must be empty, or hold a run and `overwrite` be given. Or what
        `claim` of `lockstep.results.results_folder` returned, which the caller then holds beyond the end of the run
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
    """
    for name in ("overrides", "faults", "checkpoints"):  # None: none of them
        if named.get(name, ()) is None:
            del named[name]  # type: ignore[misc]
    chosen = replace(options or RunOptions(), **named)
    restart = chosen.restart
    limits, pacer = limits_given(chosen.step_limit), pacer_given(chosen.pace)
    if chosen.tolerance is not None:
        system = with_tolerances(system, chosen.tolerance)
    if restart is not None:
        system = with_tolerances(system, restart.tolerances(system))
    plan, overrides = _plan(system, chosen)
    faults = resolve(chosen.faults, plan) if chosen.faults else None
    first = restart.checkpoint.tick if restart else 0
    saves = chosen.checkpoints.ticks(plan, first + 1 if restart else 0)
    if restart is not None:
        restart.check(plan)
    elif chosen.check is not None:  # a restart goes on with what its run was checked for
        chosen.check(plan)
    with ExitStack() as stack:
        interrupt = stack.enter_context(deferred_interrupt())
        results = stack.enter_context(held(folder, overwrite=chosen.overwrite))  # before anything that takes long
        events = Events(seconds(plan.schedule.time(first)))
        temporary = stack.enter_context(temporary_folder("run"))
        stack.callback(events.close)
        close_slaves = stack.enter_context(ExitStack())
        shared = SharedProcess()
        slaves = _start(plan, temporary, events, replace(limits, interrupt=interrupt), close_slaves, shared)
        batches = None if shared.connection is None else Batches(shared.connection, slaves)
        injected = None if faults is None else Faults(faults, events.add)
        inputs = InputSignals(plan.inputs, seconds(plan.schedule.time(first)))
        exchange = Exchange(plan.layout, slaves, plan.names, injected, inputs, events.add, batches)
        saver = Saver(
            schedule=chosen.checkpoints, ticks=saves, plan=plan, slaves=slaves, exchange=exchange, temporary=temporary
        )
        _initialise(plan, slaves, exchange, interrupt, restart, temporary)
        interrupt.check()
        record = _describe(plan, overrides, chosen.faults)
        observed = _observed(plan, chosen.watch, events)
        if restart is None:
            results.fill(record)
        else:
            restart.prepare_folder(results, record)
        run = RecordedRun(
            folder=results.path,
            record=record,
            events=events,
            loop=Loop(tick=plan.system.tick, first=first, last=plan.ticks, clock=events, start=plan.system.start_time),
            pacer=pacer,
            close_slaves=close_slaves,
            not_finite=exchange.not_finite,
            wall_time_before=restart.wall_time_before if restart else 0.0,
            observed=observed,
        )
        wall_time = run.execute(
            partial(_open_files, plan, events, results.path, restart, observed),
            partial(_run_loop, run, saver, interrupt, chosen.progress),
        )
    return RunSummary(
        folder=results.path,
        simulated_time=run.loop.time,
        wall_time=wall_time,
        ticks=run.loop.done,
        rows=_rows(plan, first, run.loop.done),
        terminated=None if run.terminated is None else str(run.terminated),
        start_time=seconds(plan.schedule.time(first)),
        pacer=pacer,
        warnings=(*plan.warnings, *exchange.not_finite.warnings),
    )


def resume(
    folder: Path | str | ResultsFolder,
    system: System | None = None,
    progress: Progress | None = None,
    step_limit: float | str | None = None,
    pace: float | str | Pacer | None = None,
    watch: Watch | None = None,
) -> RunSummary:
    """Resume a run from its newest checkpoint: what was simulated after that is cut off and simulated again.

    The folder then holds the same signals, bit by bit, as if the run had never ended. Checkpoints are saved as before.

    Parameters
    ----------
    folder : results folder of a run that did not complete, or what `claim_earlier` returned for it
    system : None: loaded from where the run had it
    progress, step_limit, pace, watch : as in `RunOptions`

    Raises
    ------
    InputError
        If the run is complete or still going on, there is no checkpoint, or FMUs, adapters or the system have changed.
    RunError, KeyboardInterrupt
        As `simulate`.
    """
    if not isinstance(folder, ResultsFolder):
        with claim_earlier(folder) as claimed:
            return resume(claimed, system, progress, step_limit, pace, watch)
    checkpoint = resumable(folder.path)
    refuse_missing_rows(folder.path, checkpoint)
    options = RunOptions(
        progress=progress, step_limit=step_limit, pace=pace, watch=watch, **earlier_options(checkpoint)
    )
    return simulate(system or system_of(checkpoint.run), folder, options)


def _plan(system: System, options: RunOptions) -> tuple[Plan, Mapping[str, Override]]:
    """Return the plan of the run and all its overrides, those of the checkpoint's run included."""
    overrides, record = dict(options.overrides), options.record
    if options.restart is None:
        return Plan(
            system,
            options.stop_time,
            overrides,
            record,
            options.record_period,
            options.strict_inputs,
            options.strict,
            options.inputs or (),
        ), overrides
    return options.restart.plan(
        system,
        options.stop_time,
        overrides,
        record,
        options.record_period,
        strict_inputs=options.strict_inputs,
        strict=options.strict,
        inputs=options.inputs,
    )


def _start(
    plan: Plan, temporary: Path, events: Events, limits: Limits, close_slaves: ExitStack, shared: SharedProcess
) -> dict[str, Slave]:
    """Start the FMUs, with their adapters and shadows."""
    slaves: dict[str, Slave] = {}
    started: list[Slave] = []
    descriptions = {**plan.descriptions, **plan.shadows}
    close_slaves.callback(shared.close)
    for number, component in enumerate(with_shadow_components(plan.system)):
        limits.interrupt.check()
        folder = Path(temporary, str(number))
        slave = start_slave(component, descriptions[component.name], folder, events.log, limits, shared)
        close_slaves.callback(slave.close)
        started.append(slave)
        slaves[component.name] = with_adapter(component, slave)
    wait_until_ready(started)
    together = [component.name for component in with_shadow_components(plan.system) if component.grouped]
    if together:
        events.add("shared-process", components=together)
    return with_shadows(plan.system, slaves, events.add)


def _initialise(
    plan: Plan,
    slaves: Mapping[str, Slave],
    exchange: Exchange,
    interrupt: Interrupt,
    restart: Restart | None,
    temporary: Path,
) -> None:
    try:
        if restart is None:
            initialise(plan, slaves, exchange, interrupt)
        else:
            restore = partial(restart.restore, plan, slaves, exchange, temporary)
            first, late = restart.checkpoint.tick, restart.reinitialised
            initialise(plan, slaves, exchange, interrupt, restore=restore, first=first, late=late)
    except RunError as error:  # nothing has been simulated: what a component refuses is its parameters
        raise InputError(str(error)) from None


def _describe(plan: Plan, overrides: Mapping[str, Override], faults: Sequence[Scenario]) -> dict[str, Any]:
    """Return the content of run.toml."""
    return describe_run(
        plan.system,
        {**plan.descriptions, **plan.shadows},
        plan.wiring.parameters,
        overrides,
        plan.stop_time,
        plan.record,
        plan.layout.record_ticks * plan.system.tick,
        [{"path": str(scenario.path), "sha256": scenario.sha256, "text": scenario.text} for scenario in faults],
        plan.tolerances,
        plan.warnings,
        listed(plan.input_files),
    )


def _observed(plan: Plan, watch: Watch | None, events: Events) -> Observed | None:
    """Return what looks at the recorded rows, if anything does."""
    names = [signal.name for signal in plan.signals]
    monitor = None if watch is None else watch(plan.system, plan.wiring.parameters, names)
    return None if monitor is None else Observed(monitor, events.add)


def _open_files(
    plan: Plan, events: Events, folder: Path, restart: Restart | None, observed: Observed | None
) -> Recorder:
    """Open the events and the signals of the run."""
    stop = seconds(plan.stop_time)
    if restart is None:
        events.open(folder)
        events.add("start", stop_time=stop)
    else:
        restart.open_events(events, folder, stop)
    rows_per_second = max(1, 10**9 // (plan.layout.record_ticks * plan.system.tick))
    return Recorder(folder, plan.signals, rows_per_second, restart.saved_rows if restart else None, observed)


def _run_loop(
    run: RecordedRun, saver: Saver, interrupt: Interrupt, progress: Progress | None, recorder: Recorder
) -> None:
    """Run all ticks, paced, with checkpoints and reports of progress."""
    loop, pacer, stop = run.loop, run.pacer, seconds(saver.plan.stop_time)
    phases: list[tuple[Action, ...]] = saver.exchange.phases(recorder.row, interrupt.check)
    if pacer is not None:
        pacer.begin(loop.time, interrupt)
        phases = [(pacer, *phase) for phase in phases]

    def save(tick: int) -> None:
        saver.save(tick, run.folder, recorder, run.events, run.record, run.wall_time)

    def look(time: float) -> None:
        interrupt.check()
        if progress is not None:
            progress(time, stop)

    exchange = saver.exchange
    exchange.on_end = loop.end_after_tick
    stepped: set[str] = set()  # in the tick in which a component ended the run
    try:
        loop.run(phases, [(tick, partial(save, tick)) for tick in saver.ticks], look)
    except EndOfSimulation as end:
        stepped = components_before(exchange, end.component)
    if exchange.end is not None:
        run.terminated, stop = exchange.end, loop.time
    if pacer is not None:
        pacer(stop)
    if run.terminated is None:
        record_stop(exchange, loop.done, loop.time, recorder.row)
    else:
        record_end(exchange, loop.done, loop.time, recorder.row, stepped)
    exchange.finish()
    if progress is not None:
        progress(stop, stop)


def _rows(plan: Plan, first: int, last: int) -> int:
    """Return how many rows are recorded from one tick to another, those at both included."""
    every = plan.layout.record_ticks
    return last // every - -(-first // every) + 1 if plan.layout.records else 0
