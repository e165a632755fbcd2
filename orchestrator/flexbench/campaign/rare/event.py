"""A rare event of a campaign: a metric beyond a limit, and what a campaign needs so that it can be estimated."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from lockstep.errors import InputError

from ..campaign_file import Campaign
from ..statistics.sample import Metric

_EVENT = re.compile(r"\s*(?P<metric>.+?)\s*(?P<sign>[<>])\s*(?P<limit>[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)\s*")


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


def check_rare(campaign: Campaign, event: Event) -> None:
    """Raise InputError if a campaign has no place for a rare event's cases."""
    if campaign.sampling != "random" or campaign.cases is None or campaign.cases % 10:
        given = f"cases = {campaign.cases}, sampling = {campaign.sampling!r}"
        raise InputError(f"{campaign.path.name}: campaign: {given}: a rare event needs sampling = \"random\" and cases,"
                         " the runs of a level, a multiple of 10")  # fmt: skip
    if len(campaign.systems) != 1 or not (campaign.inputs or campaign.branch_seeds):
        raise InputError(f"{campaign.path.name}: a rare event needs one system under [systems], and inputs")
    if not campaign.branch_seeds and (fixed := [one.name for one in campaign.inputs if one.kind == "spacecraft"]):
        raise InputError(f"{campaign.path.name}: input.{fixed[0]}: each value of a spacecraft file needs FMUs of its"
                         " own, and chains draw new ones at every level; leave it out")  # fmt: skip
    if campaign.branch_seeds:
        _check_branches(campaign, event)


def _check_branches(campaign: Campaign, event: Event) -> None:
    name, source = event.metric.name, campaign.sources[event.metric.name]
    take = "max" if event.above else "min"
    if not source.of_signal or source.take != take or source.window in ("steady", "slew"):
        raise InputError(f"{campaign.path.name}: metric.{name}: with branch_seeds, `{event.text}` needs a metric of a"
                         f' signal with take = "{take}", over all or [from, to]')  # fmt: skip
    for one in campaign.inputs:
        if shared := set(one.targets) & set(campaign.branch_seeds):
            raise InputError(f"{campaign.path.name}: input.{one.name}: {shared.pop()} is in branch_seeds, which give"
                             " each run its own seeds; leave one out")  # fmt: skip
