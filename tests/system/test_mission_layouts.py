"""Missions on other layouts, and an outage of the star tracker: invariants and bounds, through the FMUs."""

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from flexbench.cli.parser import main
from flexsat.parameters import ARCSECOND, DEGREE
from flexsat.runtime.rotations import error_angle, matrix_from_mrp
from lockstep import Signals

ROOT = Path(__file__).parents[2]
STEP = 5e-3  # s, of thrusters and controller
MISSION = """
[[command]]
at = 0.3
do = "off-load"
[set]
"plant.initial.wheel.speed_offset" = {offsets}
"mission.settle.dwell" = 0.1
"mission.off_loading.duration" = {duration}
"""
BALANCE = [f"--record={name}" for name in ("plant.attitude.mrp", "plant.angular_momentum", "mission.momentum",
           "mission.mode", "thrusters.external.torque", "controller.reference.mrp")]  # fmt: skip
QUIET = ("--set", "sensors.jitter.enabled=false")  # imbalance acts on the plant as from outside


def wheel_axes(layout: Path) -> np.ndarray:
    """Return the axes (n, 3) of the wheels that a layout's mission manager knows."""
    with zipfile.ZipFile(layout / "mission.fmu") as archive:
        return np.array(np.load(io.BytesIO(archive.read("resources/model.npz")))["corrected.wheel_axis"])


def balance(run: Signals) -> tuple[np.ndarray, np.ndarray]:
    """Return the momentum that the spacecraft has lost, and the external impulse, inertial axes [N.m.s]."""
    torque = [matrix_from_mrp(p).T @ t for p, t in zip(run["plant.attitude.mrp"], run["thrusters.external.torque"],
              strict=True)]  # fmt: skip
    return run["plant.angular_momentum"][-1] - run["plant.angular_momentum"][0], STEP * np.sum(torque[:-1], axis=0)


def pointing(run: Signals, begin: float = 0.0, end: float = np.inf) -> float:
    """Return the greatest pointing error [arcsec] in a window."""
    error = error_angle(run["plant.attitude.mrp"], run["controller.reference.mrp"]) / ARCSECOND
    return float(error[(run.time >= begin) & (run.time <= end)].max())


def test_distributed_wheels_give_their_momentum_to_the_thrusters(
    missions: Callable[[str], Path], fly_from: Callable[..., Signals]
):
    layout = missions("distributed")
    offsets = wheel_axes(layout) @ (0.1, -0.06, 0.04)
    run = fly_from(layout, 9.0, *BALANCE, *QUIET, "--set", "plant.modes=25",
                   mission=MISSION.format(offsets=offsets.tolist(), duration=6.0))  # fmt: skip
    lost, impulse = balance(run)

    assert np.abs(lost).min() > 0.3  # N.m.s about each axis
    assert_allclose(lost, impulse, atol=1e-6 * np.abs(lost).max())
    assert np.abs(run["mission.momentum"][0]).max() > 0.8
    assert np.abs(run["mission.momentum"][-1]).max() < 0.03  # tolerance, and the environment since
    assert {4, 2} <= set(run["mission.mode"].tolist())  # off-load, then settle
    assert pointing(run) < 0.5


def test_unequal_wheels_give_their_momentum_to_the_thrusters(tmp_path: Path, fly_from: Callable[..., Signals]):
    path = tmp_path / "unequal.toml"
    assert main(["new", str(path)]) == 0
    text = path.read_text(encoding="utf-8").replace("plant = 60", "plant = 8")
    wheels = "axes = [[1, 0, 1], [0, -1, -1], [-1, 0, 1], [0, 1, -1]]"
    kinds = 'axes = [[1, 0, 1], [-1, 0, 1]] }, { at = "bus", kind = "small", axes = [[0, -1, -1], [0, 1, -1]]'
    small = '[wheel_kinds.small]\ninertia = "2 kg.m2"\ntorque_limit = "2 N.m"\n\n[speeds]'
    path.write_text(text.replace(wheels, kinds).replace("[speeds]", small, 1), encoding="utf-8")
    assert main(["build", str(path), "--no-native", "--missions", "--out", str(tmp_path / "fmus")]) == 0
    offsets = (0.1, 0.2, 0.05, -0.1)
    run = fly_from(tmp_path / "fmus" / "unequal" / "missions", 8.0, *BALANCE, *QUIET, native=False,
                   mission=MISSION.format(offsets=list(offsets), duration=6.0))  # fmt: skip
    axis = np.array([[1, 0, 1], [-1, 0, 1], [0, -1, -1], [0, 1, -1]]) / np.sqrt(2.0)
    lost, impulse = balance(run)

    held = axis.T @ (np.array([4.62, 4.62, 2.0, 2.0]) * offsets)  # each wheel has the inertia of its kind
    assert_allclose(run["mission.momentum"][0], held, atol=3e-3)  # encoders
    assert np.abs(lost).max() > 0.5
    assert_allclose(lost, impulse, atol=1e-6 * np.abs(lost).max())
    assert np.abs(run["mission.momentum"][-1]).max() < 0.03


def test_a_star_tracker_outage_is_bridged_with_estimated_biases(
    missions: Callable[[str], Path], fly_from: Callable[..., Signals], tmp_path: Path
):
    faults = (ROOT / "examples" / "faults" / "star_tracker_outage_in_a_mission.toml").read_text(encoding="utf-8")
    assert "from = 60.0\nto = 120.0" in faults
    moved = faults.replace("from = 60.0\nto = 120.0", "from = 100.0\nto = 110.0")
    words = ("--record-period", "0.1", "--seed", "3", "--set", "plant.modes=25", "--set",
             f"sensors.gyro.bias_deviation={DEGREE / 3600}", "--record", "controller.estimate.gyro_bias", "--record",
             "plant.attitude.mrp", "--record", "controller.reference.mrp", "--record", "mission.*")  # fmt: skip
    run = fly_from(missions("centralised"), 125.0, *words, "--set", "controller.filter.gyro_bias=true", "--set",
                   "controller.filter.disturbance=true", faults=moved)  # fmt: skip

    events = [json.loads(line) for line in (tmp_path / "run" / "events.jsonl").read_text("utf-8").splitlines()]
    assert [(e["time"], e["to"]) for e in events if e["event"] == "mode"] == [
        (5.0, "fine"), (101.0, "acquisition"), (110.0, "settle"), (115.0, "fine")]  # fmt: skip
    assert [e["time"] for e in events if e["event"] == "star-tracker-outage"] == [101.0, 110.0]
    # without samples the biases are held, to the last bit, and they are estimated again afterwards
    bias = run["controller.estimate.gyro_bias"]
    during = (run.time > 100.0) & (run.time < 110.0)
    assert np.ptp(bias[during], axis=0).max() == 0.0
    assert np.abs(bias[during][0]).max() > 0.1 * DEGREE / 3600
    assert np.all(bias[-1] != bias[during][0])
    assert_array_equal(run["mission.wheel.status"], 0)
    # nothing else holds the attitude: the biases that are not estimated drive it off
    without = fly_from(missions("centralised"), 125.0, *words, faults=moved, name="without")
    assert pointing(run, 100.0) < 3.0  # 2.4, and falling: the filter of the state forgets within minutes
    assert pointing(without, 100.0) > 20.0
