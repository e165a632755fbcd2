"""The experiments and the judgement of a controller, without an FMU: the motion is one that sensors agree on."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.adapt.excitation import Excitation, Response, motion
from flexbench.adapt.judge import judge

STIFFNESS, DAMPING = np.diag([2.0, 3.0, 4.0]), np.diag([20.0, 30.0, 40.0])


def excited(*gyros):
    """Return the excitation of a spacecraft with gyros along these axes."""
    return Excitation(
        component="controller:any", ports={}, period=5_000_000, nominal={}, attitude=("x", "y", "z"),
        rate={f"gyro[{k}]": axis for k, axis in enumerate(gyros, start=1)}, torque=("t",), wheel_axis=np.eye(3),
        stiffness=STIFFNESS, damping=DAMPING, angle=1e-3, speed=1e-4,
    )  # fmt: skip


def answer(rate_about_z):
    """Return the response of the reference, with another one to a rate about z."""
    rate = -DAMPING.copy()
    rate[:, 2] = rate_about_z
    return Response(rest=np.zeros(3), attitude=-STIFFNESS.copy(), rate=rate, wheels=1e-3)


@pytest.mark.parametrize(("rotation", "rate"), [((0, 2e-3, 0), (0, 0, 0)), ((0, 0, 0), (0, 0, 4e-4))])
def test_attitudes_are_the_integral_of_the_rates_and_begin_and_end_where_they_shall(rotation, rate):
    rotation, rate = np.array(rotation, float), np.array(rate, float)
    positions, rates = motion(rotation, rate, 20, 0.05)
    assert_allclose(np.diff(positions, axis=0), 0.05 * rates[1:], atol=1e-18)
    assert_allclose(np.vstack([positions[0], rates[0]]), 0.0, atol=0.0)  # from rest, where a controller begins to count
    assert_allclose(positions[-1], rotation, atol=1e-17)
    assert_allclose(rates[-20:], np.tile(rate, (20, 1)), atol=0.0)


def test_a_rate_that_no_gyro_measures_is_not_judged():
    silent, wrong = answer(np.zeros(3)), answer(np.array([-40.0, 0.0, 10.0]))
    two, skew = excited((1, 0, 0), (0, 1, 0)), excited((1, 0, 0), (0, 0.6, 0.8))
    for response in (silent, wrong):
        found = judge(response, two)
        assert found.problems == ()
        assert found.measured == (True, True, False)
        assert (found.bandwidth, found.damping) == pytest.approx((1.0, 1.0))
    assert judge(silent, skew).measured == (True, False, False)
    three = excited((1, 0, 0), (0, 0.6, 0.8), (0, -0.8, 0.6))
    assert judge(silent, three).problems == ("no response to rate errors about z",)
    assert judge(wrong, three).problems == ("rate error about z: torque as for one about x",)
