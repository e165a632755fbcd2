"""Faults and checkpoints: what a fault remembers goes on, and a branch begins without what they had done."""

import json

import numpy as np
import pytest

from lockstep import InputError, read_signals, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.faults.read import read_scenario
from lockstep.simulation import resume

pytestmark = pytest.mark.usefixtures("each_tick")

SCENARIO = """
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
name = "once"
connection = "p.u"
kind = "spike"
value = 5.0
from = 0.02

[[fault]]
name = "noisy"
connection = "p.u"
kind = "noise"
deviation = 0.5
from = 0.01
to = 0.055

[[fault]]
name = "strong"
parameter = "b.gain"
kind = "scale"
factor = 3.0
from = 0.02
to = 0.04

[[fault]]
name = "early"
connection = "a.number"
kind = "stuck"
value = 4
from = 0.004
to = 0.008
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("faults") / "faults.toml"
    path.write_text(SCENARIO)
    return path


@pytest.fixture
def faulty(triple, scenario, tmp_path):
    """Return the results of a run with faults and checkpoints at some times."""
    wanted = CheckpointSchedule(times=["0.022", "0.031", "0.039"])
    simulate(triple, tmp_path / "faulty", faults=[read_scenario(scenario)], checkpoints=wanted)
    return tmp_path / "faulty"


def fault_events(folder):
    lines = map(json.loads, (folder / "events.jsonl").read_text().splitlines())
    return [(e["time"], e["state"], e["name"]) for e in lines if e["event"] == "fault"]


@pytest.mark.parametrize("tick", [22, 31, 39])  # the last: a parameter has to be set back in the next tick
def test_a_resumed_run_has_its_faults(triple, faulty, tick, each_tick):
    """Also where the other implementation of the tick continues: both save the same memory."""
    signals, before = (faulty / "signals.parquet").read_bytes(), fault_events(faulty)
    for later in range(tick + 1, 40):
        (faulty / f"checkpoints/t=0.0{later}.ckpt").unlink(missing_ok=True)
    (faulty / "run.toml").write_text((faulty / "run.toml").read_text().replace('"completed"', '"running"', 1))
    resume(faulty, triple, tick={"c": "python", "python": "c"}[each_tick])
    assert (faulty / "signals.parquet").read_bytes() == signals
    assert fault_events(faulty) == before
    assert len(before) == 12


def test_a_branch_has_the_faults_that_it_is_given(triple, faulty, scenario, tmp_path):
    restart = Restart(checkpoint=read_checkpoint(faulty / "checkpoints/t=0.031.ckpt"))
    simulate(triple, tmp_path / "without", restart=restart)  # the gain of b was three times as much
    simulate(triple, tmp_path / "given", restart=restart, overrides={"b.gain": 1.0})
    simulate(triple, tmp_path / "three", restart=restart, overrides={"b.gain": 3.0})
    without, given, three = (read_signals(tmp_path / name)["b.y"] for name in ("without", "given", "three"))
    np.testing.assert_array_equal(without, given)
    assert without[-1] != three[-1]
    simulate(triple, tmp_path / "with", restart=restart, faults=[read_scenario(scenario)])
    assert fault_events(tmp_path / "without") == []
    before = {"held", "late", "noisy", "strong"}  # these act at 31 ms; the others are over
    assert {
        name for time, state, name in fault_events(tmp_path / "with") if (time, state) == (0.031, "begin")
    } == before
    assert {name for _, state, name in fault_events(tmp_path / "with") if state == "end"} == before


def test_a_scenario_that_has_changed_is_refused(triple, tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text(SCENARIO)
    simulate(triple, tmp_path / "out", faults=[read_scenario(mine)], checkpoints=CheckpointSchedule(times=["0.02"]))
    run = (tmp_path / "out/run.toml").read_text().replace('"completed"', '"failed"', 1)
    (tmp_path / "out/run.toml").write_text(run)
    mine.write_text(SCENARIO.replace("5.0", "6.0"))
    with pytest.raises(InputError, match=r"mine\.toml: has changed since the run, sha256 .* restore the old one"):
        resume(tmp_path / "out", triple)
