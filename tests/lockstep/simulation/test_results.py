"""What `simulate` returns: signals as a mapping, in memory or read when they are used; and what Python users expect."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import flexbench
import flexsat
import lockstep
from lockstep import InputError, RunOptions, read_signals, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule


@pytest.fixture(scope="module")
def results(triple, tmp_path_factory):
    """Return the results in memory, and those with a folder."""
    folder = tmp_path_factory.mktemp("results") / "out"
    return simulate(triple), simulate(triple, folder, checkpoints=CheckpointSchedule(times=["0.03"]))


def test_signals_in_memory_are_those_of_the_folder(results):
    memory, on_disk = results
    read = read_signals(on_disk.folder)
    assert memory.folder is None
    for found in (memory, memory.signals, on_disk, on_disk.signals):
        assert list(found) == list(read.columns)
        assert len(found) == 12
        np.testing.assert_array_equal(found.time, read.time)
        for name, values in found.items():
            np.testing.assert_array_equal(values.view(np.int64), read[name].view(np.int64), name)
    assert memory.signals.units == read.units
    assert (memory.rows, memory.ticks, memory.simulated_time) == (on_disk.rows, on_disk.ticks, on_disk.simulated_time)


def test_names_that_were_not_recorded_are_refused(results):
    for found in results:
        assert "a.y" in found
        assert "a.z" not in found
        assert found.get("a.z") is None
        with pytest.raises(InputError, match=r"a\.begun: not recorded; there are a\.y, .*; did you mean a\.began\?"):
            found["a.begun"]


def test_results_and_what_else_is_not_running_is_pickled(results, triple):
    for found in (*results, *(one.signals for one in results)):
        again = pickle.loads(pickle.dumps(found))
        assert list(again) == list(found)
        np.testing.assert_array_equal(again["p.y"], found["p.y"])
    for value in (triple, RunOptions(stop_time=1.0)):
        assert pickle.loads(pickle.dumps(value)) == value


def test_columns_are_read_when_they_are_used(triple, tmp_path):
    found = simulate(triple, tmp_path / "out")
    first = found["a.y"]
    (tmp_path / "out/signals.parquet").rename(tmp_path / "moved")
    assert found["a.y"] is first  # each once
    with pytest.raises(InputError, match=r"holds no signals\.parquet"):
        found["b.y"]


def test_a_branch_in_memory_goes_on_from_a_checkpoint(results, triple):
    memory, on_disk = results
    checkpoint = read_checkpoint(on_disk.folder / "checkpoints/t=0.03.ckpt")
    branch = simulate(triple, restart=Restart(checkpoint=checkpoint))
    np.testing.assert_array_equal(branch["p.y"], memory["p.y"][30:])
    with pytest.raises(InputError, match="checkpoints: are files of a results folder; give a folder, or use snapshots"):
        simulate(triple, checkpoints=CheckpointSchedule(times=["0.03"]))


def test_one_line_describes_each(results, triple):
    memory, on_disk = results
    assert repr(memory) == "<RunSummary: 0.06 s in 60 ticks, 61 rows in memory>"
    assert repr(on_disk) == f"<RunSummary: 0.06 s in 60 ticks, 61 rows in {on_disk.folder}>"
    assert repr(memory.signals).startswith(
        "<Signals: 12 of a.y, a.began, a.steps, a.odd, and 8 more; 61 rows, 0 to 0.06 s"
    )
    assert repr(triple) == "<System triple: a, b, p; 6 connections, tick 0.001 s>"
    assert repr(RunOptions(stop_time=1.0)) == "RunOptions(stop_time=1.0)"
    with lockstep.open(triple) as run:
        run.step()
        assert repr(run) == "<Run of triple: 0.001 of 0.06 s, in memory, open>"
    assert repr(run) == "<Run of triple: 0.001 of 0.06 s, in memory, is closed>"


def test_tab_offers_names(results, triple):
    for found in results:
        assert {"a.y", "p.odd"} <= set(found._ipython_key_completions_())
    with lockstep.open(triple) as run:
        assert {"a.y", "a.gain", "p.u"} <= set(run._ipython_key_completions_())
        assert {"step", "run_until", "time", "snapshot", "restore", "set", "signals"} <= set(dir(run))
    assert set(lockstep.__all__) <= set(dir(lockstep))
    assert all(hasattr(lockstep, name) for name in dir(lockstep))


def test_the_packages_are_typed():
    for package in (lockstep, flexsat, flexbench):
        assert Path(package.__file__).with_name("py.typed").is_file()
