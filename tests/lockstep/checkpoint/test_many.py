"""Many branches of one checkpoint, in parallel processes: `flexbench.engine.branches`."""

import numpy as np
import pytest

from flexbench.engine.branches import run_branches
from lockstep import InputError, load_system, read_signals, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule


def test_a_branch_is_the_run_that_it_would_be_alone(triple_ssd, tmp_path):
    system = load_system(triple_ssd)
    simulate(system, tmp_path / "one", overrides={"a.gain": 2.0}, checkpoints=CheckpointSchedule(times=["0.04"]))
    file = tmp_path / "one/checkpoints/t=0.04.ckpt"
    with pytest.raises(InputError, match=r"bad: b\.seed: is 6 in t=0\.04\.ckpt and cannot change"):
        run_branches(file, {"good": {}, "bad": {"b.seed": 8}}, tmp_path / "many")
    assert not (tmp_path / "many").exists()
    finished = run_branches(file, {"gain=5": {"b.gain": 5.0}}, tmp_path / "many")  # in a process of its own
    assert [(one.job.folder.name, one.simulated_time) for one in finished] == [("gain=5", 0.06)]
    simulate(system, tmp_path / "alone", overrides={"b.gain": 5.0}, restart=Restart(checkpoint=read_checkpoint(file)))
    one, alone, mine = (read_signals(tmp_path / name) for name in ("one", "alone", "many/gain=5"))
    for name in one.columns:
        np.testing.assert_array_equal(mine[name], alone[name], name)
    assert mine["b.y"][-1] != one["b.y"][-1]
