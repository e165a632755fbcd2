"""Division of a torque between wheels: against a linear programme, closed forms, and the envelope of the wheels."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog

from flexsat.allocation import least_peak, least_squares
from flexsat.description.built_in import configuration
from flexsat.spacecraft.properties import envelope

PYRAMID = np.array([[1.0, 0.0, 1.0], [0.0, -1.0, -1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, -1.0]]) / np.sqrt(2.0)


def programme(axes, limits, torque):
    """Return the least peak share by SciPy's linear programme."""
    n = len(axes)
    held = np.block([[np.eye(n), -np.ones((n, 1))], [-np.eye(n), -np.ones((n, 1))]])
    equal = np.hstack([axes.T * limits, np.zeros((3, 1))])
    return linprog(np.eye(n + 1)[n], A_ub=held, b_ub=np.zeros(2 * n), A_eq=equal, b_eq=-torque,
                   bounds=[(None, None)] * n + [(0, None)]).fun  # fmt: skip


@pytest.mark.parametrize("count", [3, 4, 5, 9])
def test_the_peak_is_that_of_a_linear_programme(count):
    random = np.random.default_rng(count)
    for _ in range(20):
        axes = random.normal(size=(count, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        limits, torque = random.uniform(0.1, 2.0, count), random.normal(size=3)
        found = least_peak(axes, limits, torque)
        assert_allclose(axes.T @ found, -torque, rtol=0.0, atol=1e-13)
        # the solver's tolerance
        assert np.max(np.abs(found) / limits) == pytest.approx(programme(axes, limits, torque), rel=1e-7)
        squares = least_squares(axes, limits**2) @ torque
        assert np.max(np.abs(found) / limits) <= np.max(np.abs(squares) / limits) * (1.0 + 1e-12)


def test_wheels_along_a_face_share_what_is_left_with_the_least_peak_too():
    """Two strong wheels along x, two weak along x, one each along y and z: a torque about y loads its wheel alone."""
    axes = np.array([[1.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    limits = np.array([2.0, 1.0, 1.0, 1.0, 1.0])
    found = least_peak(axes, limits, np.array([-1.0, 3.0, -0.5]))
    assert_allclose(found, [0.5, 0.25, 0.25, -3.0, 0.5], rtol=1e-14)


def test_the_peak_at_the_envelope_is_one():
    """What the wheels give at most about an axis needs all of some wheel, for unequal limits in any direction."""
    axes, limits = PYRAMID, np.array([4.4, 2.0, 4.4, 3.0])
    reach = envelope(axes * limits[:, np.newaxis])
    for direction, most in (*zip(np.eye(3), reach.about, strict=True), (reach.direction, reach.weakest)):
        assert np.max(np.abs(least_peak(axes, limits, most * direction)) / limits) == pytest.approx(1.0, rel=1e-12)


def test_a_pyramid_gains_across_its_edges():
    """Of four equal wheels, half way between two of them: peak share 1/2 of the torque over root 2 against 3/4."""
    torque = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)  # along the first wheel
    squares = np.abs(least_squares(PYRAMID, np.ones(4)) @ torque).max()
    peak = np.abs(least_peak(PYRAMID, np.ones(4), torque)).max()
    assert (squares, peak) == (pytest.approx(0.75, rel=1e-12), pytest.approx(0.5, rel=1e-12))


def test_a_failed_wheel_gives_none_and_too_few_are_refused():
    limits = np.array([1.0, 1.0, 0.0, 1.0])
    assert least_peak(PYRAMID, limits, np.array([0.1, 0.2, -0.3]))[2] == 0.0
    assert not least_peak(PYRAMID, limits, np.zeros(3)).any()
    with pytest.raises(ValueError, match="cannot turn the body about all axes"):
        least_peak(PYRAMID, limits * [1.0, 0.0, 1.0, 1.0], np.ones(3))


def test_many_parallel_wheels():
    """The distributed layout: eleven wheels along each axis, of one limit, share alike."""
    axes = np.array([device.axis for device in configuration("distributed").wheels])
    found = least_peak(axes, np.full(33, 0.8), np.array([0.3, -0.2, 0.1]))
    assert_allclose(np.abs(axes.T @ found), [0.3, 0.2, 0.1], rtol=1e-13)
    assert_allclose(np.abs(found), np.repeat([[0.3, 0.2, 0.1]], 11, axis=0).ravel() / 11.0, rtol=1e-12)
