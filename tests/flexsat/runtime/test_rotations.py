"""Rotations against SciPy. Those of flexsat map inertial to body components, SciPy's turn vectors: the inverse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from flexsat.runtime import rotations

ULPS = 1e-14  # a dozen operations on numbers of order one


def sample(count: int = 40) -> Rotation:
    return Rotation.random(count, random_state=np.random.default_rng(11))


def attitude(rotation: Rotation) -> np.ndarray:
    """Return SciPy's direction cosines, body from inertial, of a rotation that turns the body away from inertial."""
    return rotation.as_matrix().T


def test_matrix_of_a_quarter_turn_about_z():
    """The closed form that fixes the convention: after +90 deg about z, inertial x is body -y."""
    matrix = rotations.matrix_from_mrp([0.0, 0.0, np.tan(np.pi / 8.0)])
    assert_allclose(matrix @ [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], atol=ULPS)


def test_matrix_and_quaternion_of_mrp():
    for one in sample():
        mrp = one.as_mrp()
        assert_allclose(rotations.matrix_from_mrp(mrp), attitude(one), atol=ULPS)
        assert_allclose(rotations.quaternion_from_mrp(mrp), one.as_quat(canonical=True), atol=ULPS)


def test_mrp_of_quaternion_is_the_short_one_for_both_signs():
    for one in sample():
        quaternion = one.as_quat()
        for sign in (1.0, -1.0):
            mrp = np.array(rotations.mrp_from_quaternion(sign * quaternion))
            assert np.linalg.norm(mrp) <= 1.0 + ULPS
            assert_allclose(rotations.matrix_from_mrp(mrp), attitude(one), atol=ULPS)


def test_shadow_set_is_the_same_attitude():
    mrp = np.array([0.9, -0.7, 0.5])  # norm 1.24: the long way round
    shadow = np.array(rotations.mrp_from_quaternion(rotations.quaternion_from_mrp(mrp)))
    assert_allclose(shadow, -mrp / (mrp @ mrp), atol=ULPS)  # Schaub and Junkins, eq. (3.142)
    assert_allclose(rotations.matrix_from_mrp(shadow), rotations.matrix_from_mrp(mrp), atol=ULPS)


def test_composition_multiplies_matrices():
    for first, second in zip(sample(), sample()[::-1], strict=True):
        both = rotations.compose_quaternions(second.as_quat(), first.as_quat())
        matrix = rotations.matrix_from_mrp(rotations.mrp_from_quaternion(both))
        assert_allclose(matrix, attitude(second) @ attitude(first), atol=ULPS)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.99e-4, 1.01e-4, 1e-3, 1.0, 3.0, 6.0])
def test_quaternion_of_rotation_vector(angle):
    vector = angle * np.array([2.0, -3.0, 6.0]) / 7.0
    found = np.array(rotations.quaternion_from_rotation_vector(vector))
    expected = Rotation.from_rotvec(vector).as_quat()
    expected *= np.sign(found[3]) * np.sign(expected[3])
    assert_allclose(
        found, expected, rtol=1e-13, atol=1e-300
    )  # relative, on both sides of the change of formula at 1e-4


def test_turning_further_in_body_axes():
    turn = np.array([0.4, -0.2, 0.9])
    for one in sample():
        mrp = np.array(rotations.rotate_mrp(one.as_mrp(), turn))
        assert np.linalg.norm(mrp) <= 1.0 + ULPS
        assert_allclose(rotations.matrix_from_mrp(mrp), attitude(Rotation.from_rotvec(turn)) @ attitude(one), atol=ULPS)


def test_rate_is_the_derivative_of_turning():
    rate, h = np.array([0.3, -0.5, 0.2]), 1e-4
    for one in sample():
        mrp = 0.95 * one.as_mrp()  # clear of the switch at norm 1
        ahead, behind = (np.array(rotations.rotate_mrp(mrp, s * h * rate)) for s in (1.0, -1.0))
        # central difference: h^2 times the third derivative, 1e-8 times 0.2 rad/s cubed; rounding 1e-16 / 1e-4
        square = mrp @ mrp  # dp/dt of an MRP, PHYSICS section 2
        change = 0.25 * ((1.0 - square) * rate + 2.0 * np.cross(mrp, rate) + 2.0 * mrp * (mrp @ rate))
        assert_allclose(change, (ahead - behind) / (2.0 * h), atol=1e-9)


def test_error_angle():
    first, second = sample(), sample()[::-1]
    angle = rotations.error_angle(first.as_mrp(), second.as_mrp())
    # near half a turn the arc sine has an infinite slope: the root of the rounding is lost there
    assert_allclose(angle, (second.inv() * first).magnitude(), atol=1e-7)


def test_error_angle_keeps_small_angles():
    one = sample()
    tiny = 1e-10 * np.array([2.0, -3.0, 6.0]) / 7.0
    other = np.array([rotations.rotate_mrp(mrp, tiny) for mrp in one.as_mrp()])
    # the difference of two MRPs of order one, each rounded at 1e-16: 1e-16 / 1e-10, times four
    assert_allclose(rotations.error_angle(other, one.as_mrp()), 1e-10, rtol=1e-5)


def test_error_angle_through_the_shadow_set():
    mrp = np.array([[0.5, 0.6, 0.6]])
    shadow = -mrp / np.sum(mrp**2)
    assert_allclose(rotations.error_angle(mrp, shadow), 0.0, atol=1e-14)  # rounding


def test_skew_is_the_cross_product():
    a, b = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.7, -1.1])
    assert_allclose(rotations.skew(a) @ b, np.cross(a, b), rtol=1e-15)  # the same products
