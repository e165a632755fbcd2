"""Null motion of redundant wheels: no torque on the body, within limits, and speeds that stay in their bands."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.allocation import least_peak, null_motion, null_part, null_torque
from flexsat.closed_loop import ClosedLoop
from flexsat.design.chain import Designs, designs_of

ARCSECOND = np.pi / 648000.0
BAND = 0.5  # rad/s, of the wheels of the pyramid


@pytest.fixture(scope="module")
def designs(pyramid) -> Designs:
    configurations = pyramid((1.5, 2.0), f"speed_band = {BAND}", f"speed_band = {0.5 * BAND}").configurations
    return designs_of(configurations["robust"], configurations["published"])


def motion_of(random, count, failed=()):
    axes = random.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    works = ~np.isin(np.arange(count), failed)
    return null_motion(axes, random.uniform(0.5, 2.0, count), works, 0.1), axes


@pytest.mark.parametrize(("count", "failed"), [(4, ()), (6, ()), (6, (2,)), (33, (0, 7))])
def test_no_torque_on_the_body_and_none_beyond_what_is_left(count, failed):
    random = np.random.default_rng(count)
    for _ in range(10):
        motion, axes = motion_of(random, count, failed)
        momenta = random.normal(size=count)
        least, most = -random.uniform(0.0, 0.02, count), random.uniform(0.0, 0.02, count)
        torque = null_torque(motion, momenta, least, most)
        largest = np.abs(torque).max()
        assert largest > 0.0
        assert_allclose(torque @ axes, 0.0, atol=1e-14 * largest * count)
        assert np.all((torque >= least - 1e-16) & (torque <= most + 1e-16))
        assert not torque[list(failed)].any()
        # with room, it is the way to the least peak: the largest share falls, all the way in 1/rate
        free = null_torque(motion, momenta, np.full(count, -np.inf), np.full(count, np.inf))
        arrived = (momenta + free / motion.rate)[motion.limits > 0.0] / motion.limits[motion.limits > 0.0]
        aim = least_peak(motion.axes, motion.limits, -(momenta @ motion.axes))
        assert np.abs(arrived).max() == pytest.approx((np.abs(aim[aim != 0.0]) / motion.limits[aim != 0.0]).max())


def test_three_wheels_have_no_null_motion():
    random = np.random.default_rng(3)
    motion, _ = motion_of(random, 3)
    momenta = random.normal(size=3)
    assert_allclose(null_part(motion, momenta), 0.0, atol=1e-13)
    assert np.abs(null_torque(motion, momenta, np.full(3, -1.0), np.full(3, 1.0))).max() < 1e-13


def test_speeds_stay_in_their_bands_with_it_and_leave_them_without(designs):
    """A torque about the axis of one wheel: by least squares that wheel takes most of it, and the others little."""
    torque = 0.022 * np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    runs = {}
    for rate in (0.0, 1.0):
        parameters = {
            "plant": {"external.torque": torque},
            "sensors": {"jitter.enabled": False},
            "controller": {"wheel.null_motion_rate": rate, "star_tracker.fine": True},
        }
        runs[rate] = ClosedLoop(designs, parameters).run(7.0, ["plant.wheel.speed", "plant.attitude.mrp"], 50).signals
    wheels = designs.corrected.spacecraft.wheel_set
    speeds = {rate: run["plant.wheel.speed"] - run["plant.wheel.speed"][0] for rate, run in runs.items()}
    share = {rate: np.abs(speed / wheels.speed_band).max(axis=1) for rate, speed in speeds.items()}
    errors = {rate: 4.0 / ARCSECOND * np.linalg.norm(run["plant.attitude.mrp"], axis=1) for rate, run in runs.items()}
    # all of the torque goes to the wheels: 0.154 N.m.s, of which least squares give the first wheel 1.11 of its band
    assert share[0.0].max() > 0.999
    assert share[1.0].max() < 0.93
    # the same momentum, and the same pointing while both have room: 8 arcsec as the torque sets in
    before = slice(0, 115)  # 5.75 s
    assert np.abs(errors[1.0] - errors[0.0])[before].max() < 0.2
    axes = designs.corrected.spacecraft.wheels.axis
    held = {rate: (speed[before] * wheels.inertia) @ axes for rate, speed in speeds.items()}
    assert_allclose(held[1.0], held[0.0], atol=5e-3 * np.abs(held[0.0]).max())
