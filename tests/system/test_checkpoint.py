"""The distributed spacecraft in fine pointing: killed and resumed, and branched into other processes, bit by bit."""

import time
import tomllib

import numpy as np
import pytest

from lockstep import read_signals

OPTIONS = ("--stop-time", "0.9", "--record", "all", "--record-period", "0.001", "--seed", "3", "--checkpoint", "0.417")


@pytest.fixture(scope="module")
def whole(fmus, flexsat, tmp_path_factory):
    """Return the results of an uninterrupted run."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    done = flexsat("run", fmus / "distributed/fine_pointing.ssd", "--out", folder, *OPTIONS)
    assert done.returncode == 0, done.stderr
    return folder


def test_a_killed_run_is_resumed_with_the_same_bytes(fmus, flexsat, start_flexsat, whole, tmp_path):
    out = tmp_path / "out"
    # the pace leaves time to kill it: what it computes is the same
    process = start_flexsat("run", fmus / "distributed/fine_pointing.ssd", "--out", out, *OPTIONS, "--pace", "0.7")
    deadline = time.monotonic() + 100.0
    while not (out / "checkpoints/t=0.417.ckpt").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.kill()
    process.communicate(timeout=60)
    assert tomllib.loads((out / "run.toml").read_text())["status"] == "running"

    done = flexsat("run", "--resume", out)

    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0.483 s simulated, from 0.417 s on in ")
    assert (out / "signals.parquet").read_bytes() == (whole / "signals.parquet").read_bytes()
    assert tomllib.loads((out / "run.toml").read_text())["status"] == "completed"


def test_a_branch_in_processes_of_its_own_goes_on_bit_by_bit(flexsat, whole, tmp_path):
    apart = [option for name in ("plant", "sensors", "controller") for option in ("--isolate", name)]
    file = whole / "checkpoints/t=0.417.ckpt"
    done = flexsat("run", "--restart-from", file, "--stop-time", "0.55", "--out", tmp_path, "--record", "all", *apart)
    assert done.returncode == 0, done.stderr
    assert "Settled from the start at 0.417 s on" in done.stdout
    mine, full = read_signals(tmp_path), read_signals(whole)
    rows = np.searchsorted(full.time, mine.time)
    assert (len(mine.columns), len(rows), rows[-1]) == (len(full.columns), 134, 550)
    for name in mine.columns:
        np.testing.assert_array_equal(mine[name].view(np.int64), full[name][rows].view(np.int64), name)


def test_a_branch_takes_another_command_and_fresh_sensors(flexsat, whole, tmp_path):
    values = {"controller.command.rotation[1]": 1e-4, "controller.command.start_time": 0.7, "sensors.seed": 9}
    sets = [option for key, value in values.items() for option in ("--set", f"{key}={value}")]
    file = whole / "checkpoints/t=0.417.ckpt"
    changed = ("--reinitialise", "sensors", *sets, "--record", "all", "--record-period", "0.001")
    done = flexsat("run", "--restart-from", file, "--stop-time", "0.9", "--out", tmp_path, *changed)
    assert done.returncode == 0, done.stderr
    mine, full = read_signals(tmp_path), read_signals(whole)
    assert mine["controller.reference.mrp"][-1, 0] > 1e-9  # the slew has begun
    assert full["controller.reference.mrp"][-1, 0] == 0.0
    assert (mine.time[0], full.time[417]) == (0.417, 0.417)
    np.testing.assert_array_equal(mine["plant.attitude.mrp"][0], full["plant.attitude.mrp"][417])
    assert np.all(mine["sensors.gyro.rate"][0] != full["sensors.gyro.rate"][417])  # another noise
