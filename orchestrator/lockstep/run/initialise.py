"""Bring all slaves to step mode, at time 0 or where the state of an earlier run is restored."""

from collections.abc import Callable, Collection, Mapping, Sequence

from lockstep.fmi.slave import Slave
from lockstep.interrupt import Interrupt
from lockstep.plan.plan import Plan
from lockstep.plan.schedule import Task
from lockstep.run.exchange import Exchange
from lockstep.system.clock import seconds

Restore = Callable[[], None]


def initialise(
    plan: Plan,
    slaves: Mapping[str, Slave],
    exchange: Exchange,
    interrupt: Interrupt,
    *,
    restore: Restore | None = None,
    first: int = 0,
    late: Collection[str] = (),
) -> None:
    """Initialise all slaves, with each other's outputs as inputs.

    Continuous components come first: their initial outputs are initial states. Then `restore` brings all to the state
    that they had before the tick `first`, except the components in `late`: those are initialised after it, with the
    outputs that the others have there.
    """
    tasks = sorted(plan.schedule.tasks, key=lambda task: not task.continuous)
    _bring_up([task for task in tasks if task.name not in late], 0, plan, slaves, exchange, interrupt)
    if restore is not None:
        restore()
        _bring_up([task for task in tasks if task.name in late], first, plan, slaves, exchange, interrupt)


def _bring_up(
    tasks: Sequence[Task],
    tick: int,
    plan: Plan,
    slaves: Mapping[str, Slave],
    exchange: Exchange,
    interrupt: Interrupt,
) -> None:
    """Initialise components whose first step is at this tick or later.

    Each gets the outputs of those before it while it is initialised, and those of all once every one is.
    """
    now = seconds(plan.schedule.time(tick))
    for task in tasks:
        name, slave = task.name, slaves[task.name]
        start = task.offset + task.begun(tick - 1) * task.period
        sampled_last = not task.continuous and plan.layout.records_at(plan.ticks)  # for the row at the stop time
        steps = max(0, -(-(plan.ticks + sampled_last - start) // task.period))
        span = (seconds(plan.schedule.time(tick)) for tick in (start, start + steps * task.period))
        exchange.check(name, "SetupExperiment", now, slave.setup_experiment(*span))
        for scalar, values in plan.starts(name).items():  # after it: there some FMUs initialise all their variables
            exchange.check(name, f"Set{scalar}", now, slave.set_start(values, scalar))
    for task in tasks:
        exchange.check(task.name, "EnterInitializationMode", now, slaves[task.name].enter_initialization())
    for task in tasks:
        interrupt.check()
        exchange.set_initial(task.name)
        exchange.check(task.name, "ExitInitializationMode", now, slaves[task.name].exit_initialization())
        exchange.fetch_initial(task.name, task.begun(tick - 1))
    for task in tasks:
        exchange.set_initial(task.name)
