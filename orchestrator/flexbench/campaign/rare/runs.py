"""The runs of a rare event, carried out in batches: chains over inputs, or branches along time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import norm

from flexsat.arrays import Array
from lockstep.checkpoint.schedule import saves_state
from lockstep.errors import InputError, RunError
from lockstep.plan.plan import Plan

from ...engine.dispatch import dispatch
from ...engine.pools import Pool
from ...engine.tasks import Task
from ..campaign import Entry, entry_of, rises_of, task_of
from ..distributions import CASE
from ..flight import system_of
from ..journal import Journals
from ..order import with_delays
from ..orders import Orders
from ..progress import Show
from ..result_file import RunRow
from ..sampling import Case, correlated
from ..statistics.splitting import Branch, splitting
from ..statistics.splitting import Path as RisingPath
from ..statistics.subset_simulation import RareEvent, subset_simulation
from .branch_flight import BranchOrder, Lineage, fly_branch, unpacked_rises
from .event import Event

_SEEDS = 2**31 - 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Runner:
    """Carries out runs by number, each once: what a journal holds is not repeated."""

    pool: Pool
    journals: Journals
    show: Show
    found: dict[int, Entry]

    def run(self, tasks: Mapping[int, Task], *, complete: bool = False) -> None:
        """Carry out the tasks that `found` lacks; with `complete` a failed run ends all."""
        lacking = [task for number, task in tasks.items() if number not in self.found]
        counter = self.show.counter
        counter.workers = self.pool.size
        counter.skip([bool(self.found[number]["failure"]) for number in tasks if number in self.found])
        for outcome in dispatch(lacking, self.pool, self.show.look):
            if outcome.failure and complete:
                kind = InputError if isinstance(outcome.error, InputError) else RunError
                raise kind(f"run {outcome.number}: {outcome.cause}; splitting along time needs runs that complete")
            entry = entry_of(outcome)
            self.journals.add(outcome.worker or "lost", entry)
            self.found[outcome.number] = entry
            counter.add(bool(outcome.failure))
            self.show.look()


class Chains:
    """Subset simulation over the inputs."""

    most = 6  # runs in all: so many times those of a level

    def __init__(self, orders: Orders, event: Event, runner: Runner) -> None:
        self._orders, self._event, self._runner = orders, event, runner
        self.cases: list[Case] = []  # of each run

    def estimate(self) -> RareEvent:
        """Return the probability of the event."""
        campaign = self._orders.campaign
        assert campaign.cases is not None
        return subset_simulation(
            self._responses,
            len(campaign.inputs),
            self._event.threshold,
            samples=campaign.cases,
            most_runs=self.most * campaign.cases,
            seed=campaign.seed,
            redrawn=[k for k, one in enumerate(campaign.inputs) if one.drawn.distribution == CASE],
        )

    def row(self, row: RunRow) -> RunRow:
        """Return what the results hold of a run."""
        return row

    def _responses(self, points: Array) -> Array:
        """Return the response of each standard normal point."""
        begin = len(self.cases)
        self.cases += self._cases_at(points)
        numbers = range(begin + 1, len(self.cases) + 1)
        orders = replace(self._orders, cases=tuple(self.cases))
        self._runner.run({number: task_of(orders, number) for number in numbers})
        name = self._event.metric.name
        values = (self._runner.found[number]["metrics"].get(name) for number in numbers)
        return np.array([self._event.response(None if one is None else float(one)) for one in values])

    def _cases_at(self, points: Array) -> list[Case]:
        campaign = self._orders.campaign
        shares = np.clip(norm.cdf(points), 2.0**-53, 1.0 - 2.0**-53)
        shares = correlated(shares, campaign.inputs, campaign.correlations)
        columns: dict[str, list[Any]] = {}
        for k, one in enumerate(campaign.inputs):
            share = shares[:, k]
            seeds = one.drawn.distribution == CASE
            columns[one.name] = [1 + int(each * _SEEDS) for each in share] if seeds else one.drawn.at(share)
        return [{name: column[k] for name, column in columns.items()} for k in range(len(points))]


class Branches:
    """Splitting along time: runs that come near the event are branched from saved states, with new seeds."""

    most = 10

    def __init__(self, orders: Orders, event: Event, runner: Runner) -> None:
        self._orders, self._event, self._runner = orders, event, runner
        self._last = self._last_tick()
        self._lineages: dict[int, Lineage] = {}
        self._paths: dict[int, RisingPath] = {}  # whole, by number
        self.cases: list[Case] = []  # of each run: that of the first run of its lineage

    def estimate(self) -> RareEvent:
        """Return the probability of the event."""
        campaign = self._orders.campaign
        assert campaign.cases is not None
        return splitting(
            self._fly,
            self._event.threshold,
            self._last,
            samples=campaign.cases,
            most_runs=self.most * campaign.cases,
            seed=campaign.seed,
        )

    def _last_tick(self) -> int:
        """Return the number of ticks of a run; InputError if its noise cannot be branched."""
        campaign, order, store = self._orders.campaign, self._orders.order(1), self._runner.pool.settings.store
        assert store is not None
        system = with_delays(system_of(order, {file: store / file.name for file in self._orders.files_of(1)}), order)
        plan = Plan(
            system, order.wanted.stop_time, dict(order.overrides), order.wanted.record, order.wanted.record_period
        )
        where = f"{campaign.path.name}: campaign: branch_seeds"
        for target in campaign.branch_seeds:
            name, _, parameter = target.partition(".")
            description = plan.descriptions.get(name)
            variable = None if description is None else description.variables.get(parameter)
            if variable is None or variable.variability != "tunable":
                raise InputError(f"{where}: {target}: no tunable parameter of the system; name the seeds of its noise")
        unable = [one.name for one in system.components if not saves_state(one, plan)]
        if unable:
            raise InputError(f"{where}: {', '.join(unable)}: cannot save its state, so that no run can be branched")
        return int(plan.ticks)

    def row(self, row: RunRow) -> RunRow:
        """Return what the results hold of a run: the metric is that of the whole run, not of its last branch."""
        sign = 1.0 if self._event.above else -1.0
        path = self._paths[row.number]
        return replace(row, metrics={self._event.metric.name: sign * path.largest if path.values else None})

    def _fly(self, first: int, branches: Sequence[Branch]) -> list[RisingPath]:
        tasks = {}
        for number, branch in enumerate(branches, start=first):
            before: Lineage = () if branch.parent is None else self._lineages[branch.parent]
            self._lineages[number] = (*before, (branch.tick, branch.seed))
            self.cases.append(self._orders.cases[branch.root])
            tasks[number] = self._task(number, branch.root)
        self._runner.run(tasks, complete=True)
        found = [unpacked_rises(rises_of(self._runner.found[number])) for number in tasks]
        for number, branch, path in zip(tasks, branches, found, strict=True):
            before_it = () if branch.parent is None else (self._paths[branch.parent].until(branch.tick - 1),)
            self._paths[number] = before_it[0].followed_by(path) if before_it else path
        return found

    def _task(self, number: int, root: int) -> Task:
        order = BranchOrder(
            order=self._orders.order(root + 1),
            lineage=self._lineages[number],
            seeds=self._orders.campaign.branch_seeds,
            metric=self._event.metric.name,
            sign=1.0 if self._event.above else -1.0,
        )
        files = self._orders.files_of(root + 1)
        return Task(number=number, title=f"run {number}", function=fly_branch, arguments=(order,), files=files)
