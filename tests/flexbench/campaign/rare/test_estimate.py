"""Rare events on the engine: their levels are those of the runs, the same after an interruption; what is refused."""

import json
import math

import numpy as np
import pytest
from scipy.stats import spearmanr

from flexbench.campaign.campaign import read_entries
from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.rare.estimate import RARE, run_rare
from flexbench.campaign.rare.event import Event, parse_event
from flexbench.campaign.rerun import rerun
from flexbench.campaign.result_file import read_results
from flexbench.campaign.samples import load_samples
from flexbench.campaign.statistics.sample import Metric
from flexbench.engine.pools import LocalPool
from lockstep import InputError

TABLES = """
[input.seed]
parameter = "a.seed"
distribution = "case"

[input.u]
parameter = "a.u"
distribution = "norm"
loc = 1.0
scale = 0.5

[metric.begin]
of = "a.y"
take = "max"
window = [0.0, 0.0005]
"""
EVENT = "begin > 1.9"


def quiet(_):
    pass


def pool(settings):
    return LocalPool(settings, 1)


def test_levels_are_those_of_the_runs_and_the_same_bytes_come_after_an_interruption(campaign_file, tmp_path):
    path = campaign_file("cases = 20", TABLES)
    event, found = run_rare(path, EVENT, tmp_path / "out", pool, quiet)

    assert found.reached
    assert 0.001 < found.probability < 0.3  # that of 20 runs a level; how accurate it is, tests of the statistics show
    assert found.runs == len(read_entries(tmp_path / "out")) == 20 + 18 * (len(found.levels) - 1)
    results = read_results(tmp_path / "out")
    begin = results.metrics["begin"]
    assert found.levels[0].threshold == np.sort(begin[:20])[18]  # two of twenty are at or above it
    assert found.levels[-1].threshold == event.threshold
    assert np.sum(begin > event.threshold) >= 2
    assert spearmanr(begin, results.inputs["u"]).statistic > 0.8
    assert len(set(results.inputs["seed"])) > 20  # drawn anew as often as kept
    assert rerun(tmp_path / "out", found.runs).same
    assert load_samples(tmp_path / "out").content["sampling"] == "subset-simulation"

    other = tmp_path / "other"
    for name in ("campaign.json", "campaign.toml"):
        other.mkdir(exist_ok=True)
        (other / name).write_bytes((tmp_path / "out" / name).read_bytes())
    (journal,) = (tmp_path / "out" / "journal").iterdir()
    (other / "journal").mkdir()
    lines = journal.read_bytes().splitlines(keepends=True)
    (other / "journal" / journal.name).write_bytes(b"".join(lines[:25]) + lines[25][:40])  # killed in a line
    run_rare(path, EVENT, other, pool, quiet)
    for name in (RARE, "results.parquet"):
        assert (other / name).read_bytes() == (tmp_path / "out" / name).read_bytes()
    with pytest.raises(InputError, match="holds another campaign, event or version"):
        run_rare(path, "begin > 2", other, pool, quiet)
    content = json.loads((other / RARE).read_text())
    assert content["low"] < content["probability"] < content["high"]


def test_an_event_is_beyond_or_below_a_limit_in_the_shown_unit(campaign_file):
    campaign = read_campaign(campaign_file("cases = 10", TABLES))
    below = parse_event(" begin < -1.5e1 ", campaign)
    assert (below.text, below.limit, below.above, below.threshold) == ("begin < -1.5e1", -15.0, False, 15.0)
    assert below.response(-16.0) > below.threshold > below.response(-14.0)
    assert below.response(None) == math.inf  # a lost run is the event
    scaled = Event(
        text="", metric=Metric(name="x", unit="rad", shown_unit="arcsec", scale=5e-6), limit=1e-5, above=True
    )
    assert scaled.response(2e-5) > scaled.threshold
    for text in ("begin", "begin > ", "begin >= 3", "end > 3", "begin > 3 rad"):
        with pytest.raises(InputError, match=r"must be METRIC > VALUE .*; metrics are largest"):
            parse_event(text, campaign)


@pytest.mark.parametrize(
    ("campaign", "message"),
    [("cases = 15", "cases, the runs of a level, a multiple of 10"),
     ('cases = 16\nsampling = "sobol"', 'sampling = "random"')],
)  # fmt: skip
def test_a_campaign_without_room_for_levels_is_refused(campaign_file, tmp_path, campaign, message):
    with pytest.raises(InputError, match=message):
        run_rare(campaign_file(campaign, TABLES), "begin > 2", tmp_path / "out", pool, quiet)
