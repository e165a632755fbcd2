"""Errors of sensors: statistics of what is drawn and walks, geometry of misalignment and blinding."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from flexsat import sensor_errors
from flexsat.sensor_errors import ErrorParameters

AXES = np.eye(3)
FAST, SLOW = 5e-3, 0.1  # s
NONE = ErrorParameters(
    gyro_bias=np.zeros(3), gyro_bias_deviation=0.0, gyro_bias_walk=0.0, gyro_scale_error=np.zeros(3),
    gyro_scale_error_deviation=0.0, gyro_misalignment_deviation=0.0, accelerometer_bias=np.zeros(2),
    accelerometer_bias_deviation=0.0, misalignment=np.zeros(3), low_frequency_error=0.0, low_frequency_time=100.0,
    boresight=np.array([0.0, 0.0, 2.0]), roll_factor=1.0, sources=np.zeros((2, 3)), half_angles=np.zeros(2),
)  # fmt: skip


def made(seed: int = 1, axes: np.ndarray = AXES, **changes: object):
    given = replace(NONE, **changes)
    prepared = sensor_errors.prepare_errors(given, axes, np.linalg.pinv(axes), FAST, SLOW)
    return prepared, sensor_errors.init_errors(prepared, np.random.default_rng(seed))


def within(values: np.ndarray, deviation: float) -> bool:
    """Return whether the squares of normal values are likely: one false alarm in 1e6, and the seed is fixed."""
    low, high = chi2.ppf([5e-7, 1.0 - 5e-7], values.size)
    return bool(low < np.sum((values / deviation) ** 2) < high)


def test_without_errors_nothing_is_changed_or_drawn():
    prepared, state = made()
    rate, gyro, accelerometer = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0])
    drawn = state.random.bit_generator.state
    sensor_errors.add_fast_errors(prepared, state, False, rate, gyro, accelerometer)
    assert_array_equal(gyro, [1.0, 2.0, 3.0])
    assert_array_equal(accelerometer, [4.0, 5.0])
    assert sensor_errors.star_tracker_error(prepared, state, False, [1.0, 2.0, 3.0]) == [1.0, 2.0, 3.0]
    assert not sensor_errors.is_blinded(prepared, np.array([0.0, 0.0, 0.0, 1.0]))
    assert state.random.bit_generator.state == drawn


def test_biases_and_scales_are_drawn_with_their_deviations():
    axes = np.tile(AXES, (300, 1))
    many = {"gyro_bias": np.full(900, 0.5), "gyro_scale_error": np.full(900, 0.01)}
    _, state = made(axes=axes, gyro_bias_deviation=1e-5, gyro_scale_error_deviation=1e-3, **many)
    assert within(state.gyro_bias - 0.5, 1e-5)
    assert within(state.gyro_scale - 0.01, 1e-3)


def test_a_bias_walks_with_the_root_of_time():
    axes = np.tile(AXES, (100, 1))
    prepared, state = made(axes=axes, gyro_bias=np.zeros(300), gyro_scale_error=np.zeros(300), gyro_bias_walk=2e-6)
    measured = np.zeros(300)
    for step in range(401):  # 2 s
        measured[:] = 0.0
        sensor_errors.add_fast_errors(prepared, state, step == 0, np.zeros(300), measured, np.zeros(2))
    assert_array_equal(measured, state.gyro_bias)
    assert within(measured, 2e-6 * np.sqrt(2.0))


def test_the_first_sample_has_what_was_drawn_at_the_start():
    """Nothing has walked or drifted before it, and nothing is drawn for that."""
    prepared, state = made(gyro_bias_deviation=1e-5, gyro_bias_walk=1.0, low_frequency_error=1e-4)
    before, bias, error = state.random.bit_generator.state, state.gyro_bias.copy(), state.low_frequency.copy()
    measured = np.zeros(3)
    sensor_errors.add_fast_errors(prepared, state, True, np.zeros(3), measured, np.zeros(2))
    assert_array_equal(measured, bias)
    assert_array_equal(sensor_errors.star_tracker_error(prepared, state, True, [0.0, 0.0, 0.0]), error)
    assert state.random.bit_generator.state == before


def test_a_misaligned_gyro_senses_along_its_turned_axis():
    """To first order in the rotation; the body's rate is that of all gyros' true rates."""
    axes = np.vstack([AXES, [0.6, 0.0, 0.8]])
    mounting = 1e-4 * np.array([[1.0, 0.0, -2.0, 0.5], [0.0, 3.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 2.0]])
    prepared, state = made(axes=axes, gyro_misalignment_deviation=1e-4, gyro_bias=np.zeros(4),
                           gyro_scale_error=np.zeros(4), gyro_mounting=mounting)  # fmt: skip
    random = np.random.default_rng(1)
    random.standard_normal(8)  # biases, scales
    turned = mounting + 1e-4 * random.standard_normal((3, 4))
    body = np.array([1e-3, -2e-3, 3e-3])
    measured = np.zeros(4)
    sensor_errors.add_fast_errors(prepared, state, True, axes @ body, measured, np.zeros(2))
    along = np.array([Rotation.from_rotvec(turned[:, k]).apply(axes[k]) @ body for k in range(4)])
    # what is left out is of second order: 1e-7 of the rate
    assert_allclose(measured, along - axes @ body, atol=2e-7 * 3e-3)
    assert np.abs(measured).max() > 1e-8


def test_the_low_frequency_error_is_stationary_and_forgets_in_its_time():
    prepared, state = made(low_frequency_error=1e-4, low_frequency_time=0.5)
    found = np.array([sensor_errors.star_tracker_error(prepared, state, k == 0, [0.0, 0.0, 0.0]) for k in range(6000)])
    # correlated samples: as many independent ones as correlation times, twice
    count = len(found) * SLOW / (2.0 * 0.5)
    assert_allclose(np.mean(found**2, axis=0), 1e-8, rtol=5.0 * np.sqrt(2.0 / count))
    lag = np.mean(found[5:] * found[:-5]) / np.mean(found**2)
    assert lag == pytest.approx(np.exp(-1.0), abs=5.0 / np.sqrt(3.0 * count))


def test_noise_about_the_boresight_is_multiplied():
    prepared, state = made(roll_factor=5.0, boresight=np.array([3.0, 0.0, 4.0]), misalignment=np.array([0.0, 7.0, 0.0]))
    across = sensor_errors.star_tracker_error(prepared, state, True, [-0.8, 0.1, 0.6])
    assert_allclose(across, [-0.8, 7.1, 0.6], atol=1e-15)
    along = sensor_errors.star_tracker_error(prepared, state, True, [0.6, 0.0, 0.8])
    assert_allclose(along, [3.0, 7.0, 4.0], atol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_a_source_blinds_within_its_half_angle_of_the_boresight(seed):
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed)  # inertial from body, as vectors turn
    boresight, sun = random.normal(size=3), random.normal(size=3)
    angle = np.arccos(turn.apply(boresight) @ sun / np.linalg.norm(boresight) / np.linalg.norm(sun))
    attitude = turn.as_quat()  # of C body from inertial, whose transpose turns vectors of the body to inertial axes
    for half_angle, expected in ((angle + 1e-6, True), (angle - 1e-6, False)):
        prepared, _ = made(boresight=boresight, sources=np.array([sun, [1.0, 0.0, 0.0]]),
                           half_angles=np.array([half_angle, 0.0]))  # fmt: skip
        assert sensor_errors.is_blinded(prepared, attitude) is expected
