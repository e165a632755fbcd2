"""The filter of external torque and gyro biases: steady state in closed form, estimates of true errors, outages."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexsat import slow_errors
from flexsat.design.slow_errors import SlowNoise, design_slow_filter
from flexsat.runtime.rotations import error_rotation, mrp_from_quaternion, relative_mrp, rotate_quaternion
from flexsat.slow_errors import ATTITUDE, RATE

INERTIA = np.array([[900.0, 30.0, 0.0], [30.0, 1100.0, -20.0], [0.0, -20.0, 1500.0]])
NOISE = SlowNoise(gyro=2e-7, star_tracker=5e-6, torque=2e-5, torque_walk=5e-6, bias_walk=2e-7)
PERIOD, PHASES = 5e-3, 20
BOTH = (True, True)


def test_bias_and_attitude_have_the_covariance_of_farrenkopf():
    """Three gyros at right angles are three estimators of one axis.

    Closed form of the steady state of a sampled gyro and star tracker: Farrenkopf (1978), as in Markley and Crassidis
    (2014), Fundamentals of Spacecraft Attitude Determination and Control, section 6.3; the covariance of the bias from
    the same Riccati equation.
    """
    found = design_slow_filter(INERTIA, np.eye(3), NOISE, PERIOD, PHASES, (False, True)).covariance
    interval = PERIOD * PHASES
    angle_walk, bias_walk, sample = NOISE.gyro * np.sqrt(PERIOD), NOISE.bias_walk, NOISE.star_tracker
    s_u, s_v = bias_walk * interval**1.5 / sample, angle_walk * interval**0.5 / sample
    gamma = np.sqrt(1.0 + s_v**2 / 4.0 + s_u**2 / 48.0)
    zeta = gamma + s_u / 4.0 + 0.5 * np.sqrt(2.0 * gamma * s_u + s_v**2 + s_u**2 / 3.0)
    attitude = sample**2 * (zeta**2 - 1.0)
    bias = bias_walk * sample / np.sqrt(interval) * (zeta - 1.0 / zeta) + 0.5 * bias_walk**2 * interval
    # the gyro is sampled, and the rate wanders by its noise in between: a twelfth more angle walk
    assert_allclose(np.diag(found)[:3], attitude, rtol=0.05)
    assert_allclose(np.diag(found)[9:], bias, rtol=0.05)
    assert_array_equal(found[6:9], 0.0)


def _prepared(gyro_axis, choice=BOTH, noise=NOISE):
    found = design_slow_filter(INERTIA, gyro_axis, noise, PERIOD, PHASES, choice)
    nothing = np.zeros((0, 3))
    axes = np.eye(3)
    return found, slow_errors.PreparedSlowErrors(
        period=PERIOD, phases=PHASES, gyro_axis=gyro_axis, sample=found.sample, between=found.between,
        mobility=np.linalg.inv(INERTIA), late=-axes, early=0.0 * axes, enters=nothing, ahead=nothing, against=nothing,
    )  # fmt: skip


def _flight(slow, duration, torque, bias, outage=(np.inf, np.inf), seed=1):
    """Fly a rigid body under a torque that wheels try to undo by halves; yield (time, filter's state, attitude)."""
    random = np.random.default_rng(seed)
    state = slow_errors.init_slow_state(len(bias))
    attitude, rate, wheels = (0.1, -0.2, 0.3, np.sqrt(0.86)), np.array([1e-5, -2e-5, 3e-5]), np.zeros(3)
    since = PHASES + 1  # nothing was seen before
    for step in range(round(duration / PERIOD)):
        time = step * PERIOD
        if step:
            change = slow.mobility @ (torque - wheels) * PERIOD
            attitude = rotate_quaternion(attitude, (PERIOD * (rate + 0.5 * change)).tolist())
            rate = rate + change
            turn = slow_errors.predict(slow, state, wheels, np.zeros(3))
            state.attitude[:] = rotate_quaternion(state.attitude.tolist(), turn.tolist())
        wheels = 0.5 * torque * np.sin(0.3 * time)
        measured = slow.gyro_axis @ rate + bias + NOISE.gyro * random.standard_normal(len(bias))
        seen = None
        if step % PHASES == 0 and not outage[0] <= time < outage[1]:
            seen = rotate_quaternion(attitude, (NOISE.star_tracker * random.standard_normal(3)).tolist())
        if seen is not None and since > PHASES:
            state.attitude[:] = seen
        else:
            off = None if seen is None else 4.0 * np.array(relative_mrp(seen, state.attitude.tolist()))
            turn = slow_errors.correct(slow, state, measured, off, since)
            state.attitude[:] = rotate_quaternion(state.attitude.tolist(), turn.tolist())
        since = 1 if seen is not None else since + 1
        yield time, state, attitude


AXES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
TORQUE, BIAS = np.array([2e-3, -1e-3, 3e-3]), np.array([5e-6, -4e-6, 3e-6, -6e-6])


def test_torque_and_biases_are_found_within_their_covariance():
    found, slow = _prepared(AXES)
    deviation = np.sqrt(np.diag(found.covariance)[6:])
    samples = [state.errors - np.concatenate([TORQUE, BIAS])
               for time, state, _ in _flight(slow, 140.0, TORQUE, BIAS) if time > 110.0]  # fmt: skip
    worst = np.abs(samples).max(axis=0)
    assert (worst < 5.0 * deviation).all()  # five deviations: 1e-6 for each of few independent samples
    assert (deviation < 0.2 * np.abs(np.concatenate([TORQUE, BIAS]))).all()  # and these are far below the errors
    # normalised by the covariance: near 1 for each, or below as torque and bias do not walk
    part = found.covariance[6:, 6:]
    nees = np.mean([e @ np.linalg.solve(part, e) for e in samples]) / len(part)
    assert 0.1 < nees < 2.0


def test_errors_are_held_in_an_outage_and_the_attitude_after_it_is_the_measured_one():
    found, slow = _prepared(AXES)
    held, off = [], {}
    for time, state, attitude in _flight(slow, 130.5, TORQUE, BIAS, outage=(110.05, 130.05)):
        if 110.2 < time < 130.0:
            held.append(state.errors.copy())
        error = error_rotation(np.array([mrp_from_quaternion(state.attitude.tolist())]),
                               np.array([mrp_from_quaternion(attitude)]))  # fmt: skip
        off[round(time, 3)] = float(np.abs(error).max())
    assert_array_equal(held, np.broadcast_to(held[0], np.shape(held)))
    assert off[130.0] < 20.0 * 5.0 * np.sqrt(found.covariance[9, 9])  # 20 s of the bias's error, within five deviations
    assert off[130.105] < 5.0 * NOISE.star_tracker
    without, _ = _prepared(AXES, (True, False))
    assert not without.sample[9:].any()
    assert not without.between[9:].any()


def test_other_noise_gives_other_gains():
    first = design_slow_filter(INERTIA, AXES, NOISE, PERIOD, PHASES, BOTH)
    second = design_slow_filter(INERTIA, AXES, replace(NOISE, torque_walk=1e-5), PERIOD, PHASES, BOTH)
    assert (np.diag(second.covariance)[6:9] > 1.2 * np.diag(first.covariance)[6:9]).all()
    assert (np.abs(second.sample[6:9]).max(axis=1) > 1.2 * np.abs(first.sample[6:9]).max(axis=1)).all()


@pytest.mark.parametrize("choice", [(True, False), (False, True), BOTH])
def test_errors_of_the_filter_decay(choice):
    """The transition of the error over a sample of the star tracker has all eigenvalues inside the unit circle."""
    found, slow = _prepared(AXES, choice)
    used = np.flatnonzero(found.sample.any(axis=1))
    size = 9 + len(AXES)
    a, seen = np.eye(size), np.zeros((len(AXES) + 3, size))
    a[:3, 3:6] = PERIOD * np.eye(3)
    a[:3, 6:9], a[3:6, 6:9] = 0.5 * PERIOD**2 * slow.mobility, PERIOD * slow.mobility
    seen[:4, 3:6], seen[:4, 9:], seen[4:, :3] = AXES, np.eye(4), np.eye(3)
    some = np.ix_(used, used)
    first = a[some] @ (np.eye(len(used)) - found.sample[used] @ seen[:, used])
    rest = a[some] @ (np.eye(len(used)) - found.between[used] @ seen[:4, used])
    over = np.linalg.matrix_power(rest, PHASES - 1) @ first
    assert np.abs(np.linalg.eigvals(over)).max() < 1.0 - 1e-4


@pytest.mark.parametrize("choice", [(True, False), (False, True), BOTH])
def test_errors_of_a_truth_that_walks_as_assumed_have_the_covariance_of_the_filter(choice):
    """NEES of 400 bodies at once, whose torque and biases walk: one is consistent.

    Without an estimated torque the rate wanders by the noise of a gyro a step, as the filter assumes.
    """
    found, slow = _prepared(AXES, choice)
    random, members, gyros = np.random.default_rng(2), 400, len(AXES)
    white = NOISE.torque / np.sqrt(PERIOD) if choice[0] else 0.0
    walks = np.repeat(np.array([NOISE.torque_walk, NOISE.bias_walk]) * choice * np.sqrt(PERIOD), [3, gyros])
    truth = {"attitude": np.zeros((members, 3)), "rate": np.zeros((members, 3)), "slow": np.zeros((members, 3 + gyros))}
    known = {name: value.copy() for name, value in truth.items()}
    squares = []
    used = np.repeat(choice, [3, gyros])
    inside = found.covariance[6:, 6:][np.ix_(used, used)]
    wander = NOISE.gyro  # rad/s in a step
    for step in range(round(45.0 / PERIOD)):
        pushed = (truth["slow"][:, :3] + white * random.standard_normal((members, 3))) @ slow.mobility.T * PERIOD
        if not choice[0]:
            pushed = wander * random.standard_normal((members, 3))
        for one, change in ((truth, pushed), (known, PERIOD * known["slow"][:, :3] @ slow.mobility.T)):
            one["attitude"] += PERIOD * (one["rate"] + 0.5 * change)
            one["rate"] += change
        truth["slow"] += walks * random.standard_normal((members, 3 + gyros))
        seen = truth["rate"] @ AXES.T + truth["slow"][:, 3:] + NOISE.gyro * random.standard_normal((members, gyros))
        innovation = seen - known["rate"] @ AXES.T - known["slow"][:, 3:]
        if step % PHASES:
            gain = slow.between
        else:
            error = (known["slow"] - truth["slow"])[:, used]
            squares.append(np.mean(np.sum(error * np.linalg.solve(inside, error.T).T, axis=1)) / len(inside))
            off = truth["attitude"] + NOISE.star_tracker * random.standard_normal((members, 3)) - known["attitude"]
            innovation, gain = np.hstack([innovation, off]), slow.sample
        change = innovation @ gain.T
        known["attitude"] += change[:, ATTITUDE]
        known["rate"] += change[:, RATE]
        known["slow"] += change[:, RATE.stop :]
    nees = np.mean(squares[-150:])
    assert nees == pytest.approx(1.0, abs=0.06)  # 400 members of 3 to 7 degrees, over few time constants
