"""Snapshots: a run that goes back, or branches, goes on bit by bit as the one that never did."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest

import lockstep
from lockstep import InputError, read_signals, simulate
from lockstep.faults.read import read_scenario
from lockstep.shadow.component import with_shadow

FAULTS = """
[[fault]]
name = "held"
connection = "a.u"
kind = "stuck"
from = 0.012
to = 0.045

[[fault]]
name = "late"
connection = "b.u"
kind = "delay"
ticks = 9
from = 0.0
to = 0.05

[[fault]]
name = "stronger"
parameter = "p.gain"
kind = "scale"
factor = 2.0
from = 0.02
to = 0.03
"""


def assert_equal(one, other):
    assert list(one) == list(other)
    np.testing.assert_array_equal(one.time, other.time)
    for name in one:
        np.testing.assert_array_equal(one[name].view(np.int64), other[name].view(np.int64), name)


@pytest.fixture
def scenario(tmp_path):
    (tmp_path / "faults.toml").write_text(FAULTS)
    return read_scenario(tmp_path / "faults.toml")


@pytest.mark.parametrize("tick", ["c", "python"])
@pytest.mark.parametrize("folder", [False, True], ids=["memory", "folder"])
def test_a_run_that_went_back_has_the_rows_and_events_of_one_that_did_not(triple, scenario, tmp_path, tick, folder):
    options = {"faults": [scenario], "record_period": 0.002, "record": ["all", "p.gain", "b.u"], "tick": tick}
    simulate(triple, tmp_path / "whole", **options)
    with lockstep.open(triple, tmp_path / "stepped" if folder else None, **options) as run:
        for back in (0.0, 0.013, 0.021, 0.022, 0.029, 0.046):  # before, in, and after the windows
            run.run_until(back)
            kept = run.snapshot()
            run.step(11)  # over the end of a window, and of a cycle
            assert run.time != back
            run.restore(kept)
            assert run.time == back
        run.run_until(0.06)
    assert_equal(run.signals, read_signals(tmp_path / "whole"))
    expected = [json.loads(line) for line in (tmp_path / "whole/events.jsonl").read_text().splitlines()]
    assert run.events == expected
    assert len([event for event in expected if event["event"] == "fault"]) == 6


def test_branches_of_one_snapshot_are_independent(triple):
    with lockstep.open(triple) as run:
        run.run_until(0.02)
        kept = run.snapshot()
        rows = {}
        for gain in (1.0, 3.0, 1.0):
            run.restore(kept)
            run.set("a.gain", gain)
            run.run_until(0.04)
            assert run["a.gain"] == gain
            again = rows.setdefault(gain, run.signals)
            assert_equal(run.signals, again)
        assert not np.array_equal(rows[1.0]["a.y"], rows[3.0]["a.y"])
        np.testing.assert_array_equal(rows[1.0]["a.y"][:20], rows[3.0]["a.y"][:20])


def test_a_snapshot_of_a_branch_that_was_left_is_restored_with_its_rows(triple):
    with lockstep.open(triple) as run:
        run.run_until(0.02)
        start = run.snapshot()
        run.set("a.gain", 3.0)
        run.run_until(0.03)
        left, rows = run.snapshot(), run.signals
        run.restore(start)
        run.run_until(0.05)
        run.restore(left)
        assert (run.time, run["a.gain"]) == (0.03, 3.0)
        assert_equal(run.signals, rows)


def test_with_a_folder_a_branch_that_was_left_is_refused(triple, tmp_path):
    with lockstep.open(triple, tmp_path / "out") as run:
        run.run_until(0.02)
        start = run.snapshot()
        run.run_until(0.03)
        left = run.snapshot()
        run.restore(start)
        run.run_until(0.05)
        with pytest.raises(InputError, match=r"at 0\.03 s .*: its rows were replaced when the run went back before it"):
            run.restore(left)
        run.restore(start)
        run.run_until(0.06)
    assert_equal(run.signals, simulate(triple).signals)


def test_another_run_of_the_system_goes_on_from_a_pickled_snapshot(triple, tmp_path):
    with lockstep.open(triple) as run:
        run.run_until(0.025)
        kept = pickle.loads(pickle.dumps(run.snapshot()))
        assert repr(kept).startswith("<Snapshot at 0.025 s of a, b, p: ")
    whole = simulate(triple).signals
    for folder in (None, tmp_path / "branch"):
        with lockstep.open(triple, folder, overrides={"a.gain": 9.0}) as branch:
            branch.restore(kept)
            branch.run_until(0.06)
        np.testing.assert_array_equal(branch.signals.time, whole.time[25:])
        np.testing.assert_array_equal(branch.signals["p.y"], whole["p.y"][25:])


def test_states_of_fmus_in_processes_and_of_shadows_are_kept(triple, fmus):
    parts = tuple(replace(c, isolated=c.name == "p") for c in triple.components)
    shadowed = with_shadow(
        replace(triple, components=parts), "a", fmus["good"], switchover=30_000_000, blend=10_000_000
    )
    whole = simulate(shadowed).signals
    with lockstep.open(shadowed) as run:
        run.run_until(0.028)
        kept = run.snapshot()
        run.run_until(0.036)  # over the switchover, into the blend
        later = run.snapshot()
        run.run_until(0.05)
        run.restore(kept)
        run.run_until(0.036)
        run.restore(later)
        run.run_until(0.06)
    assert_equal(run.signals, whole)


def test_a_run_at_its_stop_time_goes_back(triple):
    with lockstep.open(triple) as run:
        run.run_until(0.05)
        kept = run.snapshot()
        run.run_until(0.06)
        rows = run.signals
        assert len(rows.time) == 61
        run.restore(kept)
        run.run_until(0.06)
        assert_equal(run.signals, rows)


def test_what_is_restored_has_to_fit(triple, scenario):
    with lockstep.open(triple) as run, lockstep.open(triple, record=["a.y"]) as other:
        kept = run.snapshot()
        with pytest.raises(InputError, match="its run had another recording; restore it in a run that is opened alike"):
            other.restore(kept)
    with lockstep.open(triple, faults=[scenario]) as run, pytest.raises(InputError, match="another faults"):
        run.restore(kept)
    with lockstep.open(triple, overrides={"a.seed": 8}) as run, pytest.raises(InputError, match="another system"):
        run.restore(kept)


def test_fmus_without_states_are_named(triple, fmus):
    parts = tuple(replace(c, source=fmus["mute"]) if c.name == "b" else c for c in triple.components)
    with lockstep.open(replace(triple, components=parts)) as run:
        run.step()
        with pytest.raises(InputError, match=r"b: cannot save its state \(canGetAndSetFMUstate"):
            run.snapshot()
        run.step()
