"""Faults in the closed loop: the example scenarios, with their times moved to where a short run meets them."""

import json
from pathlib import Path

import numpy as np
import pytest

from lockstep import load_system, read_scenario, read_signals
from lockstep.faults.resolve import resolve
from lockstep.plan.plan import Plan

EXAMPLES = [  # without that of systems with a mission manager, which this build has not
    path
    for path in sorted((Path(__file__).parents[2] / "examples" / "faults").glob("*.toml"))
    if not path.stem.endswith("in_a_mission")
]
ARCSECOND = np.pi / 648000.0
# Jitter acts on the structure as forces from outside do; without it nothing but wheels exchanges momentum
CALM = ("--seed", "1", "--set", "sensors.jitter.enabled=false", "--set", "controller.jitter.feed_forward=false")


@pytest.fixture
def faulty(flexsat, fmus, tmp_path):
    """Return a function that flies fine pointing with an example at other times, and gives its signals and faults."""

    def fly(configuration, name, stop, more="", **times):
        text = next(path for path in EXAMPLES if path.stem == name).read_text() + more
        for key, value in times.items():
            key = key.rstrip("_")
            line = next(line for line in text.splitlines() if line.startswith(f"{key} = "))
            text = text.replace(line, f"{key} = {value}")
        (tmp_path / "faults.toml").write_text(text)
        done = flexsat("run", fmus / configuration / "fine_pointing.ssd", "--faults", tmp_path / "faults.toml",
                       "--stop-time", stop, *CALM, "--out", tmp_path / "out", "--record", "plant.*", "--record",
                       "controller.*", "--record-period", "0.005")  # fmt: skip
        assert done.returncode == 0, done.stderr
        result = [json.loads(line) for line in (tmp_path / "out" / "events.jsonl").read_text().splitlines()]
        return read_signals(tmp_path / "out"), [event for event in result if event["event"] == "fault"]

    return fly


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
@pytest.mark.parametrize("system", ["centralised/fine_pointing.ssd", "distributed/slew.ssd"])
def test_the_examples_fit_our_systems(path, system, fmus):
    plan = Plan(load_system(fmus / system), None, {}, None, None)
    found = resolve([read_scenario(path)], plan)
    assert len(found.transfers) + len(found.settings) > 0


def test_without_star_tracker_the_estimate_drifts_with_the_gyros_and_recovers(faulty):
    """All gyros about x drift by 0.1 arcsec/s during the outage: so does the estimate, about x alone."""
    numbers = ", ".join(f'"controller.gyro.rate[{k}]"' for k in (1, *range(4, 24, 2)))
    drift = (
        f'\n[[fault]]\nconnection = [{numbers}]\nkind = "bias"\nvalue = 0.1\nunit = "arcsec/s"\nfrom = 2.5\nto = 4.5\n'
    )
    signals, faults = faulty("centralised", "star_tracker_outage", 6, drift, from_=1.5, to=4.5)
    assert [(f["time"], f["state"], f["kind"]) for f in faults] == [
        (1.5, "begin", "dropout"), (2.5, "begin", "bias"), (4.5, "end", "dropout"), (4.5, "end", "bias")
    ]  # fmt: skip
    assert faults[0]["variables"] == [f"star_tracker.mrp[{k}]" for k in (1, 2, 3)] + ["star_tracker.valid"]
    error = 4.0 * (signals["controller.estimate.mrp"] - signals["plant.attitude.mrp"]) / ARCSECOND

    def moved(begin, end):
        return error[np.searchsorted(signals.time, end) - 1] - error[np.searchsorted(signals.time, begin)]

    def scatter(begin, end):
        return error[(signals.time >= begin) & (signals.time < end)].std(axis=0)

    assert scatter(0.3, 1.5).min() > 0.02  # each sample of the star tracker moves the estimate, by 0.1 arcsec of noise
    assert scatter(1.6, 2.5).max() < 0.01  # without it, the gyros' random walk: 36 marcsec/s over sqrt(200 Hz), 1 s
    np.testing.assert_allclose(moved(2.5, 4.5), [0.2, 0.0, 0.0], atol=0.015)  # 3.6 marcsec of that walk
    assert np.linalg.norm(error[signals.time >= 4.9], axis=1).max() < 0.6  # as before: 3 sigma of three axes
    assert scatter(4.9, 6.0).min() > 0.02


def test_a_wheel_without_torque_is_replaced_by_the_others_and_momentum_is_kept(faulty):
    signals, faults = faulty("distributed", "torque_lost", 3, from_=1.0)
    assert [(f["time"], f["state"]) for f in faults] == [(1.0, "begin"), (3.0, "end")]
    after = signals.time >= 1.005
    commanded = signals["controller.wheel.torque[1]"][after]
    speed = signals["plant.wheel.speed"][after]
    assert np.abs(commanded).max() > 1e-4  # N.m: the controller does not know
    assert np.ptp(speed[:, 0]) < 0.01 * np.ptp(speed[:, 11])  # it runs on; what is left is its mount's motion
    pointing = 4.0 * np.linalg.norm(signals["plant.attitude.mrp"], axis=1)[signals.time >= 1.0] / ARCSECOND
    assert pointing.max() < 0.5
    momentum = signals["plant.angular_momentum"]
    assert np.abs(momentum - momentum[0]).max() < 1e-7  # N.m.s; the wheels exchange 1e-3


def test_a_wheel_that_seizes_gives_its_momentum_to_the_others_and_the_structure(faulty):
    signals, faults = faulty("distributed", "wheel_stuck", 3.2, from_=1.0)
    assert (faults[0]["component"], faults[0]["variables"]) == ("plant", ["wheel.friction_torque[1]"])
    assert faults[0]["values"] == {"value": 20.0}
    speed = signals["plant.wheel.speed[1]"]
    before, end = np.searchsorted(signals.time, [1.0, 3.0])
    stop = 1.0 + speed[before] * 0.84 / 20.0  # s; 0.84 kg.m2. The motor's 0.8 N.m helps or hinders
    assert np.all(np.abs(speed[signals.time > 1.1 * stop]) < 1e-6)
    assert abs(speed[np.searchsorted(signals.time, 1.5)] - (speed[before] - 0.5 * 20.0 / 0.84)) < 0.5 * 0.8 / 0.84 + 0.1
    momentum, lost = signals["plant.angular_momentum"], 0.84 * speed[before]
    assert np.linalg.norm(momentum - momentum[0], axis=1).max() < 1e-6 * lost  # of second order in the tilt
    assert np.linalg.norm(signals["plant.rate"][end] - signals["plant.rate"][before]) > 0.1 * lost / 2.2e5


def test_our_fmus_refuse_what_is_not_a_number_in_one_line(flexsat, fmus, tmp_path):
    (tmp_path / "f.toml").write_text('[[fault]]\nconnection = "controller.gyro.rate[2]"\nkind = "nan"\nfrom = 0.1\n')
    done = flexsat("run", fmus / "centralised" / "fine_pointing.ssd", "--faults", tmp_path / "f.toml", "--stop-time", 1,
                   "--out", tmp_path / "out")  # fmt: skip
    assert done.returncode == 1
    lines = [line for line in done.stderr.splitlines() if " s left" not in line]  # progress, on a loaded machine
    assert len(lines) == 1
    assert lines[0].startswith("flexsat: controller: fmi2SetReal returned fmi2Error")
    assert " at 0.1 s: setReal: gyro.rate[2] must be finite, got nan" in lines[0]
