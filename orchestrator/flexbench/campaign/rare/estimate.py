"""Probability of a rare event in a campaign: its inputs by subset simulation, its runs on the engine."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from lockstep.errors import InputError
from lockstep.results.results_folder import claim_shared
from lockstep.whole_file import write_whole

from ...engine.fingerprint import fingerprint
from ...engine.pools import LocalPool, settings_of
from ...loop.fmu_choice import PrintLine
from ...runs.json_file import read_json, write_json
from ..campaign import FILE, ORDERS, MakePool, describe, pickled, read_entries, row_of
from ..campaign_file import read_campaign
from ..journal import Journals
from ..orders import prepare
from ..progress import Counter, shown
from ..result_file import ABOUT, write_results
from ..statistics.subset_simulation import RareEvent
from ..statistics.tables import finite
from .event import Event, check_rare, parse_event
from .runs import Branches, Chains, Runner

RARE = "rare.json"
SAMPLING, SPLITTING = "subset-simulation", "splitting"  # in campaign.json


def run_rare(
    path: Path, event_text: str, folder: Path, make_pool: MakePool = LocalPool, report: PrintLine = print
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
    check_rare(campaign, event)
    with claim_shared(folder):
        orders = prepare(campaign, folder, report)
        about = {**describe(orders), "sampling": SPLITTING if campaign.branch_seeds else SAMPLING, "event": event.text}
        about["identity"] = fingerprint(about["identity"], event.text)
        known = read_json(folder / ABOUT)
        if known is not None and (not isinstance(known, dict) or known.get("identity") != about["identity"]):
            raise InputError(f"{folder}: holds another campaign, event or version; give another folder")
        write_whole(folder / FILE, campaign.content)
        write_json(folder / ABOUT, about)
        pool = make_pool(settings_of(campaign.hang_after, folder / "files"))
        method = Branches if campaign.branch_seeds else Chains
        try:
            assert campaign.cases is not None
            counter = Counter(method.most * campaign.cases, 0, 0)  # at most
            with closing(Journals(folder)) as journals, shown(counter, campaign.name) as show:
                runner = Runner(pool=pool, journals=journals, show=show, found=read_entries(folder))
                flight = method(orders, event, runner)
                found = flight.estimate()
        except BaseException:
            pool.end()
            raise
        finally:
            pool.close()
        all_orders = replace(orders, cases=tuple(flight.cases))
        write_whole(folder / ORDERS, pickled(all_orders))
        write_json(folder / ABOUT, {**about, "cases": len(flight.cases), "runs": len(flight.cases)})
        write_json(folder / RARE, as_plain(event, found))
        rows = [row_of(all_orders, runner.found[k]) for k in range(1, found.runs + 1)]
        write_results(folder, [flight.row(row) for row in rows], about)
        return event, found


def as_plain(event: Event, found: RareEvent) -> dict[str, Any]:
    """Return a rare event as plain values."""
    low, high = found.bounds()
    return {
        "event": event.text,
        "probability": found.probability,
        "low": low,
        "high": high,
        "coefficient_of_variation": finite(found.deviation),
        "coefficient_of_variation_most": finite(found.deviation_most),
        "runs": found.runs,
        "reached": found.reached,
        "levels": [{**asdict(one), "threshold": _shown(event, one.threshold)} for one in found.levels],
    }


def level_rows(event: Event, found: RareEvent) -> tuple[list[str], list[list[str]]]:
    """Return the levels as a table."""
    unit = event.metric.shown_unit or event.metric.unit
    share = "accepted" if found.method == "chains" else "families"
    header = ["level", f"beyond [{unit}]" if unit else "beyond", "probability", "deviation", share, "runs"]
    rows = [
        [str(k), f"{_shown(event, one.threshold):.7g}", f"{one.probability:.3g}", f"{100.0 * one.deviation:.0f} %",
         f"{100.0 * one.acceptance:.0f} %", str(one.runs)]
        for k, one in enumerate(found.levels, start=1)
    ]  # fmt: skip
    return header, rows


def sentence(event: Event, found: RareEvent) -> str:
    """Return the result as a sentence."""
    if not found.reached and found.method == "branches":
        left = 100.0 * found.levels[-1].acceptance
        return (f"{event.text}: not reached within {found.runs} runs, as {left:.0f} % of the first runs have branches"
                " left; that is no estimate. Give more cases, or a nearer limit.")  # fmt: skip
    if not found.reached:
        return (f"{event.text}: not reached within {found.runs} runs; its probability is below about"
                f" {found.probability:.1g}. Give more cases, or a nearer limit.")  # fmt: skip
    if not math.isfinite(found.deviation):
        return (f"{event.text}: probability {found.probability:.2g}, without bounds: all runs with the event descend"
                f" from one first run; give more cases. {found.runs} runs.")  # fmt: skip
    low, high = found.bounds()
    return (f"{event.text}: probability {found.probability:.2g}, 95 % bounds {low:.2g} to {high:.2g}, coefficient of"
            f" variation {found.deviation:.2g}, {found.runs} runs.")  # fmt: skip


def _shown(event: Event, response: float) -> float:
    return (response if event.above else -response) / event.metric.scale
