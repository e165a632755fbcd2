"""A disk that is full: the run says so, what was recorded is readable, and an earlier run is kept."""

import json
import subprocess
import tomllib
from contextlib import suppress

import numpy as np
import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, InputError, RunError, System, read_signals, simulate
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.results.run_record import end_run_record, write_run_record

START = {"u": 0.0, "offset": 0.0, "number": 0, "flag": False}


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Return a system of one FMU that runs long."""
    fmu = wanderer(tmp_path_factory.mktemp("system"), "good")
    part = Component(name="a", source=fmu, period=1_000_000, kind="sampled", isolated=False, parameters=START)
    return System(name="one", tick=1_000_000, stop_time=10**14, components=(part,), connections=())


@pytest.fixture
def disk(tmp_path):
    """Return a folder that is a disk of 300 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=300k", "none", folder]
    if subprocess.run(command, check=False, capture_output=True).returncode != 0:
        pytest.skip("a small disk can be mounted by root only")
    yield folder
    subprocess.run(["umount", folder], check=True)


def fill(disk):
    with (disk / "filler").open("wb", buffering=0) as filler, suppress(OSError):
        while filler.write(bytes(512)):
            pass


def assert_failed(folder, signals):
    run = tomllib.loads((folder / "run.toml").read_text())
    assert run["status"] == "failed"
    assert run["reason"].startswith(f"cannot write to {folder}: No space left on device, after ")
    np.testing.assert_array_equal(signals["a.steps"], np.arange(len(signals.time)) + 1)
    assert len(signals.time) <= round(run["simulated_time"] * 1000)
    for line in (folder / "events.jsonl").read_text().splitlines():
        json.loads(line)  # whole lines only


@pytest.mark.parametrize("where", ["", "out"], ids=["mount point", "folder"])
def test_the_record_says_that_the_run_failed_and_rows_are_readable(system, disk, where):
    with pytest.raises(RunError, match=r"No space left on device, after [\d.]+ s simulated; what was written before"):
        simulate(system, disk / where)
    signals = read_signals(disk / where)
    assert len(signals.time) >= 3000  # of 48 bytes and the batches' headers; a second may be lacking
    assert_failed(disk / where, signals)
    assert sorted(path.name for path in (disk / where).iterdir()) == ["events.jsonl", "run.toml", "signals.arrows"]


def test_a_checkpoint_on_a_full_disk_ends_the_run_and_earlier_ones_are_kept(system, disk):
    with pytest.raises(RunError, match="No space left on device"):
        simulate(system, disk / "out", checkpoints=CheckpointSchedule(every=0.5))
    assert_failed(disk / "out", read_signals(disk / "out"))
    names = [path.name for path in (disk / "out/checkpoints").iterdir()]
    assert names
    assert not [name for name in names if name.startswith(".")]


def test_an_earlier_run_is_kept_if_there_is_no_room_for_the_record_of_another(system, disk):
    simulate(system, disk / "out", stop_time=1.0)
    before = {path.name: path.read_bytes() for path in (disk / "out").iterdir()}
    fill(disk)
    with pytest.raises(InputError, match=r"cannot be made \(No space left on device\); choose another folder"):
        simulate(system, disk / "out", stop_time=1.0, overwrite=True)
    assert {path.name: path.read_bytes() for path in (disk / "out").iterdir()} == before


@pytest.mark.parametrize("reason", ["a reason", "a long reason " * 100])
def test_how_a_run_ended_takes_no_further_space(disk, reason):
    content = {"status": "running", "simulated_time": 0.0, "system": {"name": "x" * 3000}}  # to the end of a block
    write_run_record(disk, content)
    fill(disk)
    ended = content | {"status": "failed", "simulated_time": 12.25}
    end_run_record(disk, ended | {"reason": reason})
    kept = reason if len(reason) < 1000 else f"{reason[:200]}..."
    assert tomllib.loads((disk / "run.toml").read_text()) == ended | {"reason": kept}
    assert sorted(path.name for path in disk.iterdir()) == ["filler", "run.toml"]
