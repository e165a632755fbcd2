"""The torque of an off-loading is the optimum of its quadratic programme; pulses keep the minimum impulse."""

import clarabel
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import sparse

from flexsat.ports import mission as interface
from flexsat.runtime.missions import off_loading
from flexsat.runtime.missions.off_loading import PreparedOffLoading
from fmus.mission_numbers import MISSION_DATA, values_of

PERIOD = 0.1  # s
MOST = 0.2  # N.m, of a couple of two thrusters of 0.1 N at 1 m


def prepared(**given: float) -> PreparedOffLoading:
    values = values_of(interface.ports(MISSION_DATA), given)
    return interface.parameters(values, 5e-3).off_loading


def fly(programme: PreparedOffLoading, momentum: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the torque of each period, (periods, 3), and the momentum at the end, with perfect thrusters."""
    state = off_loading.init(12)
    off_loading.start_unloading(programme, state, 0.0)
    wrench, torques = np.linalg.pinv(programme.shares) * 2.0, []
    momentum = momentum.copy()
    for k in range(round(seconds / PERIOD)):
        off_loading.plan(programme, state, k * PERIOD, momentum)
        torques.append(wrench @ state.command)
        momentum += PERIOD * torques[-1]
    return np.array(torques), momentum


def solved(momentum: float, periods: int) -> np.ndarray:
    """Return the torques of the quadratic programme of one axis, by an interior-point solver."""
    identity = sparse.eye(periods, format="csc")
    rows = sparse.vstack([PERIOD * np.ones((1, periods)), identity, -identity], format="csc")
    bounds = np.concatenate([[-momentum], np.full(2 * periods, MOST)])
    cones = [clarabel.ZeroConeT(1), clarabel.NonnegativeConeT(2 * periods)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solver = clarabel.DefaultSolver(2.0 * identity, np.zeros(periods), rows, bounds, cones, settings)
    return np.array(solver.solve().x)


@pytest.mark.parametrize("momentum", [1.7, -0.9])
def test_the_torque_is_the_optimum_of_the_quadratic_programme(momentum: float):
    programme = prepared(off_loading__duration=10.0, thrust__minimum_impulse=0.0)
    torques, _ = fly(programme, np.array([0.0, momentum, 0.0]), 9.0)

    # until the last tenth of the time, which is taken for left whatever the clock says
    assert_allclose(torques[:, 1], solved(momentum, 100)[:90], rtol=1e-6)
    assert_allclose(torques[:, [0, 2]], 0.0, atol=1e-15)


def test_more_than_the_thrusters_give_is_spread_over_twice_the_time():
    programme = prepared(off_loading__duration=10.0, thrust__minimum_impulse=0.0)
    torques, left = fly(programme, np.array([3.0, 0.0, 0.0]), 10.0)

    assert_allclose(torques[:, 0], -MOST, rtol=1e-12)
    assert_allclose(left[0], 3.0 - MOST * 10.0, rtol=1e-9)
    state = off_loading.init(12)
    off_loading.start_unloading(programme, state, 0.0)
    assert not off_loading.is_done(programme, state, 10.0, left)
    assert off_loading.is_done(programme, state, 20.0, left)
    assert off_loading.is_done(programme, state, 10.0, np.full(3, 0.019))


def test_no_pulse_is_below_the_minimum_impulse_and_what_is_owed_is_fired_later():
    programme = prepared(off_loading__duration=100.0, thrust__minimum_impulse=5e-3)
    torques, left = fly(programme, np.array([0.5, 0.0, 0.0]), 90.0)
    fired = torques[torques[:, 0] != 0.0, 0]

    # 5 mN.m over 0.1 s is a twentieth of the least impulse of a couple, 0.01 N.m.s: one period of twenty fires
    assert np.abs(fired).min() * PERIOD >= 0.01 * (1.0 - 1e-9)
    assert 40 <= len(fired) <= 50
    assert_allclose(left[0], 0.05, atol=0.011)  # a tenth of the time is left, within a pulse
