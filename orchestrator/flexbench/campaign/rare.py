"""Probability of a rare event in a campaign: its inputs by subset simulation, its runs on the engine."""

from __future__ import annotations

import math
import re
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from flexsat.arrays import Array
from lockstep.errors import InputError
from lockstep.results.results_folder import claim_shared
from lockstep.whole_file import write_whole

from ..engine.dispatch import dispatch
from ..engine.fingerprint import fingerprint
from ..engine.pools import LocalPool, Pool, settings_of
from ..runs.json_file import read_json, write_json
from .campaign import FILE, ORDERS, MakePool, describe, entry_of, pickled, read_entries, row_of, task_of
from .campaign_file import Campaign, read_campaign
from .distributions import CASE
from .journal import Journals
from .orders import Orders, Report, prepare
from .progress import Counter, Show, shown
from .result_file import ABOUT, write_results
from .sampling import Case, correlated
from .statistics.sample import Metric
from .statistics.subset_simulation import RareEvent, subset_simulation

RARE = "rare.json"
SAMPLING = "subset-simulation"  # in campaign.json
MOST_LEVELS = 6  # runs in all: so many times those of a level
_EVENT = re.compile(r"\s*(?P<metric>.+?)\s*(?P<sign>[<>])\s*(?P<limit>[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)\s*")
_SEEDS = 2**31 - 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """A metric beyond a limit."""

    text: str
    metric: Metric
    limit: float  # SI
    above: bool

    def response(self, value: float | None) -> float:
        """Return how far a run is towards the event: beyond `threshold` it happens. A lost run is the event."""
        if value is None or math.isnan(value):
            return math.inf
        return value if self.above else -value

    @property
    def threshold(self) -> float:
        """The response beyond which the event happens."""
        return self.limit if self.above else -self.limit


def parse_event(text: str, campaign: Campaign) -> Event:
    """Return the event of a text such as `pointing > 2.5`, in the unit in which the metric is shown.

    Raises
    ------
    InputError
        If the text is none, or the campaign has no such metric.
    """
    found = _EVENT.fullmatch(text)
    known = {one.name: one for one in campaign.metrics}
    if found is None or found["metric"] not in known:
        names = ", ".join(f"{one.name} [{one.shown_unit or one.unit}]" for one in campaign.metrics)
        raise InputError(f"event `{text}`: must be METRIC > VALUE or METRIC < VALUE, in its unit; metrics are {names}")
    metric = known[found["metric"]]
    limit = float(found["limit"]) * metric.scale
    return Event(text=" ".join(text.split()), metric=metric, limit=limit, above=found["sign"] == ">")


def run_rare(
    path: Path, event_text: str, folder: Path, make_pool: MakePool = LocalPool, report: Report = print
) -> tuple[Event, RareEvent]:
    """Return the probability of an event over the inputs of a campaign file; go on with what a folder holds of it.

    The file's `cases` are the runs of each level; its sampling must be random. An input with the number of the case,
    as seeds have, is drawn anew or kept from one run of a chain to the next.

    Parameters
    ----------
    path : campaign file
    event_text : the event, such as `pointing > 2.5`
    folder : for journals and results
    make_pool : returns what carries out the runs
    report : called with lines of text

    Raises
    ------
    InputError
        If anything in the file is wrong, or the folder holds another campaign.
    RunError
        If a disk is full, or a cluster is lost. The same call goes on then.
    """
    campaign = read_campaign(path)
    event = parse_event(event_text, campaign)
    _check(campaign)
    with claim_shared(folder):
        orders = prepare(campaign, folder, report)
        about = {**describe(orders), "sampling": SAMPLING, "event": event.text}
        about["identity"] = fingerprint(about["identity"], event.text)
        known = read_json(folder / ABOUT)
        if known is not None and (not isinstance(known, dict) or known.get("identity") != about["identity"]):
            raise InputError(f"{folder}: holds another campaign, event or version; give another folder")
        write_whole(folder / FILE, campaign.content)
        write_json(folder / ABOUT, about)
        pool = make_pool(settings_of(campaign.hang_after, folder / "files"))
        try:
            assert campaign.cases is not None
            counter = Counter(MOST_LEVELS * campaign.cases, 0, 0)  # at most
            with closing(Journals(folder)) as journals, shown(counter, campaign.name) as show:
                flight = _Batches(orders, event, folder, pool, journals, show)
                found = subset_simulation(
                    flight.responses,
                    len(campaign.inputs),
                    event.threshold,
                    samples=campaign.cases,
                    most_runs=MOST_LEVELS * campaign.cases,
                    seed=campaign.seed,
                    redrawn=[k for k, one in enumerate(campaign.inputs) if one.drawn.distribution == CASE],
                )
        except BaseException:
            pool.end()
            raise
        finally:
            pool.close()
        all_orders = replace(orders, cases=tuple(flight.cases))
        write_whole(folder / ORDERS, pickled(all_orders))
        write_json(folder / ABOUT, {**about, "cases": len(flight.cases), "runs": len(flight.cases)})
        write_json(folder / RARE, as_plain(event, found))
        entries = read_entries(folder)
        write_results(folder, [row_of(all_orders, entries[k]) for k in range(1, found.runs + 1)], about)
        return event, found


def as_plain(event: Event, found: RareEvent) -> dict[str, Any]:
    """Return a rare event as plain values."""
    low, high = found.bounds()
    return {
        "event": event.text,
        "probability": found.probability,
        "low": low,
        "high": high,
        "coefficient_of_variation": found.deviation,
        "coefficient_of_variation_most": found.deviation_most,
        "runs": found.runs,
        "reached": found.reached,
        "levels": [{**asdict(one), "threshold": _shown(event, one.threshold)} for one in found.levels],
    }


def level_rows(event: Event, found: RareEvent) -> tuple[list[str], list[list[str]]]:
    """Return the levels as a table."""
    unit = event.metric.shown_unit or event.metric.unit
    header = ["level", f"beyond [{unit}]" if unit else "beyond", "probability", "deviation", "accepted", "runs"]
    rows = [
        [str(k), f"{_shown(event, one.threshold):.4g}", f"{one.probability:.3g}", f"{100.0 * one.deviation:.0f} %",
         f"{100.0 * one.acceptance:.0f} %", str(one.runs)]
        for k, one in enumerate(found.levels, start=1)
    ]  # fmt: skip
    return header, rows


def sentence(event: Event, found: RareEvent) -> str:
    """Return the result as a sentence."""
    if not found.reached:
        return (f"{event.text}: not reached within {found.runs} runs; its probability is below about"
                f" {found.probability:.1g}. Give more cases, or a nearer limit.")  # fmt: skip
    low, high = found.bounds()
    return (f"{event.text}: probability {found.probability:.2g}, 95 % bounds {low:.2g} to {high:.2g}, coefficient of"
            f" variation {found.deviation:.2g}, {found.runs} runs.")  # fmt: skip


def _shown(event: Event, response: float) -> float:
    return (response if event.above else -response) / event.metric.scale


def _check(campaign: Campaign) -> None:
    """Raise InputError if a campaign has no place for a rare event's cases."""
    if campaign.sampling != "random" or campaign.cases is None or campaign.cases % 10:
        given = f"cases = {campaign.cases}, sampling = {campaign.sampling!r}"
        raise InputError(f"{campaign.path.name}: campaign: {given}: a rare event needs sampling = \"random\" and cases,"
                         " the runs of a level, a multiple of 10")  # fmt: skip
    if len(campaign.systems) != 1 or not campaign.inputs:
        raise InputError(f"{campaign.path.name}: a rare event needs one system under [systems], and inputs")


class _Batches:
    """Carry out batches of cases, each once: what a journal holds is not repeated."""

    def __init__(self, orders: Orders, event: Event, folder: Path, pool: Pool, journals: Journals, show: Show) -> None:
        self._orders, self._event = orders, event
        self._pool, self._journals, self._show = pool, journals, show
        self._found = read_entries(folder)
        self.cases: list[Case] = []

    def responses(self, points: Array) -> Array:
        """Return the response of each standard normal point."""
        begin = len(self.cases)
        self.cases += self._cases_at(points)
        numbers = range(begin + 1, len(self.cases) + 1)
        orders = replace(self._orders, cases=tuple(self.cases))
        lacking = [number for number in numbers if number not in self._found]
        counter = self._show.counter
        counter.workers = self._pool.size
        counter.skip([bool(self._found[number]["failure"]) for number in numbers if number in self._found])
        for outcome in dispatch((task_of(orders, number) for number in lacking), self._pool, self._show.look):
            entry = entry_of(outcome)
            self._journals.add(outcome.worker or "lost", entry)
            self._found[outcome.number] = entry
            counter.add(bool(outcome.failure))
            self._show.look()
        name = self._event.metric.name
        values = (self._found[number]["metrics"].get(name) for number in numbers)
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
