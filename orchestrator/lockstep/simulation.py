"""Run a system: check it, start the FMUs, step them in lockstep, and leave a results folder whatever happens."""

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from itertools import cycle, islice
from pathlib import Path
from time import perf_counter

from lockstep.adapter.component import with_adapter
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.save import Saver
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.errors import InputError, RunError
from lockstep.faults.inject import Faults
from lockstep.faults.resolve import resolve
from lockstep.faults.scenario import Scenario
from lockstep.fmi.slave import Slave
from lockstep.interrupt import Interrupt, deferred_interrupt
from lockstep.plan.overrides import Override
from lockstep.plan.plan import Plan
from lockstep.processes.start_slave import limits_given, start_slave, wait_until_ready
from lockstep.results.recorder import Recorder
from lockstep.results.results_folder import check_folder, make_folder
from lockstep.results.run_record import Events, describe_run, write_manifest
from lockstep.run.exchange import Exchange, Step
from lockstep.run.initialise import initialize
from lockstep.run.real_time_pacing import Pacer, pacer_given
from lockstep.run.unpack_folder import run_folder
from lockstep.shadow.component import everyone, with_shadows
from lockstep.system.clock import seconds
from lockstep.system.system import System

Progress = Callable[[float, float], None]
_REPORT_INTERVAL = 0.1  # [s] of wall time between two looks at progress and Ctrl-C


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """What a completed run was."""

    folder: Path
    simulated_time: float  # [s]
    wall_time: float  # [s] of the loop, without start and end
    ticks: int
    rows: int  # recorded
    start_time: float = 0.0  # [s] simulated: where it began, or went on
    pacer: Pacer | None = None  # how well real time was held


def simulate(
    system: System,
    folder: Path | str,
    stop_time: float | str | None = None,
    overrides: Mapping[str, Override] | None = None,
    record: Sequence[str] | None = None,
    record_period: float | str | None = None,
    progress: Progress | None = None,
    overwrite: bool = False,
    step_limit: float | str | None = None,
    faults: Sequence[Scenario] = (),
    pace: float | str | Pacer | None = None,
    checkpoints: CheckpointSchedule | None = None,
    restart: Restart | None = None,
) -> RunSummary:
    """Simulate a system from 0, or from a checkpoint, to the stop time and leave a results folder.

    Parameters
    ----------
    system : what `load_system` returns
    folder : results folder to make; it must not exist, or be a run and `overwrite` given
    stop_time : [s]; None: the system file's
    overrides : values by `component.parameter`, numbers or texts; an array's name takes a sequence
    record : patterns on `component.variable`, or `all`; None: the system file's
    record_period : [s]; None: the system file's, or every tick
    progress : called with simulated and final time [s], at most ten times in a second
    overwrite : replace the folder of an earlier run, once the new one has started
    step_limit : wall time that one call of an isolated FMU may take [s]; None: 60
    faults : what goes wrong when: `lockstep.faults`
    pace : factor of real time that the run must not be ahead of; None or 0: as fast as possible
    checkpoints : when to save the state of everything, in the results folder
    restart : checkpoint to go on from; the overrides, stop time and recording of its run hold unless others are given
        (the recording only where no component begins anew)

    Raises
    ------
    InputError
        If anything in the input is wrong. Nothing is left on disk.
    RunError
        If a component, a value or the disk ends the run. What was simulated stays readable.
    KeyboardInterrupt
        After Ctrl-C, with the folder closed in the same way.
    """
    folder = Path(folder).absolute()
    limits, pacer = limits_given(step_limit), pacer_given(pace)
    given = dict(overrides or {})
    if restart is None:
        plan = Plan(system, stop_time, given, record, record_period)
    else:
        plan, given = restart.plan(system, stop_time, given, record, record_period)
    resolved = resolve(faults, plan) if faults else None
    system = plan.system
    first = restart.checkpoint.tick if restart else 0
    saving = checkpoints or CheckpointSchedule()
    ticks = saving.ticks(plan, first + 1 if restart else 0)
    if restart is not None:
        restart.check(plan)
    if restart is None or not restart.again:
        check_folder(folder, overwrite)
    with ExitStack() as stack:
        interrupt = stack.enter_context(deferred_interrupt())
        limits = replace(limits, interrupt=interrupt)
        events = Events(seconds(first * system.tick))
        temporary = stack.enter_context(run_folder(lambda path: events.add("cleaned", folder=str(path))))
        stack.callback(events.close)
        slaves: dict[str, Slave] = {}
        started: list[Slave] = []
        close_slaves = stack.enter_context(ExitStack())
        descriptions = {**plan.descriptions, **plan.shadows}
        for number, component in enumerate(everyone(system)):
            interrupt.check()
            place = Path(temporary, str(number))
            slave = start_slave(component, descriptions[component.name], place, events.log, limits)
            close_slaves.callback(slave.close)
            started.append(slave)
            slaves[component.name] = with_adapter(component, slave)
        wait_until_ready(started)
        slaves = with_shadows(system, slaves, events.add)
        injected = None if resolved is None else Faults(resolved, events.add)
        exchange = Exchange(plan.layout, slaves, plan.names, injected)
        saver = Saver(request=saving, ticks=ticks, plan=plan, slaves=slaves, exchange=exchange, temporary=temporary)
        try:
            initialize(plan, slaves, exchange, interrupt, restart, temporary)
        except RunError as error:  # nothing has been simulated: what a component refuses is its parameters
            raise InputError(str(error)) from None
        manifest = describe_run(
            system,
            descriptions,
            plan.wiring.parameters,
            given,
            plan.stop_time,
            plan.record,
            plan.layout.record_ticks * system.tick,
            faults,
        )
        if restart is None:
            make_folder(folder, manifest)
        else:
            restart.take_folder(folder, manifest)
        return _Run(plan, folder, manifest, events, saver, restart, pacer, close_slaves).execute(interrupt, progress)


class _Run:
    """The loop, and what is written around it."""

    def __init__(
        self,
        plan: Plan,
        folder: Path,
        manifest: dict[str, object],
        events: Events,
        saver: Saver,
        restart: Restart | None,
        pacer: Pacer | None,
        close_slaves: ExitStack,
    ) -> None:
        self.plan, self.folder, self.manifest, self.events = plan, folder, manifest, events
        self.saver, self.restart, self.pacer, self.close_slaves = saver, restart, pacer, close_slaves
        self.first = self.done = restart.checkpoint.tick if restart else 0  # [ticks]
        self.started = 0.0  # [s] of the wall clock, as if all before the checkpoint had been of this run

    def execute(self, interrupt: Interrupt, progress: Progress | None) -> RunSummary:
        """Run to the end; on any failure close everything in order, then let the failure pass."""
        plan = self.plan
        started = self.started = perf_counter()
        recorder: Recorder | None = None
        try:
            try:
                self._open_events()
                recorder = Recorder(
                    self.folder, plan.signals, self._rows_per_second(), self.restart.kept if self.restart else None
                )
                self._loop(recorder, interrupt, progress)
                wall_time = perf_counter() - started
            except BaseException:
                self.close_slaves.close()
                with suppress(OSError):  # the first failure is the one to tell
                    if recorder is not None:
                        recorder.close()
                raise
            self.close_slaves.close()
            recorder.close()
        except KeyboardInterrupt:
            self._end("interrupted", None)
            raise
        except OSError as error:
            what = os.strerror(error.errno) if error.errno else str(error)
            reason = f"cannot write to {self.folder}: {what}, after {self._time():.9g} s simulated"
            self._end("failed", reason)
            raise RunError(f"{reason}; what was written before stays readable") from None
        except BaseException as error:
            self._end("failed", str(error))
            raise
        self._end("completed", None)
        return RunSummary(
            folder=self.folder,
            simulated_time=self._time(),
            wall_time=wall_time,
            ticks=self.done,
            rows=self._rows_before(self.done) - self._rows_before(self.first),
            start_time=seconds(self.first * plan.system.tick),
            pacer=self.pacer,
        )

    def _rows_before(self, tick: int) -> int:
        return -(-tick // self.plan.layout.record_ticks)

    def _open_events(self) -> None:
        events, restart = self.events, self.restart
        events.time = self._time()
        if restart is None:
            events.open(self.folder)
            events.add("start", stop_time=seconds(self.plan.stop_time))
            return
        told = {"checkpoint": str(restart.checkpoint.path), "stop_time": seconds(self.plan.stop_time)}
        if restart.again:
            events.open_again(self.folder, restart.checkpoint.header["events"])
            self.started -= restart.checkpoint.header["wall_time"]
            events.add("resume", **told)
        else:
            events.open(self.folder)
            events.add("branch", **told, reinitialised=list(restart.reinitialised))

    def _rows_per_second(self) -> int:
        return max(1, 10**9 // (self.plan.layout.record_ticks * self.plan.system.tick))

    def _loop(self, recorder: Recorder, interrupt: Interrupt, progress: Progress | None) -> None:
        """Run all ticks, and save where that is due: before a tick, or after the last one."""
        phases = self.saver.exchange.phases(recorder.row)
        stop, first, last = seconds(self.plan.stop_time), self.first, self.plan.ticks
        if self.pacer is not None:
            self.pacer.begin(self._time(), interrupt)
            phases = [(self.pacer, *phase) for phase in phases]
        look = perf_counter() + _REPORT_INTERVAL
        for end in [*self.saver.ticks, None]:
            look = self._ticks(phases, range(first, last if end is None else end), look, interrupt, progress)
            if end is not None:
                self.done = first = end
                self.events.time = self._time()
                wall_time = perf_counter() - self.started
                self.saver.save(end, self.folder, recorder, self.events, self.manifest, wall_time)
        self.done = last
        self.events.time = stop
        self.saver.exchange.finish()
        if self.pacer is not None:
            self.pacer(stop)
        if progress is not None:
            progress(stop, stop)

    def _ticks(
        self,
        phases: Sequence[tuple[Step, ...]],
        ticks: range,
        look: float,
        interrupt: Interrupt,
        progress: Progress | None,
    ) -> float:
        """Run these ticks; return when to look next at Ctrl-C and progress, on the wall clock."""
        events, tick_length, stop = self.events, self.plan.system.tick, seconds(self.plan.stop_time)
        clock = perf_counter
        for tick, phase in zip(ticks, islice(cycle(phases), ticks.start % len(phases), None), strict=False):
            self.done = tick
            events.time = time = tick * tick_length / 1e9  # the nearest double, never a sum of steps
            for step in phase:
                step(time)
            if clock() >= look:
                self.done = tick + 1  # the tick is complete: every recorded row lies before the simulated time
                interrupt.check()
                if progress is not None:
                    progress(time, stop)
                look = clock() + _REPORT_INTERVAL
        return look

    def _time(self) -> float:
        return seconds(self.done * self.plan.system.tick)

    def _end(self, status: str, reason: str | None) -> None:
        """Note how the run ended; on a full disk as far as that goes."""
        wall_time = perf_counter() - self.started
        self.manifest |= {"status": status, "simulated_time": self._time(), "wall_time": round(wall_time, 3)}
        if reason is not None:
            self.manifest["reason"] = reason
        if self.pacer is not None:
            self.manifest["pace"] = self.pacer.summary()
            with suppress(OSError):
                self.events.add("pace", **self.pacer.summary())
        with suppress(OSError):
            self.events.add("end", status=status, **({"reason": reason} if reason else {}))
        with suppress(OSError):
            write_manifest(self.folder, self.manifest)
