"""The paper's quadratic programme: its optimum is nearly the bang-coast-bang profile that flies."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.design.slew_programme import solve_slew_programme
from flexsat.runtime.slew_guidance import plan

ANGLE, INERTIA = np.radians(0.5), 2.177e5


def capability(design):
    """Torque [N.m] and momentum [N.m.s] that the slew may use about x."""
    wheel = design.config.wheel
    share = design.config.slew.authority * np.abs(design.plant.wheel_axis[:, 0]).sum()
    return share * wheel.torque_limit, share * wheel.inertia * wheel.speed_band


def test_its_optimum_is_the_profile(design):
    torque, momentum = capability(design)
    programme = solve_slew_programme(ANGLE, INERTIA, torque, momentum)
    profile = plan(np.array([ANGLE, 0.0, 0.0]), 0.0, INERTIA * np.eye(3), np.full(3, torque), np.full(3, momentum))
    fine = np.linspace(0.0, 150.0, 150_001)
    settled = fine[np.flatnonzero(np.abs(profile.rotation(fine) - ANGLE) > 0.01 * ANGLE)[-1]]

    # asked for: 2 %; the programme may round the corners that the profile cuts square, and steps are 0.25 s
    assert_allclose(programme.settling_time(), settled, rtol=0.02)
    assert_allclose(programme.coast_rate, profile.coast_rate, rtol=0.02)
    # and the numbers of PHYSICS section 6, printed to four digits
    assert_allclose(programme.settling_time(), 98.5, atol=0.25)


def test_dynamics_and_bounds_hold(design):
    torque, momentum = capability(design)
    programme = solve_slew_programme(ANGLE, INERTIA, torque, momentum)

    tight = 1e-6  # the solver's own feasibility tolerance is 1e-8 of the scaled variables
    assert np.abs(programme.torque).max() <= torque * (1.0 + tight)
    assert np.abs(INERTIA * programme.rate).max() <= momentum * (1.0 + tight)
    turned = np.diff(programme.rotation) - 0.25 * programme.rate[:-1] - 0.5 * 0.25**2 * programme.torque / INERTIA
    assert_allclose(turned, 0.0, atol=tight * ANGLE)
    assert_allclose(programme.rotation[-1], ANGLE, rtol=1e-4)  # the horizon is half as long again as the slew


def test_without_rate_weight_it_overshoots(design):
    torque, momentum = capability(design)
    damped = solve_slew_programme(ANGLE, INERTIA, torque, momentum)
    bare = solve_slew_programme(ANGLE, INERTIA, torque, momentum, rate_weight=0.0)
    assert damped.rotation.max() < ANGLE * 1.001
    assert bare.rotation.max() > damped.rotation.max() + 1e-3 * ANGLE


@pytest.fixture(params=["centralised", "distributed"])
def design(request):
    """Each configuration's corrected design."""
    return request.getfixturevalue(request.param)
