"""Failures while a checkpoint is saved: what was simulated before stays readable."""

import tomllib

import numpy as np
import pytest

from lockstep import CheckpointSchedule, RunError, read_signals, simulate
from lockstep.checkpoint import save


def test_rows_before_a_failed_checkpoint_are_readable(triple, tmp_path, monkeypatch):
    """They had not been written yet: the first second is not over."""

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(save, "write_checkpoint", full)
    out = tmp_path / "out"
    with pytest.raises(RunError, match=r"cannot write to .*: No space left on device, after 0\.031 s simulated; "):
        simulate(triple, out, checkpoints=CheckpointSchedule(times=["0.031"]))
    np.testing.assert_array_equal(read_signals(out).time, np.arange(31) / 1000)
    record = tomllib.loads((out / "run.toml").read_text())
    assert (record["status"], record["simulated_time"]) == ("failed", 0.031)
    assert sorted(path.name for path in out.iterdir()) == ["events.jsonl", "run.toml", "signals.parquet"]
