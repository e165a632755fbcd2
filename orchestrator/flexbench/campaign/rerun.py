"""Repeat one run of a campaign by its number, with everything recorded that its system file says."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lockstep.errors import InputError, RunError
from lockstep.fmi.temporary_folder import temporary_folder
from lockstep.plan.plan import Plan
from lockstep.results.results_folder import claim
from lockstep.system.clock import seconds
from lockstep.system.system import System

from ..engine.content import File
from ..engine.dispatch import dispatch
from ..engine.fingerprint import code
from ..engine.pools import LocalPool, settings_of
from ..engine.tasks import Task
from .campaign import ORDERS, RUNS, read_entries
from .campaign_file import Input
from .flight import simulated, system_of
from .measure import Measured, rows_digest
from .order import Order, with_delays
from .orders import Orders
from .result_file import read_about
from .signal_units import declared_unit
from .statistics.sample import Metric


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeated:
    """A run that was repeated."""

    folder: Path
    number: int
    system: str
    inputs: Mapping[str, Any]
    units: Mapping[str, str]  # of the inputs; "" for none
    metrics: Mapping[Metric, float | None]  # of the campaign, SI
    same: bool | None  # whether the rows are those of the campaign; None: it has not simulated this run yet
    other_code: bool  # whether the code has changed since the campaign began
    failure: str = ""  # cause, if it failed


def rerun(folder: Path, number: int, out: Path | None = None, record: Sequence[str] = ()) -> Repeated:
    """Simulate a run of a campaign again, into runs/NUMBER of its folder if no other is given.

    Parameters
    ----------
    record : patterns of signals beside those of the system file and the campaign

    Raises
    ------
    InputError
        If the folder holds no campaign, or that no such run.
    """
    about = read_about(folder)
    if about["sampling"] == "splitting":
        raise InputError(f"run {number}: a branch of a rare event cannot be repeated alone; `flexsat campaign rare` of"
                         " the same file in another folder repeats all")  # fmt: skip
    try:
        orders: Orders = pickle.loads((folder / ORDERS).read_bytes())
    except (OSError, pickle.UnpicklingError, AttributeError, ImportError, TypeError) as error:
        raise InputError(f"{folder / ORDERS}: cannot be read ({error}); it is of another version of flexsat") from None
    order = orders.order(number)
    case, system = orders.case_of(number)
    paths = {file: folder / "files" / file.name for file in orders.files_of(number)}
    target = out or folder / RUNS / str(number)
    entry = read_entries(folder).get(number)
    task = Task(
        number=number,
        title=f"run {number}",
        function=fly_whole,
        arguments=(order, target.absolute(), tuple(record), None if entry is None else entry["rows_sha256"]),
        files=orders.files_of(number),
    )
    pool = LocalPool(settings_of(orders.campaign.hang_after, folder / "files"), 1)
    try:
        (outcome,) = dispatch([task], pool)
    except BaseException:
        pool.end()
        raise
    finally:
        pool.close()
    if outcome.failure and (entry is None or entry["failure"] != outcome.failure or entry["cause"] != outcome.cause):
        raised = outcome.error or RunError(outcome.cause)
        raise InputError(f"run {number}: {raised}") if isinstance(raised, InputError) else raised
    found = {} if entry is None else entry["metrics"]
    return Repeated(
        folder=target,
        number=number,
        system=system,
        inputs=orders.cases[case - 1],
        units={one.name: one.unit or _declared(one, system_of(order, paths)) for one in orders.campaign.inputs},
        metrics={
            one: None if found[one.name] is None else float(found[one.name])
            for one in orders.campaign.metrics
            if one.name in found
        },
        same=True if outcome.failure else outcome.result,
        other_code=about["code"] != code(),
        failure=outcome.cause,
    )


def _declared(one: Input, system: System) -> str:
    """Return the unit in which a parameter is set, if the campaign file gives none."""
    units = {declared_unit(system, target) or "" for target in one.targets} if one.kind == "parameter" else {""}
    return units.pop() if len(units) == 1 else ""


def fly_whole(
    order: Order, folder: Path, record: Sequence[str], expected: str | None, paths: Mapping[File, Path]
) -> bool | None:
    """Simulate a run with full recording; return whether the rows are those of a hash, None if there is none."""
    system = with_delays(system_of(order, paths), order)
    wanted = order.wanted
    before = Plan(system, wanted.stop_time, dict(order.overrides), wanted.record, wanted.record_period)
    names = [signal.name for signal in before.signals]
    coarse = before.layout.record_ticks
    fine = Plan(system, wanted.stop_time, dict(order.overrides), None, None).layout.record_ticks
    period = None if coarse % fine == 0 else wanted.record_period  # rows of both at the same times
    patterns = tuple(dict.fromkeys([*(system.record or ()), *(wanted.record or ()), *record]))
    with temporary_folder("campaign") as temporary, claim(folder, overwrite=True) as held:
        run = Measured(simulated(order, paths, temporary, held, patterns, period or _seconds(system, fine)))
        every = coarse // fine if period is None else 1
        signals = run.signals
        if expected is None:
            return None
        return rows_digest(signals, names, np.asarray(signals.time[::every])) == expected


def _seconds(system: Any, ticks: int) -> float:
    return seconds(ticks * system.tick)
