"""Thrusters: impulse of a pulse, minimum impulse, lag, noise, couples."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import thrusters as interface
from flexsat.runtime.missions import thrusters
from fmus.mission_numbers import MISSION_DATA, values_of

STEP = 5e-3  # s
ROUNDING = 1e-13


def fly(commands: np.ndarray, step: float = STEP, **given: Any) -> tuple[np.ndarray, thrusters.ThrusterState]:
    """Return the mean thrust of each step, (steps, k), and the last state, for commands of periods (periods, k)."""
    parameters = interface.parameters(values_of(interface.ports(MISSION_DATA), given), step)
    prepared = thrusters.prepare(parameters)
    state = thrusters.init(prepared)
    means = [thrusters.step(prepared, state, command) for command in commands for _ in range(prepared.steps)]
    return np.array(means), state


def first_thruster(*thrusts: float) -> np.ndarray:
    """Return commands of the first thruster alone, a row a period."""
    return np.outer(thrusts, np.eye(interface.COUNT)[0])


@pytest.mark.parametrize("step", [1e-3, 5e-3, 0.1])
def test_the_impulse_is_what_was_commanded_whatever_lag_and_step(step: float):
    means, state = fly(first_thruster(0.0123, 0.1, 0.05, *[0.0] * 30), step, thrust__noise=0.0, thrust__lag=0.04)

    # 3 s after the last pulse, 75 time constants, nothing of it is left behind the lag
    assert_allclose(step * means[:, 0].sum(), 0.1 * (0.0123 + 0.1 + 0.05), rtol=1e-12)
    assert_allclose(state.impulse, 0.1 * (0.0123 + 0.1 + 0.05), rtol=1e-12)
    assert_allclose(state.angular_impulse, [0.1 * 0.1623, 0.0, 0.0], rtol=1e-12, atol=1e-18)
    assert state.pulses.tolist() == [3, *[0] * 11]


def test_less_than_the_minimum_impulse_gives_no_pulse():
    means, state = fly(first_thruster(0.00999, 0.01, 0.0, -1.0), thrust__noise=0.0, thrust__minimum_impulse=1e-3)

    assert state.pulses[0] == 1
    assert np.abs(means[:20]).max() == 0.0
    assert_allclose(state.impulse, 1e-3, rtol=0.02)  # but what the lag still holds


def test_thrust_rises_and_falls_as_the_lag_says():
    means, _ = fly(first_thruster(0.1, 0.0), 1e-3, thrust__noise=0.0, thrust__lag=0.02)
    middle = 1e-3 * (np.arange(100) + 0.5)
    rise = 0.1 * (1.0 - np.exp(-middle / 0.02))

    assert_allclose(means[:100, 0], rise, rtol=0.0, atol=0.1 * (1e-3 / 0.02) ** 2 / 24.0 * 1.01)  # mean against middle
    assert_allclose(means[101:, 0] / means[100:-1, 0], math.exp(-1e-3 / 0.02), rtol=1e-12)


def test_more_than_the_thrust_is_not_given():
    means, _ = fly(first_thruster(5.0), thrust__noise=0.0, thrust__lag=0.0)

    assert_allclose(means[:, 0], 0.1, rtol=ROUNDING)


def test_noise_is_that_of_whole_pulses():
    means, _ = fly(np.full((2000, interface.COUNT), 0.1), 0.1, thrust__noise=0.02, thrust__lag=0.0, seed=5)
    scatter = means.std() / 0.1

    assert_allclose(scatter, 0.02, rtol=5.0 / math.sqrt(2.0 * means.size))  # five deviations of the deviation
    assert np.abs(np.corrcoef(means.T) - np.eye(interface.COUNT)).max() < 5.0 / math.sqrt(2000.0)


def test_couples_give_torque_and_no_force():
    wrench = thrusters.wrench_of(np.array(interface.POSITIONS), np.array(interface.DIRECTIONS))
    couples = wrench[:, ::2] + wrench[:, 1::2]

    assert_allclose(couples[:3], 0.0)
    assert_allclose(couples[3:], 2.0 * np.repeat(np.eye(3), 2, axis=1) * [1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
