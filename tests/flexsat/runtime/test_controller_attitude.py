"""Attitudes far from zero: what the controller measures, estimates and regulates is a small rotation there too."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from flexsat.closed_loop import ClosedLoop
from flexsat.design.chain import Designs
from flexsat.runtime import controller as stepper
from flexsat.variants import VARIANTS

DEGREE = np.pi / 180.0
ARCSECOND = DEGREE / 3600.0
# The same loop seen from another attitude: rounding of attitudes of order one, 1e-16, times gains up to 1e8 and back
SAME = 1e-6


def measured(design, seen, valid, rate=(0.0, 0.0, 0.0)):
    """Return what sensors give of a rigid body that turns at a rate [rad/s], at an attitude."""
    gyro = design.model.c[:23, design.model.index.rate] @ np.array(rate)
    encoder = design.model.c[36:-3, design.model.index.rate] @ np.array(rate)
    return stepper.Measurements(
        gyro_rate=gyro,
        accelerometer=np.zeros(13),
        encoder_speed=design.model.nominal_speed + encoder,
        encoder_angle=np.zeros(design.plant.wheels),
        star_tracker_mrp=seen.as_mrp(),  # SciPy's too has a norm of at most one
        star_tracker_valid=valid,
    )


def run(design, given, start, steps=60):
    """Return torques and estimates under small errors about an attitude at which the run begins."""
    prepared = stepper.prepare(design.controller, given)
    state = stepper.init(prepared, np.zeros(3), 5.0)
    rng, torques, seen, first = np.random.default_rng(2), [], [], prepared.first_measurement
    errors = 20.0 * ARCSECOND * rng.standard_normal((steps, 3))
    errors[first] = 0.0  # where the run begins
    for k, error in enumerate(errors):
        at = start * Rotation.from_rotvec(error)
        out = stepper.step(prepared, state, 0.005 * k, measured(design, at, k % 20 == first, 1e-3 * error))
        if k < first:
            continue
        torques.append(out.torque.copy())
        seen.append((start.inv() * Rotation.from_mrp(out.estimate[:3])).as_rotvec())
        assert_allclose((start.inv() * Rotation.from_mrp(out.reference[:3])).magnitude(), 0.0, atol=1e-15)
    return np.array(torques), np.array(seen)


# across the shadow set: at 180 deg the short rotation jumps to the other side from one sample to the next
@pytest.mark.parametrize("degrees", [5.0, 100.0, 180.0])
@pytest.mark.parametrize("delays", [{}, {"measurement_delay": 0.005, "actuation_delay": 0.003}])
def test_the_loop_is_the_same_at_every_attitude(centralised, flight, degrees, delays):
    given = flight(centralised, **delays)
    zero = run(centralised, given, Rotation.identity())
    there = run(centralised, given, Rotation.from_rotvec(degrees * DEGREE * np.array([0.6, 0.0, 0.8])))
    for found, expected in zip(there, zero, strict=True):
        assert np.abs(expected).max() > 0.0
        assert_allclose(found, expected, atol=SAME * np.abs(expected).max())


def test_a_near_first_measurement_is_an_error_to_regulate(centralised, flight):
    prepared = stepper.prepare(centralised.controller, flight(centralised, capture_angle=1e-3))
    for angle, taken in ((0.9e-3, False), (1.1e-3, True)):
        state = stepper.init(prepared, np.zeros(3), 5.0)
        at = Rotation.from_rotvec([0.0, angle, 0.0])
        out = stepper.step(prepared, state, 0.0, measured(centralised, at, True))
        assert_allclose(out.reference[:3], [0.0, np.tan(0.25 * angle) if taken else 0.0, 0.0], atol=1e-15)
        assert out.torque.any() != taken


def test_the_estimate_follows_a_turn_past_half_a_circle(centralised, flight):
    """From gyros alone, at 20 deg/s about an oblique axis, from the first sample on: exact kinematics."""
    prepared = stepper.prepare(centralised.controller, flight(centralised, open_loop=True))
    state = stepper.init(prepared, np.zeros(3), 5.0)
    rate = 20.0 * DEGREE * np.array([0.48, 0.6, 0.64])
    state.estimate[centralised.model.index.rate] = rate
    n = 2400  # 12 s, 240 deg
    # at a constant rate nothing else moves: the model's other states are left out
    prepared_rate = np.zeros(len(state.estimate))
    prepared_rate[centralised.model.index.rate] = rate
    for k in range(n):
        state.estimate[3:] = prepared_rate[3:]
        seen = Rotation.from_rotvec(0.005 * k * rate)
        out = stepper.step(prepared, state, 0.005 * k, measured(centralised, seen, k == 0, rate))
    error = (Rotation.from_rotvec(0.005 * (n - 1) * rate).inv() * Rotation.from_mrp(out.estimate[:3])).magnitude()
    assert error < 2e-4


def test_a_run_begins_where_it_is_and_slews_from_there(centralised):
    """The monolith at 100 deg: it holds, and the reference of a command begins there."""
    start = Rotation.from_rotvec(100.0 * DEGREE * np.array([0.0, 0.6, 0.8]))
    quiet = {"plant": {"initial.mrp": start.as_mrp()}, "sensors": {"jitter.enabled": False},
             "controller": {"command.rotation": (1e-3, 0.0, 0.0), "command.start_time": 0.3}}  # fmt: skip
    loop = ClosedLoop(Designs(dict.fromkeys(VARIANTS, centralised)), quiet)
    recorded = ["plant.attitude.mrp", "controller.reference.mrp", "controller.wheel.torque"]
    signals = loop.run(0.6, recorded, record_ticks=10).signals
    reference = Rotation.from_mrp(signals["controller.reference.mrp"])
    true = Rotation.from_mrp(signals["plant.attitude.mrp"])
    assert (start.inv() * reference[0]).magnitude() < 100.0 * ARCSECOND  # ten times the noise of a sample
    turned = (reference[0].inv() * reference[-1]).as_rotvec()
    assert turned[0] > 1e-7
    assert_allclose(turned[1:], 0.0, atol=1e-3 * turned[0])
    assert (reference.inv() * true).magnitude().max() < 100.0 * ARCSECOND
