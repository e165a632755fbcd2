"""Runs that were killed and go on: the same bytes as if they had not been; and files that are no checkpoints."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
import zipfile

import numpy as np
import pytest

from lockstep import InputError, read_signals, simulate
from lockstep.__main__ import main
from lockstep.checkpoint.file import FORMAT, newest_checkpoint, read_checkpoint
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.simulation import resume

COMMAND = [sys.executable, "-W", "error", "-m", "lockstep", "run"]


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def start(triple_ssd, out, environment):
    """Start a run at the pace of the clock, and return it once a checkpoint is there and rows are on disk."""
    options = (
        "--stop-time",
        "4.1",
        "--checkpoint-every",
        "0.55",
        "--pace",
        "4",
        "--share-process",
        "a",
        "--isolate",
        "p",
    )
    process = subprocess.Popen(
        [*COMMAND, triple_ssd, "--out", out, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )
    deadline = time.monotonic() + 60.0
    while not (out / "checkpoints/t=1.1.ckpt").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return process


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_was_ended_goes_on_and_leaves_the_same_bytes(triple, triple_ssd, tmp_path, cli, how):
    out = tmp_path / "out"
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    environment = os.environ | {"TMPDIR": str(temporary)}
    process = start(triple_ssd, out, environment)
    if how == signal.SIGKILL:
        with pytest.raises(InputError, match="its run is still going on; end it before it is resumed"):
            resume(out)
    process.send_signal(how)
    process.communicate(timeout=60)
    status = tomllib.loads((out / "run.toml").read_text())["status"]
    assert status == {signal.SIGKILL: "running", signal.SIGINT: "interrupted"}[how]
    with (out / "events.jsonl").open("a") as stream:
        stream.write('{"time": 9.0, "event": "cut off"}\n')  # after the checkpoint
    newest = newest_checkpoint(out)
    (out / "checkpoints/.t=9.ckpt.partial").write_text("half of one")  # was being written

    assert len(list(temporary.iterdir())) == (1 if how == signal.SIGKILL else 0)

    done = cli("run", "--resume", out, env=environment)

    assert done.returncode == 0, done.stderr
    at = read_checkpoint(newest).time / 1e9
    simulate(triple, tmp_path / "whole", stop_time=4.1)
    assert (out / "signals.parquet").read_bytes() == (tmp_path / "whole/signals.parquet").read_bytes()
    assert sorted(path.name for path in out.iterdir()) == ["checkpoints", "events.jsonl", "run.toml", "signals.parquet"]
    assert list(temporary.iterdir()) == []  # that of the killed process too
    written = [(event["event"], event["time"]) for event in events(out)]
    every = [("checkpoint", t) for t in (0.55, 1.1, 1.65, 2.2, 2.75, 3.3, 3.85)]
    before = [event for event in every if event[1] <= at]
    assert written == [("start", 0.0), *before, ("resume", at), *every[len(before) :], ("end", 4.1)]
    run = tomllib.loads((out / "run.toml").read_text())
    assert (run["status"], run["simulated_time"], [r["time"] for r in run["resumed"]]) == ("completed", 4.1, [at])
    assert read_checkpoint(out / "checkpoints/t=3.85.ckpt").header["rows"] == 3500  # 350 more are not on disk yet
    with pytest.raises(InputError, match=r"its run is complete, .*; branch from .*t=3\.85\.ckpt with --restart-from"):
        resume(out)


def test_a_failed_run_without_a_checkpoint_cannot_be_resumed(triple, tmp_path):
    with pytest.raises(InputError, match=r"holds no run\.toml; give the folder of a run"):
        resume(tmp_path)
    simulate(triple, tmp_path / "out")
    text = (tmp_path / "out/run.toml").read_text()
    (tmp_path / "out/run.toml").write_text(text.replace('"completed"', '"running"'))
    with pytest.raises(InputError, match="holds no checkpoint; run it anew, with --checkpoint-every"):
        resume(tmp_path / "out")


def test_a_resumed_run_takes_no_other_options(tmp_path, capsys):
    assert main(["run", "--resume", str(tmp_path), "--set", "a.gain=2"]) == 2
    message = "lockstep: --set: a resumed run continues unchanged; leave it out, or branch with --restart-from\n"
    assert capsys.readouterr().err == message


def test_a_system_made_in_python_has_to_be_handed_over(triple, tmp_path):
    out = tmp_path / "out"
    simulate(triple, out, checkpoints=CheckpointSchedule(times=["0.025"]))
    before = (out / "signals.parquet").read_bytes()
    text = (out / "run.toml").read_text()
    (out / "run.toml").write_text(text.replace('"completed"', '"failed"'))
    with pytest.raises(InputError, match="system triple: was made in Python"):
        resume(out)
    assert (out / "signals.parquet").read_bytes() == before
    resume(out, triple)
    assert (out / "signals.parquet").read_bytes() == before


def test_rows_that_are_lacking_are_told_before_anything_changes(triple, tmp_path):
    out = tmp_path / "out"
    simulate(triple, out, stop_time=1.2, checkpoints=CheckpointSchedule(times=["1.1"]))
    simulate(triple, tmp_path / "short", stop_time=0.5)
    text = (out / "run.toml").read_text().replace('"completed"', '"running"')
    (out / "run.toml").write_text(text)
    (out / "signals.parquet").write_bytes((tmp_path / "short/signals.parquet").read_bytes())
    with pytest.raises(InputError, match=r"out: has 501 rows recorded, and t=1\.1\.ckpt needs 1000; remove"):
        resume(out, triple)
    assert (out / "run.toml").read_text() == text
    assert sorted(path.name for path in out.iterdir()) == ["checkpoints", "events.jsonl", "run.toml", "signals.parquet"]
    assert len(read_signals(out).time) == 501


def changed(path, target, **header):
    """Copy a checkpoint with another header."""
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "header.json":
                content = json.dumps({k: v for k, v in (json.loads(content) | header).items() if v != "absent"})
            new.writestr(name, content)


def truncated(path, target):
    target.write_bytes(path.read_bytes()[:-200])


def flipped(path, target):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    target.write_bytes(content)


BROKEN = {
    "truncated": (truncated, "is no checkpoint, or was cut off"),
    "flipped": (flipped, "not a readable zip file .*Bad CRC"),
    "later version": (lambda p, t: changed(p, t, version=2), "is a checkpoint of version 2; this lockstep reads ver"),
    "other format": (lambda p, t: changed(p, t, format="a game"), "is no checkpoint, or was cut off; give"),
    "no tick": (
        lambda p, t: changed(p, t, tick="absent"),
        "is a damaged checkpoint: tick is missing; use another one",
    ),
    "text": (lambda _, t: t.write_text("hello"), "not a readable zip file"),
    "nothing": (lambda _, __: None, "no such checkpoint; there is .*t=0.031.ckpt"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_is_no_checkpoint_is_refused(whole, tmp_path, case):
    damage, message = BROKEN[case]
    folder = tmp_path / "out/checkpoints"
    folder.mkdir(parents=True)
    good = newest_checkpoint(whole)
    (folder / good.name).write_bytes(good.read_bytes())
    damage(good, folder / "bad.ckpt")
    with pytest.raises(InputError, match=message):
        read_checkpoint(folder / "bad.ckpt")


def test_a_checkpoint_says_what_it_is_of(whole):
    header = read_checkpoint(newest_checkpoint(whole)).header
    assert (header["format"], header["version"], header["tick"], header["time"]) == (FORMAT, 1, 31, 31_000_000)
    run = tomllib.loads((whole / "run.toml").read_text())
    for component in run["component"]:
        mine = header["identity"]["components"][component["name"]]
        assert (mine["sha256"], mine["parameters"]) == (component["sha256"], component["parameters"])
    waiting = read_checkpoint(newest_checkpoint(whole)).arrays["rows/waiting"]
    assert (header["rows"], waiting.dtype) == (0, np.uint8)  # the first second is not on disk yet
