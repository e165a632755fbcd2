"""Run a system: check it, start the FMUs, step them in lockstep, and leave a results folder whatever happens."""

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from time import perf_counter

from lockstep.adapter.component import with_adapter
from lockstep.clock import seconds
from lockstep.errors import InputError, RunError
from lockstep.exchange import Exchange
from lockstep.folder import check_folder, make_folder
from lockstep.interrupt import Interrupt, deferred_interrupt
from lockstep.isolated.start import limits_given, start_slave, wait_until_ready
from lockstep.manifest import Events, describe_run, write_manifest
from lockstep.parameters import Override
from lockstep.plan import Plan
from lockstep.recorder import Recorder
from lockstep.slave import Slave
from lockstep.system import System
from lockstep.temporary import run_folder

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
) -> RunSummary:
    """Simulate a system from 0 to the stop time and leave a results folder.

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
    given = dict(overrides or {})
    limits = limits_given(step_limit)
    plan = Plan(system, stop_time, given, record, record_period)
    system = plan.system
    check_folder(folder, overwrite)
    with ExitStack() as stack:
        interrupt = stack.enter_context(deferred_interrupt())
        temporary = stack.enter_context(run_folder())
        events = Events()
        stack.callback(events.close)
        slaves: dict[str, Slave] = {}
        started: list[Slave] = []
        close_slaves = stack.enter_context(ExitStack())
        for number, component in enumerate(system.components):
            interrupt.check()
            place = Path(temporary, str(number))
            slave = start_slave(component, plan.descriptions[component.name], place, events.log, limits)
            close_slaves.callback(slave.close)
            started.append(slave)
            slaves[component.name] = with_adapter(component, slave)
        wait_until_ready(started)
        exchange = Exchange(plan.layout, slaves, plan.names)
        try:
            _initialize(plan, slaves, exchange, interrupt)
        except RunError as error:  # nothing has been simulated: what a component refuses is its parameters
            raise InputError(str(error)) from None
        manifest = describe_run(
            system,
            plan.descriptions,
            plan.wiring.parameters,
            given,
            plan.stop_time,
            plan.record,
            plan.layout.record_ticks * system.tick,
        )
        make_folder(folder, manifest)
        return _Run(plan, folder, manifest, events, exchange, close_slaves).execute(interrupt, progress)


def _initialize(plan: Plan, slaves: Mapping[str, Slave], exchange: Exchange, interrupt: Interrupt) -> None:
    """Bring all slaves to step mode, with each other's initial outputs as inputs.

    Continuous components first: their initial outputs are initial states. Each component gets the outputs of
    those before it while it is initialized, and of all when everyone is.
    """
    tasks = sorted(plan.schedule.tasks, key=lambda task: not task.continuous)
    for task in tasks:
        name, slave = task.name, slaves[task.name]
        for scalar, values in plan.starts(name).items():
            exchange.check(name, f"Set{scalar}", 0.0, slave.set_start(values, scalar))
        start = task.offset
        steps = max(0, -(-(plan.ticks - start) // task.period))
        span = (seconds(tick * plan.system.tick) for tick in (start, start + steps * task.period))
        exchange.check(name, "SetupExperiment", 0.0, slave.setup_experiment(*span))
    for task in tasks:
        exchange.check(task.name, "EnterInitializationMode", 0.0, slaves[task.name].enter_initialization())
    for task in tasks:
        interrupt.check()
        exchange.set_initial(task.name)
        exchange.check(task.name, "ExitInitializationMode", 0.0, slaves[task.name].exit_initialization())
        exchange.fetch_initial(task.name)
    for task in tasks:
        exchange.set_initial(task.name)


class _Run:
    """The loop, and what is written around it."""

    def __init__(
        self,
        plan: Plan,
        folder: Path,
        manifest: dict[str, object],
        events: Events,
        exchange: Exchange,
        close_slaves: ExitStack,
    ) -> None:
        self.plan, self.folder, self.manifest, self.events = plan, folder, manifest, events
        self.exchange, self.close_slaves = exchange, close_slaves
        self.done = 0  # [ticks]
        self.started = 0.0  # [s] of the wall clock

    def execute(self, interrupt: Interrupt, progress: Progress | None) -> RunSummary:
        """Run to the end; on any failure close everything in order, then let the failure pass."""
        plan = self.plan
        self.started = perf_counter()
        recorder: Recorder | None = None
        try:
            try:
                self.events.open(self.folder)
                self.events.add("start", stop_time=seconds(plan.stop_time))
                recorder = Recorder(self.folder, plan.signals, self._rows_per_second())
                self._loop(recorder, interrupt, progress)
                wall_time = perf_counter() - self.started
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
            rows=-(-self.done // plan.layout.record_ticks),
        )

    def _rows_per_second(self) -> int:
        return max(1, 10**9 // (self.plan.layout.record_ticks * self.plan.system.tick))

    def _loop(self, recorder: Recorder, interrupt: Interrupt, progress: Progress | None) -> None:
        phases = self.exchange.phases(recorder.row)
        events, tick_length, stop = self.events, self.plan.system.tick, seconds(self.plan.stop_time)
        clock = perf_counter
        look = clock() + _REPORT_INTERVAL
        for tick, phase in zip(range(self.plan.ticks), cycle(phases), strict=False):
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
        self.done = self.plan.ticks
        events.time = stop
        if progress is not None:
            progress(stop, stop)

    def _time(self) -> float:
        return seconds(self.done * self.plan.system.tick)

    def _end(self, status: str, reason: str | None) -> None:
        """Note how the run ended; on a full disk as far as that goes."""
        wall_time = perf_counter() - self.started
        self.manifest |= {"status": status, "simulated_time": self._time(), "wall_time": round(wall_time, 3)}
        if reason is not None:
            self.manifest["reason"] = reason
        with suppress(OSError):
            self.events.add("end", status=status, **({"reason": reason} if reason else {}))
        with suppress(OSError):
            write_manifest(self.folder, self.manifest)
