"""A run between its start and its end: advance it by ticks, and complete it."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from lockstep.checkpoint.save import Saver
from lockstep.errors import EndOfSimulation, InputError
from lockstep.faults.inject import Faults
from lockstep.faults.resolve import resolve
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.interrupt import Interrupt
from lockstep.plan.plan import Plan
from lockstep.processes.isolation_policy import in_this_process, refuse_without_isolated
from lockstep.processes.start_slave import SharedProcess, limits_given
from lockstep.results.read import Signals, signals_in_memory
from lockstep.results.recorder import Recorder, SavedRows
from lockstep.results.results_folder import ResultsFolder, held
from lockstep.results.run_record import Events
from lockstep.run.batched_steps import Batches
from lockstep.run.choose_tick import TickChoice, choose_tick
from lockstep.run.exchange import Exchange
from lockstep.run.final_row import components_before, record_end, record_stop
from lockstep.run.input_signals import InputSignals
from lockstep.run.loop import Loop
from lockstep.run.real_time_pacing import pacer_given
from lockstep.run.real_time_thread import real_time_thread, thread_given
from lockstep.run.recorded_run import RecordedRun
from lockstep.shadow.component import with_tolerances
from lockstep.simulation.options import Progress, RunOptions
from lockstep.simulation.start import (
    describe,
    initialise_all,
    observed_by,
    open_files,
    plan_of,
    rows_per_block,
    start_slaves,
)
from lockstep.simulation.summary import RunSummary
from lockstep.system.clock import seconds
from lockstep.system.system import System


@dataclass(slots=True, kw_only=True)
class OpenRun:
    """A run whose components are initialised and whose files are open."""

    plan: Plan
    exchange: Exchange
    saver: Saver
    run: RecordedRun
    interrupt: Interrupt
    progress: Progress | None
    first: int  # the tick that it started at
    choice: TickChoice  # what executes ticks
    profile: bool  # whether to measure where the wall time goes even if that takes some of it
    stepped: set[str] = field(default_factory=set)  # in the tick in which a component ended the run
    wall_time: float = 0.0  # [s] of the loop, when it is complete
    stops_between_ticks: bool = False  # after Ctrl-C `advance` returns there, in place of raising KeyboardInterrupt
    recorded_last: bool = False
    identity: dict[str, Any] = field(default_factory=dict)  # of its snapshots, once one is taken

    @property
    def recorder(self) -> Recorder:
        """What records the rows."""
        assert self.run.recorder is not None
        return self.run.recorder

    @property
    def ended(self) -> bool:
        """Whether a component has ended the run."""
        return self.run.terminated is not None

    def start(self) -> None:
        """Bind all calls of the ticks, and start the clocks."""
        self._bind()
        self.run.loop.pauses = [(tick, partial(self._save, tick)) for tick in self.saver.ticks]

    def _bind(self) -> None:
        run, exchange, pacer = self.run, self.exchange, self.run.pacer
        program = exchange.program(self.recorder.row, self.interrupt.check)
        if pacer is not None:
            program = program.with_first((pacer.operation(),))
        ticking = self.choice.start(program, run.loop.done, run.events, self.recorder, measured=self.profile)
        run.loop.bind(ticking, self._look)
        run.close_slaves.callback(run.loop.close)
        if pacer is not None:
            pacer.start(run.loop.time, self._pacer_interrupt)
        exchange.on_end = run.loop.end_after_tick

    @property
    def _pacer_interrupt(self) -> Interrupt:
        """What ends a wait for a tick, which must not end within it where the run goes on after Ctrl-C."""
        return Interrupt() if self.stops_between_ticks else self.interrupt

    def _save(self, tick: int) -> None:
        run = self.run
        assert run.folder is not None
        self.saver.save(tick, run.folder, self.recorder, run.events, run.record, run.wall_time)

    def _look(self, time: float) -> None:
        if self.interrupt.requested and self.stops_between_ticks:
            self.run.loop.stop_after_tick()
        else:
            self.interrupt.check()
        if self.progress is not None:
            self.progress(time, seconds(self.plan.stop_time))

    def go_back(self, tick: int) -> None:
        """Continue at a tick; what the components and the bus hold there has been restored."""
        run = self.run
        run.loop.go_back(tick)
        run.terminated = self.exchange.end = None
        self.stepped, self.recorded_last = set(), False
        run.loop.pauses = [(later, partial(self._save, later)) for later in self.saver.ticks if later > tick]
        if run.pacer is not None:
            run.pacer.start(run.loop.time, self._pacer_interrupt)

    def replace_recorder(self, saved: SavedRows) -> None:
        """Continue the file of the signals after these rows of it."""
        run, plan = self.run, self.plan
        assert run.folder is not None
        scratch = self.recorder.scratch
        self.recorder.abandon()
        run.recorder = Recorder(run.folder, plan.signals, rows_per_block(plan), saved, scratch=scratch)
        self._bind()

    def fail(self, error: BaseException) -> NoReturn:
        """Close everything after a failure, with what was recorded readable, and raise it."""
        raised = self.run.abandon(error)
        if raised is error:
            raise error
        raise raised from None

    def advance(self, tick: int, reason: int | None = None) -> None:
        """Run until so many ticks of the whole run are complete, or a component ends the run before.

        `reason` is what the function of `Loop.stepper` returned, if that has begun the tick. A failure leaves the run
        open; `fail` closes it.
        """
        run, exchange = self.run, self.exchange
        loop = run.loop
        try:
            if reason is None:
                loop.run_until(tick)
            else:
                loop.go_on(reason)
        except EndOfSimulation as end:
            self.stepped = components_before(exchange, end.component)
        if exchange.end is not None:
            run.terminated = exchange.end

    def complete(self) -> RunSummary:
        """Record the last row, close the components and the files, and return the summary.

        After a failure everything is closed too, with what was recorded readable.
        """
        try:
            self.record_last()
            self.wall_time = self.run.wall_time - self.run.wall_time_before
        except BaseException as error:
            self.fail(error)
        self.run.complete()
        return self.summary()

    def record_last(self) -> None:
        """Record the last row, at the time that the run has reached; once."""
        if self.recorded_last:
            return
        self.recorded_last = True
        run, exchange = self.run, self.exchange
        loop, recorder, stop = run.loop, self.recorder, run.loop.time
        if run.pacer is not None:
            run.pacer(stop)
        if run.terminated is None:
            record_stop(exchange, loop.done, loop.time, recorder.row)
        else:
            record_end(exchange, loop.done, loop.time, recorder.row, self.stepped)
        exchange.finish()
        if self.progress is not None:
            self.progress(stop, stop)

    def signals(self) -> Signals:
        """Return what a run in memory has recorded so far."""
        return signals_in_memory(self.recorder.in_memory(), self.recorder.schema)

    def summary(self) -> RunSummary:
        """Return the key figures."""
        run, plan = self.run, self.plan
        return RunSummary(
            folder=run.folder,
            in_memory=self.signals() if run.folder is None else None,
            simulated_time=run.loop.time,
            wall_time=self.wall_time,
            ticks=run.loop.done,
            rows=_rows(plan, self.first, run.loop.done),
            size=run.size,
            loop_time=run.loop_time,
            terminated=None if run.terminated is None else str(run.terminated),
            start_time=seconds(plan.schedule.time(self.first)),
            pacer=run.pacer,
            warnings=(*plan.warnings, *run.warnings, *self.exchange.not_finite.warnings),
        )


def open_run(
    system: System,
    folder: Path | str | ResultsFolder | None,
    options: RunOptions,
    interrupt: Interrupt,
    stack: ExitStack,
) -> OpenRun:
    """Check and plan a run, start and initialise its components, and open its files; without a folder, none.

    `stack` closes what the run needs, once that has ended. Raises InputError, with nothing left on disk.
    """
    restart = options.restart
    limits, pacer = limits_given(options.step_limit), pacer_given(options.pace)
    wanted = thread_given(options.realtime_priority, options.core)
    if options.tolerance is not None:
        system = with_tolerances(system, options.tolerance)
    if restart is not None:
        system = with_tolerances(system, restart.tolerances(system))
    plan, overrides = plan_of(system, options)
    if options.step_limit is not None:
        refuse_without_isolated(plan.system, f"step limit {limits.step:g} s")
    faults = resolve(options.faults, plan) if options.faults else None
    first = restart.checkpoint.tick if restart else 0
    saves = options.checkpoints.ticks(plan, first + 1 if restart else 0)
    if restart is not None:
        restart.check(plan)
    elif options.check is not None:  # a restart goes on with what its run was checked for
        options.check(plan)
    choice = choose_tick(options.tick, plan.system.tick, plan.system.start_time, plan.ticks, options.threads)
    results = None
    if folder is not None:
        results = stack.enter_context(held(folder, overwrite=options.overwrite))  # before anything that takes long
    elif saves:
        raise InputError("checkpoints: are files of a results folder; give a folder, or use snapshots of the run")
    events = Events(seconds(plan.schedule.time(first)))
    temporary = stack.enter_context(temporary_folder("run"))
    stack.callback(events.close)
    close_slaves = stack.enter_context(ExitStack())
    stack.enter_context(in_this_process(plan.system, {**plan.descriptions, **plan.shadows}))
    shared = SharedProcess()
    limits = replace(limits, interrupt=interrupt)
    slaves = start_slaves(plan, temporary, events, limits, close_slaves, shared, options.kept)
    batches = None if shared.connection is None else Batches(shared.connection, slaves)
    injected = None if faults is None else Faults(faults, events.add)
    inputs = InputSignals(plan.inputs, seconds(plan.schedule.time(first)))
    exchange = Exchange(plan.layout, slaves, plan.names, injected, inputs, events.add, batches, choice.several)
    saver = Saver(
        schedule=options.checkpoints, ticks=saves, plan=plan, slaves=slaves, exchange=exchange, temporary=temporary
    )
    initialise_all(plan, slaves, exchange, interrupt, restart, temporary)
    interrupt.check()
    record = describe(plan, overrides, options.faults) | choice.record
    observed = observed_by(plan, options.watch, events)
    if restart is None:
        if results is not None:
            results.fill(record)
    else:
        restart.prepare_folder(results, record)
    run = RecordedRun(
        folder=None if results is None else results.path,
        record=record,
        events=events,
        loop=Loop(tick=plan.system.tick, first=first, last=plan.ticks, clock=events, start=plan.system.start_time),
        tasks=plan.schedule.tasks,
        pacer=pacer,
        close_slaves=close_slaves,
        not_finite=exchange.not_finite,
        wall_time_before=restart.wall_time_before if restart else 0.0,
        observed=observed,
    )
    opened = OpenRun(
        plan=plan,
        exchange=exchange,
        saver=saver,
        run=run,
        interrupt=interrupt,
        progress=options.progress,
        first=first,
        choice=choice,
        profile=options.profile,
    )
    run.start_clock()
    try:
        recorder = open_files(plan, events, run.folder, restart, observed, scratch=options.scratch)
        run.recorder = recorder  # its threads are not raised
        if wanted != (None, None):
            thread = stack.enter_context(real_time_thread(*wanted))
            record["real_time"] = thread.record
            run.warnings += thread.warnings
        opened.start()
    except BaseException as error:
        opened.fail(error)
    return opened


def _rows(plan: Plan, first: int, last: int) -> int:
    """Return how many rows are recorded from one tick to another, those at both included."""
    every = plan.layout.record_ticks
    return last // every - -(-first // every) + 1 if plan.layout.records else 0
