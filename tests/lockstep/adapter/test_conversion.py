"""The arithmetic of an adapter: attitudes against the spacecraft's own module, and both directions to rounding."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.runtime import rotations
from lockstep.adapter.conversion import convert, flag
from lockstep.adapter.rotation import mrp_from_quaternion, quaternion_from_mrp, quaternion_matrix
from lockstep.system.adapter_file import AdapterEntry

FEW_ULP = 1e-15  # rounding of a handful of products of numbers up to 1
ATTITUDES = [(0.1, -0.2, 0.3), (1e-7, 2e-8, -3e-7), (0.9, 0.1, -0.2), (0.0, 0.0, 0.0)]
QUARTER = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def entry(**changes):
    return AdapterEntry(location="vendor.toml: input 1", direction="input", ports=("a",), variables=("b",), **changes)


def conversion(ports=3, variables=3, gain=1.0, bias=0.0, **changes):
    return convert(entry(**changes), ports, variables, [gain] * variables, [bias] * variables)


@pytest.mark.parametrize("mrp", ATTITUDES)
def test_formulas_are_those_of_the_spacecraft(mrp):
    q = np.array(rotations.quaternion_from_mrp(mrp))

    assert_allclose(quaternion_from_mrp(np.array(mrp)), q, rtol=0, atol=FEW_ULP)
    assert_allclose(mrp_from_quaternion(q), rotations.mrp_from_quaternion(q), rtol=0, atol=FEW_ULP)
    assert_allclose(mrp_from_quaternion(-q), rotations.mrp_from_quaternion(-q), rtol=0, atol=FEW_ULP)


@pytest.mark.parametrize("mrp", ATTITUDES)
@pytest.mark.parametrize("vector", [(0.1, 0.2, 0.3), (3.1, 0.0, 0.1), (0.1, -3.0, 0.5), (0.2, 0.3, 3.0)])
def test_frames_compose_as_the_spacecraft_composes_quaternions(mrp, vector):
    """The rotation vectors make each component of the frame's quaternion the largest in turn."""
    q = np.array(rotations.quaternion_from_mrp(mrp))
    frame = np.array(rotations.quaternion_from_rotation_vector(vector))
    matrix = rotations.matrix_from_mrp(rotations.mrp_from_quaternion(frame))
    plain = {"body_frame": None, "inertial_frame": None, "inverse": False, "scalar_first": False}
    body = quaternion_matrix(**{**plain, "body_frame": matrix}) @ q
    inertial = quaternion_matrix(**{**plain, "inertial_frame": matrix}) @ q
    back = np.array([-1.0, -1.0, -1.0, 1.0]) * frame

    for found, expected in (
        (body, rotations.compose_quaternions(frame, q)),
        (inertial, rotations.compose_quaternions(q, back)),
    ):
        assert_allclose(found * np.sign(found @ expected), expected, rtol=0, atol=8 * FEW_ULP)
    assert_allclose(quaternion_matrix(**plain), np.eye(4), rtol=0, atol=0)


def test_quaternion_without_an_attitude_is_no_rotation():
    assert mrp_from_quaternion(np.zeros(4)).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("there", ["mrp", "quaternion"])
def test_what_is_not_a_number_stays_so(there):
    both = conversion(variables=4 if there == "quaternion" else 3, attitude=there)

    assert np.all(np.isnan(both.to_fmu(np.array([np.nan, 0.0, 0.0]))))
    assert np.all(np.isnan(both.to_port(np.array([0.0, np.nan, 0.0, 1.0][: 4 if there == "quaternion" else 3]))))


def test_small_rotation_has_the_components_of_its_convention():
    half = 5e-4
    mrp = np.array([np.tan(half / 2.0), 0.0, 0.0])  # 1 mrad about x, body from inertial
    there = conversion(variables=4, attitude="quaternion", scalar="first", rotation="inertial-from-body").to_fmu(mrp)

    assert_allclose(there, [np.cos(half), -np.sin(half), 0.0, 0.0], rtol=0, atol=FEW_ULP)


@pytest.mark.parametrize("mrp", ATTITUDES)
@pytest.mark.parametrize("rotation", ["body-from-inertial", "inertial-from-body"])
def test_frames_rotate_the_matrix_from_both_sides(mrp, rotation):
    inertial = rotations.matrix_from_mrp((0.2, 0.1, -0.3))
    there = conversion(
        attitude="mrp", rotation=rotation, body_frame=QUARTER, inertial_frame=tuple(map(tuple, inertial))
    ).to_fmu(np.array(mrp))
    expected = np.array(QUARTER) @ rotations.matrix_from_mrp(mrp) @ inertial.T
    if rotation == "inertial-from-body":
        expected = expected.T

    assert_allclose(rotations.matrix_from_mrp(there), expected, rtol=0, atol=8 * FEW_ULP)


@pytest.mark.parametrize("mrp", ATTITUDES)
@pytest.mark.parametrize("port", ["mrp", "quaternion"])
@pytest.mark.parametrize("attitude", ["mrp", "quaternion"])
@pytest.mark.parametrize("scalar", ["first", "last"])
@pytest.mark.parametrize("rotation", ["body-from-inertial", "inertial-from-body"])
def test_attitudes_are_converted_exactly_back(mrp, port, attitude, scalar, rotation):
    value = np.array(mrp if port == "mrp" else rotations.quaternion_from_mrp(mrp))
    both = conversion(
        len(value), 4 if attitude == "quaternion" else 3, attitude=attitude, scalar=scalar, rotation=rotation,
        body_frame=QUARTER, inertial_frame=((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    )  # fmt: skip
    back = both.to_port(both.to_fmu(value))
    if port == "quaternion":
        back = back * np.sign(back @ value)  # both signs are the same rotation

    assert_allclose(back, value, rtol=0, atol=8 * FEW_ULP)


def test_steps_have_the_documented_order():
    both = conversion(
        gain=10.0, bias=1.0, scale=(2.0, 3.0, 4.0), offset=(0.5,), sign=(1.0, -1.0, 1.0), order=(3, 1, 2), frame=QUARTER
    )  # fmt: skip
    # frame: (2, -1, 3); order: (3, 2, -1); unit: (31, 21, -9); sign and scale: (62, -63, -36)
    assert_allclose(both.to_fmu(np.array([1.0, 2.0, 3.0])), [62.5, -62.5, -35.5], rtol=FEW_ULP)
    assert_allclose(both.to_port(np.array([62.5, -62.5, -35.5])), [1.0, 2.0, 3.0], rtol=4 * FEW_ULP)


def test_flags_have_the_given_numbers():
    numbers = flag(entry(true=3.0, false=-1.0))

    assert numbers.to_fmu(np.array([1.0, 0.0])).tolist() == [3.0, -1.0]
    assert numbers.to_port(np.array([3.0, -1.0, 4.0])).tolist() == [1.0, 0.0, 1.0]
