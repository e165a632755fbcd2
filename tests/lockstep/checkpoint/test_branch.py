"""Runs that begin at a checkpoint: bit by bit those that never stopped, unless something is changed."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lockstep import InputError, RunError, load_system, read_signals, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.rebuild_system import system_of
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule

MS = 1_000_000


def branch(system, source, tick, folder, reinitialised=(), **options):
    restart = Restart(
        checkpoint=read_checkpoint(source / f"checkpoints/t={tick / 1000:g}.ckpt"), reinitialised=reinitialised
    )
    return simulate(system, folder, restart=restart, **options)


def assert_rest_is_equal(folder, whole):
    mine, full = read_signals(folder), read_signals(whole)
    rows = len(mine.time)
    np.testing.assert_array_equal(mine.time, full.time[-rows:])
    assert list(mine.columns) == list(full.columns)
    for name in mine.columns:
        np.testing.assert_array_equal(mine[name].view(np.int64), full[name][-rows:].view(np.int64), name)


@pytest.mark.parametrize("tick", range(20, 32))  # one cycle: every pattern of who is in the middle of a step
def test_a_branch_goes_on_bit_by_bit(triple, whole, tmp_path, tick):
    summary = branch(triple, whole, tick, tmp_path / "branch")
    rows = 61 - tick  # with the one at the stop time
    assert (summary.start_time, summary.ticks, summary.rows) == (tick / 1000, 60, rows)
    assert_rest_is_equal(tmp_path / "branch", whole)


def test_a_state_travels_between_processes(triple, isolated, whole, tmp_path):
    branch(isolated, whole, 25, tmp_path / "isolated")  # from the master's process into those of the workers
    assert_rest_is_equal(tmp_path / "isolated", whole)
    simulate(isolated, tmp_path / "again", checkpoints=CheckpointSchedule(times=["0.027"]))
    branch(triple, tmp_path / "again", 27, tmp_path / "back")  # and back to that of the master
    assert_rest_is_equal(tmp_path / "back", whole)


def test_the_command_line_branches_without_a_system_file(triple, triple_ssd, tmp_path, cli):
    options = ("--set", "a.gain=1.5", "--delay", "b:p=6", "--share-process", "a", "--record-period", "0.002")
    done = cli("run", triple_ssd, "--out", tmp_path / "whole", "--checkpoint", "0.023", *options)
    assert done.returncode == 0, done.stderr
    file = tmp_path / "whole/checkpoints/t=0.023.ckpt"
    done = cli("run", "--restart-from", file, "--out", tmp_path / "branch")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0.037 s simulated, from 0.023 s on in ")
    mine, full = read_signals(tmp_path / "branch"), read_signals(tmp_path / "whole")
    np.testing.assert_array_equal(mine.time, np.arange(24, 62, 2) / 1000)
    for name in mine.columns:
        np.testing.assert_array_equal(mine[name], full[name][12:], name)
    events = [json.loads(line) for line in (tmp_path / "branch/events.jsonl").read_text().splitlines()]
    assert [(e["event"], e["time"]) for e in events] == [("branch", 0.023), ("end", 0.06)]

    write_ssd(replace(triple, stop_time=80 * MS), triple_ssd)
    with pytest.raises(InputError, match=r"triple\.ssd: has changed since the run"):
        system_of(read_checkpoint(file).run)


def test_options_that_a_branch_would_not_heed_are_refused(triple, triple_ssd, whole, tmp_path, capsys):
    simulate(load_system(triple_ssd), tmp_path / "saved", checkpoints=CheckpointSchedule(times=["0.02"]))
    words = ["run", "--restart-from", str(tmp_path / "saved/checkpoints/t=0.02.ckpt"), "--out", str(tmp_path / "no")]
    for option, value in (("--within", str(tmp_path)), ("--tick", "0.001"), ("--sampled", "a"), ("--continuous", "p")):
        assert main([*words, option, value]) == 2
        expected = f"{option}: counts where a system file is read; name SYSTEM as well, or leave it out"
        assert expected in capsys.readouterr().err
    assert main([*words, "--step-size", "0.006"]) == 2  # of all: other periods than those of the checkpoint
    assert "period" in capsys.readouterr().err
    with pytest.raises(InputError, match="not connected and without a value"):
        branch(replace(triple, connections=()), whole, 25, tmp_path / "no", strict_inputs=True)
    with pytest.raises(InputError, match=r"^a warning; with --strict this is an error$"):
        branch(replace(triple, warnings=("a warning",)), whole, 25, tmp_path / "no", strict=True)
    assert not (tmp_path / "no").exists()


def test_a_branch_may_record_more_and_last_longer(triple, whole, tmp_path):
    simulate(triple, tmp_path / "long", stop_time=0.09)
    simulate(triple, tmp_path / "little", record=["b.y"], checkpoints=CheckpointSchedule(times=["0.025", "0.06"]))
    restart = Restart(checkpoint=read_checkpoint(tmp_path / "little/checkpoints/t=0.06.ckpt"))
    simulate(triple, tmp_path / "longer", restart=restart, stop_time=0.09, record=["b.*", "a.*"])
    full, mine = read_signals(tmp_path / "long"), read_signals(tmp_path / "longer")
    assert len(mine.time) == 31
    for name in mine.columns:
        np.testing.assert_array_equal(mine[name], full[name][60:], name)
    branch(triple, tmp_path / "little", 25, tmp_path / "more", record=["a.*", "b.steps"])
    full, mine = read_signals(whole), read_signals(tmp_path / "more")
    for name in mine.columns:
        np.testing.assert_array_equal(mine[name], full[name][25:], name)


def test_what_a_branch_would_record_and_the_checkpoint_lacks_is_refused(triple, tmp_path):
    simulate(triple, tmp_path / "little", record=["b.y"], checkpoints=CheckpointSchedule(times=["0.025"]))
    with pytest.raises(InputError, match=r"p\.began: t=0\.025\.ckpt lacks an earlier value of it"):
        branch(triple, tmp_path / "little", 25, tmp_path / "no", record=["p.began"])  # in the middle of p's step
    assert not (tmp_path / "no").exists()


def test_inputs_and_tunable_parameters_may_change(triple, whole, tmp_path):
    branch(triple, whole, 24, tmp_path / "branch", overrides={"a.offset": 1000.25, "b.gain": 0.0}, record=["*.y"])
    mine, full = read_signals(tmp_path / "branch"), read_signals(whole)
    # a steps at 24 ms, and its filter takes a tenth of 1000 more; b, at 25 ms, does without u and what came of it
    assert mine["a.y"][0] - full["a.y"][24] == pytest.approx(100.0, rel=1e-12)
    np.testing.assert_array_equal(mine["b.y"][0], full["b.y"][24])
    assert full["b.y"][25] - mine["b.y"][1] == pytest.approx(0.1 * full["a.y"][24], rel=1e-12)
    assert read_checkpoint(whole / "checkpoints/t=0.024.ckpt").run["overrides"] == {}


def test_the_overrides_of_the_run_hold_on(triple, whole, tmp_path):
    given = {"a.gain": 3.0, "a.offset": 2.0}
    simulate(triple, tmp_path / "given", overrides=given, checkpoints=CheckpointSchedule(times=["0.031"]))
    branch(triple, tmp_path / "given", 31, tmp_path / "branch")
    assert_rest_is_equal(tmp_path / "branch", tmp_path / "given")
    assert read_signals(tmp_path / "given")["a.y"][-1] != read_signals(whole)["a.y"][-1]


def test_a_fresh_component_begins_anew_with_the_outputs_that_the_others_have(triple, fmus, whole, tmp_path):
    other = replace(
        triple, components=tuple(replace(c, source=fmus["other"]) if c.name == "b" else c for c in triple.components)
    )
    branch(other, whole, 25, tmp_path / "branch", reinitialised=("b",), overrides={"b.seed": 77})
    mine, full = read_signals(tmp_path / "branch"), read_signals(whole)
    np.testing.assert_array_equal(mine["b.steps"][:9], [1, 1, 1, 2, 2, 2, 3, 3, 3])  # it steps at 25, 28, 31 ms
    np.testing.assert_array_equal(mine["b.began"][:4], [0.025, 0.025, 0.025, 0.028])
    np.testing.assert_array_equal(mine["a.steps"], full["a.steps"][25:])  # the others go on
    generator = (1664525 * 77 + 1013904223) % 2**32
    noise = generator / 2**32 - 0.5
    a = full["a.y"][24]  # its output at 25 ms: what b's filter is initialized with, and gets in its first step
    kicked = 2.0 * full["a.steps"][24] if full["a.odd"][22] else 0.0
    expected = 0.7 * a + 0.1 * (a - 0.5 + kicked) + noise + 0.003
    assert mine["b.y"][0] == pytest.approx(expected, rel=1e-12)
    # p, four ticks behind, sees the initial output of the new b until then
    np.testing.assert_array_equal(mine["p.y"][:2], full["p.y"][25:27])


def test_what_was_left_out_begins_anew_only_when_told(triple, fmus, tmp_path):
    mute = replace(
        triple, components=tuple(replace(c, source=fmus["mute"]) if c.name == "b" else c for c in triple.components)
    )
    with pytest.raises(InputError, match=r"b: cannot save its state .* --checkpoint-without b saves the others"):
        simulate(mute, tmp_path / "no", checkpoints=CheckpointSchedule(every="0.01"))
    assert not (tmp_path / "no").exists()
    simulate(mute, tmp_path / "yes", checkpoints=CheckpointSchedule(times=["0.025"], without=["b"]))
    with pytest.raises(InputError, match=r"b: t=0\.025\.ckpt holds no state of it; give --reinitialise b"):
        branch(mute, tmp_path / "yes", 25, tmp_path / "no")
    branch(mute, tmp_path / "yes", 25, tmp_path / "branch", reinitialised=("b",))
    mine, full = read_signals(tmp_path / "branch"), read_signals(tmp_path / "yes")
    assert mine["b.steps"][0] == 1
    np.testing.assert_array_equal(mine["a.steps"], full["a.steps"][25:])


@pytest.mark.parametrize("apart", [False, True])
def test_an_fmu_that_fails_to_save_its_state_ends_the_run_in_a_line(triple, fmus, tmp_path, apart):
    system = replace(
        triple,
        components=tuple(
            replace(c, source=fmus["complains"], isolated=apart) if c.name == "b" else c for c in triple.components
        ),
    )
    with pytest.raises(RunError, match=r"b: fmi2GetFMUstate returned fmi2Error at 0\.0\d* s: no room for it"):
        simulate(system, tmp_path / "out", checkpoints=CheckpointSchedule(times=["0.025"]))
    assert len(read_signals(tmp_path / "out").time) == 25
    assert not list((tmp_path / "out").glob("checkpoints/*"))


def other_fmu(system, fmus):
    return replace(system, components=(replace(system.components[0], source=fmus["other"]), *system.components[1:]))


REFUSED = {
    "another FMU": (other_fmu, {}, "a: t=0.025.ckpt was made with another FMU, .*good.fmu .*, or --reinitialise a"),
    "another period": (lambda s, _: s.with_period("a", MS), {}, "a: .* another period, 0.002 s, not 0.001 s"),
    "another delay": (lambda s, _: s.with_delay("b", "p", 5), {}, "b.y -> p.u: .* a delay of 4 ticks, not 5"),
    "another tick": (lambda s, _: replace(s, tick=MS // 2), {}, "was made with another tick: 0.001 s there, 0.0005 s"),
    "another connection": (
        lambda s, _: replace(s, connections=s.connections[:-1]),
        {"overrides": {"a.number": 1}},
        "p.steps -> a.number: is connected in t=0.025.ckpt only",
    ),
    "a fixed parameter": (
        lambda s, _: s,
        {"overrides": {"b.seed": 3}},
        "b.seed: is 6 in t=0.025.ckpt and cannot change while the FMU runs; give no other, or --reinitialise b",
    ),
    "too short": (lambda s, _: s, {"stop_time": 0.025}, "stop time 0.025 s: not after t=0.025.ckpt"),
    "no such component": (lambda s, _: s, {"reinitialised": ("c",)}, "c: no such component; there are a, b, p"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_run_that_is_another_one_is_refused_by_name(triple, fmus, whole, tmp_path, case):
    change, options, message = REFUSED[case]
    with pytest.raises(InputError, match=message):
        branch(change(triple, fmus), whole, 25, tmp_path / "no", **options)
    assert not (tmp_path / "no").exists()


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"times": ["0.0255"]}, "checkpoint 0.0255 s is not a whole multiple of the tick 0.001 s; choose 0.025 s or"),
        ({"times": ["0.061"]}, "checkpoint 0.061 s: lies after the stop time 0.06 s"),
        ({"times": ["-1"]}, "checkpoint -1 s must be > 0"),
        ({"every": "0"}, "checkpoint every 0 s must be > 0"),
        ({"every": "soon"}, "checkpoint every: 'soon' is not a number of seconds"),
        ({"times": ["0.02"], "without": ["c"]}, "c: no such component"),
    ],
)
def test_a_wrong_time_is_refused_before_the_run(triple, tmp_path, wanted, message):
    with pytest.raises(InputError, match=message):
        simulate(triple, tmp_path / "no", checkpoints=CheckpointSchedule(**wanted))
    assert not (tmp_path / "no").exists()


def test_checkpoints_at_both_ends(triple, whole, tmp_path):
    simulate(triple, tmp_path / "ends", checkpoints=CheckpointSchedule(times=["0", "0.06"], every="0.025"))
    names = sorted(path.name for path in (tmp_path / "ends/checkpoints").iterdir())
    assert names == ["t=0.025.ckpt", "t=0.05.ckpt", "t=0.06.ckpt", "t=0.ckpt"]
    restart = Restart(checkpoint=read_checkpoint(tmp_path / "ends/checkpoints/t=0.ckpt"))
    simulate(triple, tmp_path / "branch", restart=restart)
    assert_rest_is_equal(tmp_path / "branch", whole)


def test_saving_changes_nothing(triple, whole, tmp_path):
    simulate(triple, tmp_path / "plain")
    assert (tmp_path / "plain/signals.parquet").read_bytes() == (whole / "signals.parquet").read_bytes()


ADAPTER = """
[[input]]
port = "u"
variable = "u"
scale = 2.0
hold = "flag"

[[input]]
port = "number"
variable = "number"

[[input]]
port = "flag"
variable = "flag"

[[output]]
port = ["y", "steps", "began"]
variable = ["y", "steps", "began"]

[[output]]
port = "odd"
variable = "odd"

[constants]
offset = -0.5
"""


@pytest.mark.parametrize("apart", [False, True])
def test_an_adapter_keeps_what_it_holds(triple, fmus, tmp_path, apart):
    (tmp_path / "b.toml").write_text(ADAPTER)
    system = replace_component(triple, "b", fmus["other"], read_adapter(tmp_path / "b.toml"))
    system = system.with_isolation("b", apart)
    simulate(system, tmp_path / "whole", checkpoints=CheckpointSchedule(times=["0.03"]))
    states = read_checkpoint(tmp_path / "whole/checkpoints/t=0.03.ckpt").states
    assert sorted(states["b"]) == ["adapter.npz", "fmu"]
    branch(system, tmp_path / "whole", 30, tmp_path / "branch")
    assert_rest_is_equal(tmp_path / "branch", tmp_path / "whole")
    other = replace_component(triple, "b", fmus["other"], None)
    with pytest.raises(
        InputError, match=r"b: .* was made with another adapter, sha256 .*, not none; .* --reinitialise b"
    ):
        branch(other, tmp_path / "whole", 30, tmp_path / "no")
