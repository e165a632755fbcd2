"""Branches of runs of an FMU: from saved states, the same as simulated from the start; the same bytes resumed."""

import json
from dataclasses import replace

import pytest

from flexbench.campaign.campaign import read_entries
from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.orders import prepare
from flexbench.campaign.rare import branch_flight
from flexbench.campaign.rare.branch_flight import BranchOrder, fly_branch, unpacked_rises
from flexbench.campaign.rare.estimate import RARE, level_rows, run_rare, sentence
from flexbench.campaign.rerun import rerun
from flexbench.campaign.result_file import read_results
from flexbench.engine.pools import LocalPool
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, InputError, System, write_ssd

EVENT = "highest > 1.05"
FILE = """
[campaign]
cases = 20
stop_time = 0.05
record_period = 0.002
branch_seeds = ["a.seed"]

[systems]
toy = "toy.ssd"

[input.u]
parameter = "a.u"
distribution = "norm"
scale = 0.1

[metric.highest]
of = "a.y"
take = "max"
"""


def quiet(_):
    pass


def pool(settings):
    return LocalPool(settings, 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a system of one FMU whose seed is tunable, and a campaign."""
    folder = tmp_path_factory.mktemp("branches")
    part = Component(name="a", source=wanderer(folder, "reseeded", "RESEEDS"), period=1_000_000, kind="sampled",
                     isolated=False, parameters={"offset": 0.0, "number": 0, "flag": False})  # fmt: skip
    write_ssd(System(name="toy", tick=1_000_000, stop_time=10**8, components=(part,), connections=()),
              folder / "toy.ssd")  # fmt: skip
    (folder / "toy.toml").write_text(FILE)
    return folder


def test_a_branch_from_a_saved_state_is_the_one_simulated_from_the_start(folder, tmp_path, monkeypatch):
    orders = prepare(read_campaign(folder / "toy.toml"), tmp_path, quiet)
    paths = {file: tmp_path / "files" / file.name for file in orders.files_of(1)}
    seeds = (11, 2**30 + 5, 77)

    def flown(*lineage):
        order = BranchOrder(order=orders.order(1), lineage=lineage, seeds=("a.seed",), metric="highest", sign=1.0)
        return fly_branch(order, paths)

    lineage = tuple(zip((0, 11, 25), seeds, strict=True))
    found = {}
    for most in (0, 10**9):  # no saved state is kept; all are
        states = branch_flight._States(most)
        monkeypatch.setattr(branch_flight, "_states", states)
        found[most] = [flown(*lineage[:depth]) for depth in (1, 2, 3)]
        assert len(states._states) == (2 if most else 0)
    assert found[0] == found[10**9]
    first, second, third = (unpacked_rises(one.rises) for one in found[0])
    assert first.ticks[0] == 0
    assert second.ticks[0] == 12  # the first row after the branch: rows are 2 ticks apart
    assert third.ticks[0] == 26
    assert [one.simulated_time for one in found[0]] == pytest.approx([0.05, 0.039, 0.025])
    assert len({one.rows_sha256 for one in found[0]}) == 3
    again = flown((0, seeds[0]), (11, seeds[0] + 1))
    assert again.rises != found[0][1].rises  # other noise


def test_levels_are_those_of_the_runs_and_the_same_bytes_come_after_an_interruption(folder, tmp_path):
    path = folder / "toy.toml"
    event, found = run_rare(path, EVENT, tmp_path / "out", pool, quiet)
    assert found.reached
    assert 0.0 < found.probability < 0.2
    assert found.runs == len(read_entries(tmp_path / "out")) > 20
    results = read_results(tmp_path / "out")
    highest = results.metrics["highest"]
    assert found.levels[0].threshold == sorted(highest[:20])[9]
    assert sum(highest > event.limit) >= len(found.responses)
    assert len(set(results.inputs["u"])) <= 20  # branches keep the inputs of the run that they descend from
    assert results.about["sampling"] == "splitting"
    assert "families" in level_rows(event, found)[0]
    assert f"{found.runs} runs" in sentence(event, found)
    assert "that is no estimate" in sentence(event, replace(found, reached=False))
    with pytest.raises(InputError, match="run 3: a branch of a rare event cannot be repeated"):
        rerun(tmp_path / "out", 3)

    other = tmp_path / "other"
    (other / "journal").mkdir(parents=True)
    (journal,) = (tmp_path / "out/journal").iterdir()
    lines = journal.read_bytes().splitlines(keepends=True)
    (other / "journal" / journal.name).write_bytes(b"".join(lines[:30]) + lines[30][:40])  # killed in a line
    run_rare(path, EVENT, other, lambda settings: LocalPool(settings, 2), quiet)
    for name in (RARE, "results.parquet"):
        assert (other / name).read_bytes() == (tmp_path / "out" / name).read_bytes()
    assert json.loads((other / RARE).read_text())["runs"] == found.runs


@pytest.mark.parametrize(
    ("old", "new", "event", "message"),
    [('"a.seed"', '"a.sleep_at"', EVENT, "branch_seeds: a.sleep_at: no tunable parameter of the system"),
     ('take = "max"', 'take = "rms"', EVENT, r'needs a metric of a signal with take = "max", over all or \[from, to\]'),
     ("", "", "highest < 0", 'needs a metric of a signal with take = "min"'),
     ('"a.u"', '"a.seed"', EVENT, "input.u: a.seed is in branch_seeds")],
)  # fmt: skip
def test_what_cannot_be_branched_is_refused(folder, tmp_path, old, new, event, message):
    (folder / "wrong.toml").write_text(FILE.replace(old, new))
    with pytest.raises(InputError, match=message):
        run_rare(folder / "wrong.toml", event, tmp_path / "out", pool, quiet)
