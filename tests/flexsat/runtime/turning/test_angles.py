"""A plant at an angle is the plant that is built with it: mass, couplings, wheels, sensors, jitter."""

from dataclasses import fields

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from flexsat.runtime.loads import prepare_loads
from flexsat.runtime.turning.angles import at_angles, rotation

SAME = 1e-12  # of an array's largest value: products of rotations, and sums of a hundred terms


def test_a_turned_plant_is_the_one_built_with_that_angle(at):
    there, back = at(110.0, 40.0), at(25.0)
    found = at_angles(back, np.deg2rad([110.0, 40.0]))
    for item in fields(found):
        expected = np.asarray(getattr(there, item.name))
        scale = np.abs(expected).max(initial=1e-300)
        assert_allclose(getattr(found, item.name), expected, rtol=0.0, atol=SAME * scale, err_msg=item.name)
    # it matters: mass, couplings, wheel and sensors of the array have moved
    for name in ("mass_matrix", "wrench_influence", "torque_influence", "gyro_axis", "accelerometer_position"):
        assert np.abs(getattr(there, name) - getattr(back, name)).max() > 0.1, name
    assert_array_equal(found.gyro_axis[:2], back.gyro_axis[:2])  # those on the bus have not


def test_its_own_angles_change_nothing(at):
    built = at(25.0)
    assert at_angles(built, built.turn_angle) is built


def test_there_and_back(at):
    built = at(25.0)
    found = at_angles(at_angles(built, np.array([2.0, -3.0])), built.turn_angle)
    for item in fields(found):
        expected = np.asarray(getattr(built, item.name))
        assert_allclose(getattr(found, item.name), expected, rtol=0.0, atol=SAME * np.abs(expected).max(initial=1e-300))


def test_as_many_loads_at_any_angle(at):
    """What a saved state holds has one size, although zeros of the modes' motion come and go as they turn."""
    sizes = {prepare_loads(at(angle)).of_held.shape for angle in (0.0, 25.0, 90.0)}
    assert len(sizes) == 1


def test_jitter_turns_with_its_mount(at):
    """A force across the tip's mount, as its wheel makes it, turns with the array; one on the bus does not."""
    built = at(90.0)
    on_bus, on_tip = prepare_loads(built).of_held[:3, 5:11].reshape(3, 3, 2).transpose(2, 0, 1)  # wheels, then forces
    assert_array_equal(on_bus, np.eye(3))
    assert_allclose(on_tip, rotation(built.turn_axis[0], np.pi / 2), atol=1e-14)


def test_right_angles_are_exact():
    assert_array_equal(rotation(np.array([0.0, 0.0, 1.0]), np.pi / 2), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
