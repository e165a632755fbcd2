"""A wheel that does not follow its torque: what is found, when, and what is not."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import mission as interface
from flexsat.runtime.missions import failure_detection
from flexsat.runtime.missions.failure_detection import OFF, SEIZED, WORKS
from fmus.mission_numbers import MISSION_DATA, values_of

STEP = 5e-3  # s
NOISE = 3e-4  # rad/s, of an encoder
INERTIA = 4.62  # kg.m2
Watched = tuple[failure_detection.DetectionState, float | None, np.ndarray, float]


def watch(seconds: float, torque: float, braking: float, loses: float = 0.0) -> Watched:
    """Return the last state, when a failure was found, the true speeds, and the momentum found of wheel 1.

    From 1 s on that wheel loses a share of its torque, and its bearing brakes it until it rests.
    """
    prepared = interface.parameters(values_of(interface.ports(MISSION_DATA), {}), STEP).detection
    state = failure_detection.init(6)
    random = np.random.default_rng(2)
    speed = MISSION_DATA.nominal_speed.copy()
    commands = np.full(6, torque)
    found = None
    given = 0.0
    for k in range(round(seconds / STEP)):
        failure_detection.step(prepared, state, k == 0, commands, speed + NOISE * random.standard_normal(6))
        given += STEP * state.given[0]
        if found is None and np.any(state.status):
            found = k * STEP
        true = commands.copy()
        if k * STEP >= 1.0:
            true[0] = torque * (1.0 - loses) - braking * np.sign(speed[0])
        speed += STEP * true / INERTIA
        if k * STEP >= 1.0 and abs(speed[0]) < braking * STEP / INERTIA:
            speed[0] = 0.0
    return state, found, speed, given


def test_nothing_is_found_in_noise_and_torque():
    state, found, _, _ = watch(60.0, 0.5, 0.0)

    assert found is None
    assert state.status.tolist() == [WORKS] * 6


def test_a_seizing_wheel_is_found_within_the_persistence_and_its_momentum_is_known():
    state, found, speed, given = watch(12.0, 0.0, 20.0)

    assert 1.0 < found <= 1.0 + 0.025 + 2 * STEP  # a residual of 0.02 rad/s after one step
    assert state.status.tolist() == [SEIZED, *[WORKS] * 5]
    # all that the wheel has lost, but for a change below the threshold, noise on it
    assert_allclose(given, INERTIA * (speed[0] - MISSION_DATA.nominal_speed[0]), atol=INERTIA * (3e-3 + 5.0 * NOISE))


@pytest.mark.parametrize(("torque", "latest"), [(0.1, 0.25), (0.02, 2.0)])
def test_a_lost_torque_is_found_when_its_residual_has_grown(torque: float, latest: float):
    state, found, _, _ = watch(8.0, torque, 0.0, loses=1.0)

    # d T / J (1 - exp(-t / T)) reaches 3e-3 rad/s, with T = 1 s, then the persistence
    residual = torque * 1.0 / INERTIA
    grown = -np.log(1.0 - 3e-3 / residual)
    assert 1.0 + 0.7 * grown < found < 1.0 + 1.3 * grown + 0.05
    assert found < 1.0 + latest
    assert state.status.tolist() == [OFF, *[WORKS] * 5]


def test_a_torque_below_the_threshold_is_not_found():
    _, found, _, _ = watch(8.0, 0.01, 0.0, loses=1.0)  # a residual of 2.2e-3 rad/s

    assert found is None
