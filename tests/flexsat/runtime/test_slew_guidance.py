"""Slew profiles and the shaper: closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from flexsat.runtime import slew_guidance as guidance
from flexsat.runtime import slew_motion
from flexsat.runtime.prepared_controller import plan_slew, prepare
from flexsat.runtime.zero_order_hold import zero_order_hold

DEGREE = np.pi / 180.0
INERTIA = np.diag([200.0, 300.0, 400.0])
TORQUE, MOMENTUM = np.array([2.0, 1.0, 4.0]), np.array([10.0, 20.0, 8.0])


def planned(rotation, start=5.0):
    return guidance.plan(np.asarray(rotation), start, INERTIA, TORQUE, MOMENTUM)


LONG, SHORT = (1.2, 0.0, 0.0), (0.05, 0.0, 0.0)  # about x: rate limit .05 rad/s reached after 5 s and .125 rad


@pytest.mark.parametrize("rotation", [LONG, SHORT, (-0.3, 0.4, 0.1), (0.0, 0.0, 2.0), (1e-6, 0.0, 0.0)])
def test_profile_turns_exactly_the_angle(rotation):
    profile = planned(rotation)
    angle = np.linalg.norm(rotation)
    ends = profile.rotation(np.array([0.0, profile.start, profile.end, profile.end + 100.0]))
    assert_allclose(ends, [0.0, 0.0, angle, angle], rtol=1e-12, atol=1e-16)  # rounding
    assert_allclose(profile.angle * profile.axis, rotation, rtol=1e-14)
    assert_allclose(profile.rate(np.array([profile.start, profile.end])), 0.0, atol=1e-14)


def test_long_and_short_slews():
    """Acceleration 2/200 rad/s2, rate 10/200 rad/s about x: trapezium, and triangle of 2 sqrt(angle/acceleration)."""
    long, short = planned(LONG), planned(SHORT)
    assert_allclose([long.ramp, long.coast_rate, long.coast], [5.0, 0.05, 1.2 / 0.05 - 5.0], rtol=1e-13)
    root = np.sqrt(0.05 / 0.01)
    assert_allclose([short.ramp, short.coast_rate], [root, 0.01 * root], rtol=1e-13)
    assert_allclose(short.coast, 0.0, atol=1e-13)  # rounding of a difference of 2 s


@pytest.mark.parametrize("rotation", [LONG, SHORT, (-0.3, 0.4, 0.1), (0.0, 0.7, 2.0)])
def test_limits_are_kept_and_one_is_reached(rotation):
    profile = planned(rotation)
    share = np.abs(INERTIA @ profile.axis)
    torque = share * profile.coast_rate / profile.ramp / TORQUE
    momentum = share * profile.coast_rate / MOMENTUM
    assert_allclose(torque.max(), 1.0, rtol=1e-12)  # the quickest uses all torque
    assert momentum.max() <= 1.0 + 1e-12
    assert profile.coast < 1e-9 or momentum.max() > 1.0 - 1e-12  # and coasts at the momentum limit only


@pytest.mark.parametrize("rotation", [LONG, SHORT])
def test_rotation_is_the_integral_of_rate(rotation):
    profile = planned(rotation)
    corners = [profile.start, profile.start + profile.ramp, profile.end - profile.ramp, profile.end]
    for time in np.linspace(profile.start - 1.0, profile.end + 1.0, 9):
        breaks = [c for c in corners if profile.start - 2.0 < c < time]
        exact, _ = quad(
            lambda t: float(profile.rate(np.array([t]))[0]), profile.start - 2.0, time, points=breaks, epsabs=1e-13
        )
        assert_allclose(profile.rotation(np.array([time]))[0], exact, atol=1e-12)  # the quadrature's tolerance


def test_a_rotation_of_zero_gives_no_slew():
    profile = planned((0.0, 0.0, 0.0))
    times = np.array([0.0, 5.0, 50.0])
    assert profile.end == 5.0
    assert not profile.rate(times).any()
    assert not profile.rotation(times).any()


def test_slew_of_the_paper(design, flight):
    """PHYSICS section 6: half a degree about x lasts about 100.9 s at .306 deg/min, in both configurations."""
    controller = prepare(design.controller, flight(design))
    profile = plan_slew(controller, np.array([0.5 * DEGREE, 0.0, 0.0]), 5.0)
    assert_allclose(profile.end - profile.start, 100.9, atol=0.05)  # as printed
    assert_allclose(profile.coast_rate / DEGREE * 60.0, 0.306, atol=5e-4)  # as printed


POLES = [(1.7, 0.005, 0.005), (12.0, 0.02, 0.005), (3.0, 0.0, 0.1), (40.0, 0.3, 0.005)]


@pytest.mark.parametrize(("frequency", "damping", "period"), POLES)
def test_shaper_has_its_zeros_at_the_pole(frequency, damping, period):
    shaper = guidance.shaper_for_pole(frequency, damping, period)
    pole = frequency * (-damping + 1j * np.sqrt(1.0 - damping**2))
    for root in (pole, pole.conjugate()):
        # a tap at t + shift acts shift earlier: its transfer function is exp(s shift)
        assert abs(np.sum(shaper.weights * np.exp(root * shaper.shifts))) < 1e-14  # rounding
    assert_allclose(shaper.weights.sum(), 1.0, rtol=1e-14)
    assert_allclose(shaper.shifts[1:] + shaper.shifts[:-1], [shaper.shifts[0], shaper.shifts[2]], atol=0.0)


@pytest.mark.parametrize(("frequency", "damping", "period"), POLES)
def test_shaper_is_the_shortest_with_positive_weights(frequency, damping, period):
    shaper = guidance.shaper_for_pole(frequency, damping, period)
    assert np.all(shaper.weights > 0.0)
    damped = frequency * np.sqrt(1.0 - damping**2)
    # the middle weight is -2 exp(..) cos(damped spacing): positive just beyond a quarter of the damped period
    assert np.cos(damped * shaper.shifts[0]) < 0.0
    assert np.cos(damped * (shaper.shifts[0] - period)) >= 0.0
    assert_allclose(shaper.shifts[0] / period, round(shaper.shifts[0] / period), rtol=1e-12)


@pytest.mark.parametrize("rotation", [LONG, SHORT])
@pytest.mark.parametrize("start", [5.0, 5.0013])
def test_a_shaped_pulse_leaves_no_vibration(rotation, start):
    """The mode of the pole, driven by the shaped acceleration held over each period, is at rest when it ends."""
    frequency, damping, period = 1.7, 0.005, 0.005
    shaper, profile = guidance.shaper_for_pole(frequency, damping, period), planned(rotation, start)
    motion = slew_motion.from_profile(profile, 8, period, 0.0)
    mode = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])
    a, b = zero_order_hold(mode, np.array([[0.0], [1.0]]), period)
    unshaped, shaped, turned, most = np.zeros(2), np.zeros(2), 0.0, 0.0
    for k in range(round((profile.end + shaper.shifts[0]) / period) + 2):
        time = k * period
        change = slew_motion.shaped_rate_change(motion, shaper, time, period)
        turned += change
        shaped = a @ shaped + b[:, 0] * change / period
        rise = profile.rate(np.array([time, time + period]))
        unshaped = a @ unshaped + b[:, 0] * (rise[1] - rise[0]) / period
        most = max(most, abs(shaped[1]))
    assert_allclose(turned, 0.0, atol=1e-13)  # rest to rest; rounding
    # zero in closed form: the filter's zero is on the pole, and its spacing on the grid. 1e4 roundings remain
    assert np.abs(shaped).max() < 1e-11 * most
    assert np.abs(unshaped).max() > 0.01 * most  # unshaped, the same pulse leaves it ringing


def test_shaper_has_no_mean_lag():
    """Far into a coast the shaped rate is the rate, and the middle of the pulse stays where it was."""
    shaper, profile = guidance.shaper_for_pole(1.7, 0.0, 0.005), planned(LONG)
    motion = slew_motion.from_profile(profile, 8, 0.005, 0.0)
    times = 0.005 * np.arange(3000)
    change = np.array([slew_motion.shaped_rate_change(motion, shaper, t, 0.005) for t in times])
    assert_allclose(change.sum(), 0.05, rtol=1e-12)  # unit gain at rest: the coast rate; 15 s is in the coast
    middle = float((times + 0.0025) @ change / change.sum())
    assert_allclose(middle, 7.5, rtol=1e-12)  # undamped weights are symmetric: the centre of 5 to 10 s
