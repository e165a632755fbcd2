"""Run a system: check it, start the FMUs, step them in lockstep, and leave a results folder whatever happens."""

import os
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from time import perf_counter

from lockstep.clock import nanoseconds, seconds
from lockstep.errors import InputError, RunError
from lockstep.exchange import Exchange
from lockstep.fmu import FmuSlave, read_description
from lockstep.interrupt import Interrupt, deferred_interrupt
from lockstep.layout import Layout, Reference
from lockstep.manifest import RUN, Events, describe_run, write_manifest
from lockstep.recorder import Recorder
from lockstep.schedule import Schedule, build_schedule, whole_ticks
from lockstep.slave import SCALARS, Slave
from lockstep.system import System, Value
from lockstep.wiring import Override, Signal, Wiring, select, wire

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
    plan = _Plan(system, stop_time, given, record, record_period)
    _check_folder(folder, overwrite)
    with ExitStack() as stack:
        interrupt = stack.enter_context(deferred_interrupt())
        temporary = stack.enter_context(tempfile.TemporaryDirectory(prefix="lockstep-", ignore_cleanup_errors=True))
        events = Events()
        stack.callback(events.close)
        slaves: dict[str, Slave] = {}
        close_slaves = stack.enter_context(ExitStack())
        for number, component in enumerate(system.components):
            interrupt.check()
            place = Path(temporary, str(number))
            slave = FmuSlave(component, plan.descriptions[component.name], place, events.log)
            close_slaves.callback(slave.close)
            slaves[component.name] = slave
        exchange = Exchange(plan.layout, slaves, plan.names)
        _initialize(plan, slaves, exchange, interrupt)
        manifest = describe_run(
            system,
            plan.descriptions,
            plan.wiring.parameters,
            given,
            plan.stop_time,
            plan.record,
            plan.layout.record_ticks * system.tick,
        )
        _make_folder(folder, manifest)
        return _Run(plan, folder, manifest, events, exchange, close_slaves).execute(interrupt, progress)


class _Plan:
    """Everything about a run that is known before any FMU is started."""

    def __init__(
        self,
        system: System,
        stop_time: float | str | None,
        overrides: Mapping[str, Override],
        record: Sequence[str] | None,
        record_period: float | str | None,
    ) -> None:
        self.system = system
        stop = system.stop_time if stop_time is None else nanoseconds(stop_time, "stop time")
        if stop is None:
            raise InputError(f"system {system.name}: no stop time in the file; give one")
        self.stop_time: int = stop
        self.ticks = whole_ticks(stop, system.tick, "stop time")
        self.schedule: Schedule = build_schedule(system)
        self.descriptions = {component.name: read_description(component) for component in system.components}
        self.wiring: Wiring = wire(system, self.descriptions, overrides)
        self.record = tuple(system.record if record is None else record)
        self.signals: tuple[Signal, ...] = select(system, self.descriptions, self.record)
        period = system.record_period if record_period is None else nanoseconds(record_period, "record period")
        self.layout = Layout(
            schedule=self.schedule,
            links=self.wiring.links,
            recorded=_by_component(self.signals),
            record_ticks=1 if period is None else whole_ticks(period, system.tick, "record period"),
        )
        self.names = {
            (name, scalar, variable.reference): variable.name
            for name, description in self.descriptions.items()
            for scalar in SCALARS
            for variable in description.variables.values()
            if variable.type == scalar and variable.causality == "output"
        }

    def starts(self, name: str) -> dict[str, dict[int, Value]]:
        """Return a component's parameters and start values by type and value reference."""
        starts: dict[str, dict[int, Value]] = {}
        for key, value in self.wiring.parameters[name].items():
            variable = self.descriptions[name].variables[key]
            starts.setdefault(variable.type, {})[variable.reference] = value
        return starts


def _by_component(signals: Sequence[Signal]) -> dict[str, tuple[Reference, ...]]:
    grouped: dict[str, list[Reference]] = {}
    for signal in signals:
        scalar = next(scalar for scalar in SCALARS if scalar == signal.variable.type)
        grouped.setdefault(signal.component, []).append((scalar, signal.variable.reference))
    return {name: tuple(references) for name, references in grouped.items()}


def _initialize(plan: _Plan, slaves: Mapping[str, Slave], exchange: Exchange, interrupt: Interrupt) -> None:
    """Bring all slaves to step mode, with each other's initial outputs as inputs.

    Continuous components first: their initial outputs are initial states. Each component gets the outputs of
    those before it while it is initialized, and of all when everyone is.
    """
    tasks = sorted(plan.schedule.tasks, key=lambda task: not task.continuous)
    for task in tasks:
        name, slave = task.name, slaves[task.name]
        for scalar, values in plan.starts(name).items():
            exchange.check(name, f"fmi2Set{scalar}", 0.0, slave.set_start(values, scalar))
        start = task.offset
        steps = max(0, -(-(plan.ticks - start) // task.period))
        span = (seconds(tick * plan.system.tick) for tick in (start, start + steps * task.period))
        exchange.check(name, "fmi2SetupExperiment", 0.0, slave.setup_experiment(*span))
    for task in tasks:
        exchange.check(task.name, "fmi2EnterInitializationMode", 0.0, slaves[task.name].enter_initialization())
    for task in tasks:
        interrupt.check()
        exchange.set_initial(task.name)
        exchange.check(task.name, "fmi2ExitInitializationMode", 0.0, slaves[task.name].exit_initialization())
        exchange.fetch_initial(task.name)
    for task in tasks:
        exchange.set_initial(task.name)


def _check_folder(folder: Path, overwrite: bool) -> None:
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InputError(f"{folder}: is a file; choose another results folder")
    if any(folder.iterdir()):
        if not (folder / RUN).exists():
            raise InputError(f"{folder}: holds other files and no run; choose another results folder")
        if not overwrite:
            raise InputError(f"{folder}: holds a run already; choose another folder or overwrite it")


def _make_folder(folder: Path, manifest: Mapping[str, object]) -> None:
    """Put the new run's folder in place of an old one, in one step for whoever looks."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        fresh.chmod(0o755)
        try:
            write_manifest(fresh, manifest)
            old = None
            if folder.exists():
                old = Path(tempfile.mkdtemp(prefix=f".{folder.name}-old-", dir=folder.parent))
                folder.replace(old)
            fresh.rename(folder)
        except BaseException:
            shutil.rmtree(fresh, ignore_errors=True)
            raise
        if old is not None:
            shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror or error}); choose another folder") from None


class _Run:
    """The loop, and what is written around it."""

    def __init__(
        self,
        plan: _Plan,
        folder: Path,
        manifest: dict[str, object],
        events: Events,
        exchange: Exchange,
        close_slaves: ExitStack,
    ) -> None:
        self.plan, self.folder, self.manifest, self.events = plan, folder, manifest, events
        self.exchange, self.close_slaves = exchange, close_slaves
        self.done = 0  # [ticks]

    def execute(self, interrupt: Interrupt, progress: Progress | None) -> RunSummary:
        """Run to the end; on any failure close everything in order, then let the failure pass."""
        plan = self.plan
        started = perf_counter()
        recorder: Recorder | None = None
        try:
            try:
                self.events.open(self.folder)
                self.events.add("start", stop_time=seconds(plan.stop_time))
                recorder = Recorder(self.folder, plan.signals, self._rows_per_second())
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
        self.manifest |= {"status": status, "simulated_time": self._time()}
        if reason is not None:
            self.manifest["reason"] = reason
        with suppress(OSError):
            self.events.add("end", status=status, **({"reason": reason} if reason else {}))
        with suppress(OSError):
            write_manifest(self.folder, self.manifest)
