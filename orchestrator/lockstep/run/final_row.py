"""Record the last row of a run: at the stop time, or where a component ended the run."""

from collections.abc import Collection

from lockstep.errors import EndOfSimulation
from lockstep.fmi.slave import SCALARS
from lockstep.plan.schedule import Task
from lockstep.run.exchange import Exchange
from lockstep.tick.bound_operations import action
from lockstep.tick.operations import NextRow


def record_stop(exchange: Exchange, tick: int, time: float, row: NextRow) -> None:
    """Record the row at the stop time [s], after this many ticks, if one is due.

    It is the row of a longer run: sampled components that are due take their sample, and connected inputs that are
    recorded are set; no time passes after it. A component that asks for the end there has no further sample.
    """
    due = _recorded_due(exchange, tick)
    if due is None:
        return
    steps = [(task, exchange.step(task, tick, advances=not task.continuous)) for task in due]
    if exchange.faults is not None:
        exchange.faults.begin_tick(time)
    try:
        for block in exchange.in_order(tick, steps):
            action(block)(time)
    except EndOfSimulation as end:
        record_end(exchange, tick, time, row, components_before(exchange, end.component))
    else:
        action(exchange.capture(tick, row))(time)


def record_end(exchange: Exchange, tick: int, time: float, row: NextRow, stepped: Collection[str] = ()) -> None:
    """Record the row at the time [s] at which a component ended the run, after this many ticks, if one is due.

    Of the components that are due only those in `stepped` have made their step; what the others show from its start
    on is what they had before.
    """
    due = _recorded_due(exchange, tick)
    if due is None:
        return
    for task in due:
        if task.name not in stepped:
            _hold(exchange, task, tick, time)
    action(exchange.capture(tick, row))(time)


def components_before(exchange: Exchange, name: str) -> set[str]:
    """Return the components that are stepped before this one in a tick."""
    names = [task.name for task in exchange.layout.schedule.tasks]
    return set(names[: names.index(name)])


def _recorded_due(exchange: Exchange, tick: int) -> list[Task] | None:
    """Return the components due at a tick of which a row there needs values of their step; None without a row."""
    layout = exchange.layout
    if not layout.records_at(tick):
        return None
    due = [task for task in layout.schedule.tasks if task.steps_at(tick)]
    return [task for task in due if not task.continuous or task.name in layout.held]


def _hold(exchange: Exchange, task: Task, tick: int, time: float) -> None:
    """Copy a component's values to where those of its step at this tick would lie."""
    name, version, layout = task.name, task.begun(tick), exchange.layout
    for scalar in SCALARS:
        start, references = layout.fetched(name, scalar, version)
        _, before = layout.fetched(name, scalar, version - 1)
        if set(references) <= set(before):  # also where there are none
            places = layout.positions(name, scalar, references, version - 1)
            exchange.bus[scalar][start : start + len(references)] = exchange.bus[scalar][places]
        else:  # nobody read all of them then
            action(tuple(exchange.operations.get(name, scalar, start, references, 0.0)))(time)
