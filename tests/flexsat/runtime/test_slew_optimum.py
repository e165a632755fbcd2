"""The flown quadratic programme against limits, its own end, and Clarabel's solution of the paper's programme."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.design.slew_programme import solve_slew_programme
from flexsat.runtime import controller as stepper
from flexsat.runtime import slew_guidance, slew_optimum
from flexsat.runtime.prepared_controller import limits_of

DEGREE = np.pi / 180.0
INERTIA, TORQUE, MOMENTUM = 2.177e5, 7.04, 19.35  # of the centralised layout about x, at 80 % of its limits
ANGLES = [1e-5, 0.5 * DEGREE, 3.0 * DEGREE, 179.0 * DEGREE]


def solved(angle, torque=TORQUE, momentum=MOMENTUM):
    profile = slew_guidance.plan(
        np.array([angle, 0.0, 0.0]), 0.0, INERTIA * np.eye(3), np.full(3, torque), np.full(3, momentum)
    )
    times = slew_optimum.time_grid(profile.end, profile.ramp)
    rates = slew_optimum.optimal_rates(angle, torque / INERTIA, momentum / INERTIA, times)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(times))])
    return profile, times, rates, turned


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("faster", [1.0, 1000.0])
def test_optimum_keeps_its_limits_and_ends_at_rest_on_the_angle(angle, faster):
    profile, times, rates, turned = solved(angle, momentum=faster * MOMENTUM)
    limits = 1.0 + 1e-6  # the method stops a billionth away from the optimum, where a bound is met from one side
    assert np.abs(np.diff(rates) / np.diff(times)).max() <= TORQUE / INERTIA * limits
    assert rates.max() <= faster * MOMENTUM / INERTIA * limits
    assert rates[0] == rates[-1] == 0.0
    assert_allclose(turned[-1], angle, rtol=1e-8)  # DONE, in 200 steps
    assert turned.max() <= angle * (1.0 + 1e-8)  # no overshoot
    assert times[-1] > profile.end  # which is the shortest time


def test_optimum_agrees_with_clarabel():
    """The paper's slew: 98.5 s to within 1 %, at the same coast rate; Clarabel's steps are finer, its end is free."""
    _, times, _, turned = solved(0.5 * DEGREE)
    reference = solve_slew_programme(0.5 * DEGREE, INERTIA, TORQUE, MOMENTUM)
    settled = np.interp(0.99, turned / (0.5 * DEGREE), times)
    assert_allclose(settled, reference.settling_time(), atol=0.1)  # of steps of 0.25 s
    at = np.linspace(0.0, 110.0, 50)
    found, expected = np.interp(at, times, turned), np.interp(at, reference.time, reference.rotation)
    assert_allclose(found, expected, atol=2e-4 * 0.5 * DEGREE)


@pytest.mark.parametrize("share", [0.3, 1.0])
@pytest.mark.parametrize("angle", [0.5 * DEGREE, 3.0 * DEGREE])
def test_optimum_from_a_rate_agrees_with_clarabel(share, angle):
    """The rest of a slew in flight, from a part of the largest rate or all of it."""
    acceleration, most = TORQUE / INERTIA, MOMENTUM / INERTIA
    duration = slew_guidance.remaining_duration(angle, acceleration, most, share * most)
    times = slew_optimum.time_grid(duration, most / acceleration)
    rates = slew_optimum.optimal_rates(angle, acceleration, most, times, share * most)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(times))])
    horizon = np.ceil(times[-1]) + 50.0
    reference = solve_slew_programme(angle, INERTIA, TORQUE, MOMENTUM, horizon, initial=share * most)
    at = np.linspace(0.0, times[-1], 50)
    found, expected = np.interp(at, times, turned), np.interp(at, reference.time, reference.rotation)
    assert_allclose(found, expected, atol=2e-4 * angle)
    assert (rates[0], rates[-1]) == (share * most, 0.0)
    assert_allclose(turned[-1], angle, rtol=1e-8)
    assert rates.max() <= most * (1.0 + 1e-6)
    assert np.abs(np.diff(rates) / np.diff(times)).max() <= acceleration * (1.0 + 1e-6)


def test_the_least_duration_from_a_rate_is_that_of_its_ramps_and_coast():
    """Braking alone; up to the largest rate, along and down; from rest as a trapezium."""
    assert slew_guidance.remaining_duration(2.0, 1.0, 2.0, 2.0) == pytest.approx(2.0)
    assert slew_guidance.remaining_duration(7.5, 1.0, 2.0, 1.0) == pytest.approx(1.0 + 2.0 + 2.0)
    # faster than a slew may be: no time is lost in slowing down to that before braking
    assert slew_guidance.remaining_duration(4.0, 1.0, 1.0, 2.0) == pytest.approx(1.0 + 2.0)
    rest = slew_guidance.trapezium(np.array([1.0, 0.0, 0.0]), 7.5, 0.0, 1.0, 2.0)
    assert slew_guidance.remaining_duration(7.5, 1.0, 2.0, 0.0) == pytest.approx(rest.end)


def test_too_short_a_time_is_refused():
    with pytest.raises(ValueError, match=r"slew.guidance = 'qp': the quadratic programme has no optimum"):
        slew_optimum.optimal_rates(0.5 * DEGREE, TORQUE / INERTIA, MOMENTUM / INERTIA, np.linspace(0.0, 50.0, 101))


def test_controller_plans_the_optimum(centralised, flight):
    prepared = stepper.prepare(centralised.controller, flight(centralised, guidance="qp"))
    state = stepper.init(prepared, np.array([0.5 * DEGREE, 0.0, 0.0]), 5.0)
    _, times, rates, _ = solved(0.5 * DEGREE, *prepared_limits(prepared))
    assert_allclose(state.profile.rate(5.0 + times), rates, atol=1e-6 * rates.max())  # scaled to held torques
    assert state.profile.angle == 0.5 * DEGREE
    assert len(stepper.init(prepared, np.zeros(3), 5.0).profile.times) == len(state.profile.times)


def prepared_limits(prepared):
    acceleration, rate = limits_of(prepared, np.array([1.0, 0.0, 0.0]), 0)
    return acceleration * INERTIA, rate * INERTIA


def test_unknown_guidance_is_refused(centralised, flight):
    with pytest.raises(ValueError, match=r"slew\.guidance must be one of bang-coast-bang, smoothed, qp, got 'fast'"):
        flight(centralised, guidance="fast")
    with pytest.raises(ValueError, match=r"command\.during_slew must be one of refuse, replan, got 'ignore'"):
        flight(centralised, during_slew="ignore")
