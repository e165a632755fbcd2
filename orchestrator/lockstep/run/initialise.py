"""Bring all slaves to step mode: at the start, or where a checkpoint was made."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from lockstep.checkpoint.restart import Restart
from lockstep.fmi.slave import Slave
from lockstep.interrupt import Interrupt
from lockstep.plan.plan import Plan
from lockstep.plan.schedule import Task
from lockstep.run.exchange import Exchange
from lockstep.system.clock import seconds


def initialize(
    plan: Plan,
    slaves: Mapping[str, Slave],
    exchange: Exchange,
    interrupt: Interrupt,
    restart: Restart | None,
    temporary: Path,
) -> None:
    """Initialize all slaves, with each other's outputs as inputs; put those of a checkpoint into their states.

    Continuous components first: their initial outputs are initial states. Those that restart anew at a checkpoint come
    last, and get the outputs that the others have there.
    """
    tasks = sorted(plan.schedule.tasks, key=lambda task: not task.continuous)
    fresh = restart.reinitialised if restart else ()
    _bring_up([task for task in tasks if task.name not in fresh], 0, plan, slaves, exchange, interrupt)
    if restart is not None:
        restart.restore(plan, slaves, exchange, temporary)
        late = [task for task in tasks if task.name in fresh]
        _bring_up(late, restart.checkpoint.tick, plan, slaves, exchange, interrupt)


def _bring_up(
    tasks: Sequence[Task],
    tick: int,
    plan: Plan,
    slaves: Mapping[str, Slave],
    exchange: Exchange,
    interrupt: Interrupt,
) -> None:
    """Initialize components whose first step is at this tick or later.

    Each gets the outputs of those before it while it is initialized, and of all when everyone is.
    """
    for task in tasks:
        name, slave = task.name, slaves[task.name]
        for scalar, values in plan.starts(name).items():
            exchange.check(name, f"Set{scalar}", 0.0, slave.set_start(values, scalar))
        start = task.offset + task.begun(tick - 1) * task.period
        steps = max(0, -(-(plan.ticks - start) // task.period))
        span = (seconds(tick * plan.system.tick) for tick in (start, start + steps * task.period))
        exchange.check(name, "SetupExperiment", 0.0, slave.setup_experiment(*span))
    for task in tasks:
        exchange.check(task.name, "EnterInitializationMode", 0.0, slaves[task.name].enter_initialization())
    for task in tasks:
        interrupt.check()
        exchange.set_initial(task.name)
        exchange.check(task.name, "ExitInitializationMode", 0.0, slaves[task.name].exit_initialization())
        exchange.fetch_initial(task.name, task.begun(tick - 1))
    for task in tasks:
        exchange.set_initial(task.name)
