"""The parts of opening a run: plan it, start and initialise the FMUs, describe it, open its files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

from lockstep.adapter.component import with_adapter
from lockstep.checkpoint.restart import Restart
from lockstep.errors import InputError, RunError
from lockstep.faults.scenario import Scenario
from lockstep.fmi.kept_fmus import KeptFmus
from lockstep.fmi.slave import Slave
from lockstep.interrupt import Interrupt
from lockstep.plan.input_files import listed
from lockstep.plan.overrides import Override
from lockstep.plan.plan import Plan
from lockstep.processes.start_slave import SharedProcess, start_slave, wait_until_ready
from lockstep.processes.watched_process import Limits
from lockstep.results.monitor import Observed, Watch
from lockstep.results.recorder import Recorder
from lockstep.results.run_record import Events, describe_run
from lockstep.run.exchange import Exchange
from lockstep.run.initialise import initialise
from lockstep.shadow.component import with_shadow_components, with_shadows
from lockstep.simulation.options import RunOptions
from lockstep.system.clock import seconds
from lockstep.system.system import System


def plan_of(system: System, options: RunOptions) -> tuple[Plan, Mapping[str, Override]]:
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


def start_slaves(
    plan: Plan,
    temporary: Path,
    events: Events,
    limits: Limits,
    close_slaves: ExitStack,
    shared: SharedProcess,
    kept: KeptFmus | None = None,
) -> dict[str, Slave]:
    """Start the FMUs, with their adapters and shadows."""
    slaves: dict[str, Slave] = {}
    started: list[Slave] = []
    descriptions = {**plan.descriptions, **plan.shadows}
    close_slaves.callback(shared.close)
    for number, component in enumerate(with_shadow_components(plan.system)):
        limits.interrupt.check()
        folder = Path(temporary, str(number))
        slave = start_slave(component, descriptions[component.name], folder, events.log, limits, shared, kept)
        close_slaves.callback(slave.close if kept is None else partial(kept.end, slave))
        started.append(slave)
        slaves[component.name] = with_adapter(component, slave)
    wait_until_ready(started)
    together = [component.name for component in with_shadow_components(plan.system) if component.grouped]
    if together:
        events.add("shared-process", components=together)
    return with_shadows(plan.system, slaves, events.add)


def initialise_all(
    plan: Plan,
    slaves: Mapping[str, Slave],
    exchange: Exchange,
    interrupt: Interrupt,
    restart: Restart | None,
    temporary: Path,
) -> None:
    """Initialise all components, or restore those of a checkpoint; raise InputError for what one of them refuses."""
    try:
        if restart is None:
            initialise(plan, slaves, exchange, interrupt)
        else:
            restore = partial(restart.restore, plan, slaves, exchange, temporary)
            first, late = restart.checkpoint.tick, restart.reinitialised
            initialise(plan, slaves, exchange, interrupt, restore=restore, first=first, late=late)
    except RunError as error:  # nothing has been simulated: what a component refuses is its parameters
        raise InputError(str(error)) from None


def describe(plan: Plan, overrides: Mapping[str, Override], faults: Sequence[Scenario]) -> dict[str, Any]:
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


def observed_by(plan: Plan, watch: Watch | None, events: Events) -> Observed | None:
    """Return what looks at the recorded rows, if anything does."""
    names = [signal.name for signal in plan.signals]
    monitor = None if watch is None else watch(plan.system, plan.wiring.parameters, names)
    return None if monitor is None else Observed(monitor, events.add)


def open_files(
    plan: Plan,
    events: Events,
    folder: Path | None,
    restart: Restart | None,
    observed: Observed | None,
    *,
    scratch: bool = False,
) -> Recorder:
    """Open the events and the signals of the run; without a folder they stay in memory."""
    stop = seconds(plan.stop_time)
    if restart is None:
        if folder is not None:
            events.open(folder)
        events.add("start", stop_time=stop)
    else:
        restart.open_events(events, folder, stop)
    saved = restart.saved_rows if restart else None
    return Recorder(folder, plan.signals, rows_per_block(plan), saved, observed, scratch=scratch)


def rows_per_block(plan: Plan) -> int:
    """Return how many rows are recorded in half a simulated second, at least one."""
    return max(1, int(10**9 // (2 * plan.layout.record_ticks * plan.system.tick)))
