"""A start time other than 0: simulated time begins there, and all times that are given or recorded are absolute."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from lockstep import InputError, load_system, read_signals, resume, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.faults.read import read_scenario
from lockstep.shadow.component import with_shadow

MS = 1_000_000
START = 2500 * MS
FAULT = '[[fault]]\nconnection = "b.u"\nkind = "bias"\nvalue = 0.5\nfrom = {}\nto = {}\n'
OTHERS = ("a.y", "b.y", "p.y", "a.steps", "b.odd", "p.steps")  # not the times


@pytest.fixture
def late(triple):
    return replace(triple, start_time=START, stop_time=START + 60 * MS)


def events(folder, kind):
    lines = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    return [line for line in lines if line["event"] == kind]


def test_times_begin_at_the_start_time_and_values_stay(late, whole, tmp_path):
    summary = simulate(late, tmp_path / "out")
    signals, first = read_signals(tmp_path / "out"), read_signals(whole)

    assert (summary.start_time, summary.simulated_time, summary.rows) == (2.5, 2.56, 61)
    assert signals.time.tolist() == [(2500 + k) / 1000 for k in range(61)]
    assert signals["a.began"].tolist() == [(2500 + k // 2 * 2) / 1000 for k in range(61)]
    assert signals["p.began"][0] == 2.5  # the start time of SetupExperiment
    for name in OTHERS:
        np.testing.assert_array_equal(signals[name].view(np.int64), first[name].view(np.int64), name)
    assert [e["time"] for kind in ("start", "end") for e in events(tmp_path / "out", kind)] == [2.5, 2.56]
    assert tomllib.loads((tmp_path / "out/run.toml").read_text())["start_time"] == 2.5


def test_faults_and_switchover_are_at_absolute_times(late, triple, fmus, tmp_path):
    runs = {}
    for name, system, start in (("zero", triple, 0.0), ("late", late, 2.5)):
        (tmp_path / "faults.toml").write_text(FAULT.format(start + 0.02, start + 0.03))
        over = system.start_time + 40 * MS
        shadowed = with_shadow(system, "a", fmus["good"], switchover=over, blend=10 * MS)
        faults, other = [read_scenario(tmp_path / "faults.toml")], {"a.shadow.gain": 3.0}
        simulate(shadowed, tmp_path / name, faults=faults, overrides=other)
        runs[name] = read_signals(tmp_path / name)
    for name in (*OTHERS, "a.shadow.y", "a.residual.y"):
        np.testing.assert_array_equal(runs["late"][name], runs["zero"][name], name)
    assert [e["time"] for e in events(tmp_path / "late", "fault")] == [2.52, 2.53]
    assert [e["time"] for e in events(tmp_path / "late", "switchover")] == [2.54]
    early = (tmp_path / "faults.toml").write_text(FAULT.format(1.0, 2.51)) and read_scenario(tmp_path / "faults.toml")
    with pytest.raises(InputError, match=r"begins at 1 s, and the run at 2\.5 s; choose a window inside the run"):
        simulate(late, tmp_path / "no", faults=[early])
    with pytest.raises(InputError, match=r"switchover 0\.04 s: the run begins at 2\.5 s; choose a later time"):
        simulate(with_shadow(triple, "a", fmus["good"], switchover=40 * MS).with_start_time(START), tmp_path / "no",
                 stop_time=3.0)  # fmt: skip


def test_checkpoints_are_at_absolute_times_and_need_the_same_start(late, tmp_path):
    out = tmp_path / "out"
    simulate(late, out, checkpoints=CheckpointSchedule(times=["2.523"], every=0.05))
    assert sorted(path.name for path in (out / "checkpoints").iterdir()) == ["t=2.523.ckpt", "t=2.55.ckpt"]
    restart = Restart(checkpoint=read_checkpoint(out / "checkpoints/t=2.523.ckpt"))
    summary = simulate(late, tmp_path / "branch", restart=restart)
    mine, full = read_signals(tmp_path / "branch"), read_signals(out)
    assert (summary.start_time, summary.rows) == (2.523, 38)
    for name, values in mine.columns.items():
        np.testing.assert_array_equal(values, full[name][23:], name)
    with pytest.raises(InputError, match=r"made with another start time: 2\.5 s there, 2\.4 s here"):
        simulate(late.with_start_time(2400 * MS), tmp_path / "no", restart=restart)
    with pytest.raises(InputError, match=r"checkpoint 2 s: lies before the start time 2\.5 s"):
        simulate(late, tmp_path / "no", checkpoints=CheckpointSchedule(times=[2.0]))
    with pytest.raises(InputError, match=r"stop time 1 s: must be after the start time, 2\.5 s"):
        simulate(late, tmp_path / "no", stop_time=1.0)


def test_the_command_line_sets_the_start_time_and_a_run_is_resumed_from_its_record(triple, tmp_path, capsys):
    write_ssd(replace(triple, start_time=1000 * MS, stop_time=1060 * MS), tmp_path / "triple.ssd")
    assert load_system(tmp_path / "triple.ssd").start_time == 1000 * MS
    out = tmp_path / "out"
    words = ["run", str(tmp_path / "triple.ssd"), "--start-time", "1.02", "--checkpoint", "1.041", "--out", str(out)]
    shared = [word for name in "abp" for word in ("--share-process", name)]
    assert main([*words, *shared]) == 0
    assert capsys.readouterr().out.startswith("0.04 s simulated, from 1.02 s on in ")
    signals = read_signals(out)
    assert (signals.time[0], signals.time[-1], len(signals.time)) == (1.02, 1.06, 41)
    before, record = (out / "signals.parquet").read_bytes(), out / "run.toml"
    record.write_text(record.read_text().replace('status = "completed"', 'status = "running"'))
    assert resume(out).start_time == 1.041
    assert (out / "signals.parquet").read_bytes() == before


def test_a_run_may_begin_before_0(triple, whole, tmp_path):
    system = replace(triple, start_time=-20 * MS, stop_time=10 * MS)
    simulate(system, tmp_path / "out", checkpoints=CheckpointSchedule(times=["-0.005"]))
    signals = read_signals(tmp_path / "out")
    assert signals.time.tolist() == [(k - 20) / 1000 for k in range(31)]
    np.testing.assert_array_equal(signals["b.y"], read_signals(whole)["b.y"][:31])
    assert read_checkpoint(tmp_path / "out/checkpoints/t=-0.005.ckpt").time == -5 * MS
