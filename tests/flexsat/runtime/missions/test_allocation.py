"""Torque for the wheels that are left, and for couples of thrusters."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import thrusters as interface
from flexsat.runtime.missions import allocation
from flexsat.runtime.missions.thrusters import wrench_of

POSITION, DIRECTION = np.array(interface.POSITIONS), np.array(interface.DIRECTIONS)


def test_the_inverse_gives_the_torques_of_least_squares_of_a_pyramid_without_a_wheel():
    tilt = 0.6
    axis = np.array([[np.cos(a) * np.cos(tilt), np.sin(a) * np.cos(tilt), np.sin(tilt)] for a in (0.3, 1.9, 3.4, 5.0)])
    works = np.array([True, True, False, True])
    inverse = allocation.inverse_of_axes(axis, works)
    assert inverse is not None
    torque = axis[works] @ inverse @ [0.1, -0.2, 0.3]

    assert_allclose(axis[works].T @ torque, [0.1, -0.2, 0.3], rtol=1e-13)
    assert_allclose(torque, np.linalg.pinv(axis[works].T) @ [0.1, -0.2, 0.3], rtol=1e-12)


def test_two_axes_are_too_few():
    axis = np.vstack([np.eye(3), -np.eye(3)])

    assert allocation.inverse_of_axes(axis, np.array([1, 1, 0, 1, 1, 0], np.bool_)) is None
    assert allocation.inverse_of_axes(axis, np.array([1, 1, 0, 0, 0, 1], np.bool_)) is not None


def test_thrusts_give_the_torque_and_no_force():
    shares = allocation.thruster_shares(POSITION, DIRECTION)
    wrench = wrench_of(POSITION, DIRECTION)
    for axis in range(3):
        for sign in (1.0, -1.0):
            thrust = np.maximum(sign * shares[:, axis], 0.0)

            assert np.count_nonzero(thrust) == 2
            assert_allclose(wrench @ thrust, sign * np.eye(6)[3 + axis], atol=1e-15)


def test_thrusters_without_opposite_ones_are_refused():
    direction = DIRECTION.copy()
    direction[1] = -direction[1]  # +x is a force now

    with pytest.raises(ValueError, match="let each thruster have an opposite one"):
        allocation.thruster_shares(POSITION, direction)
    with pytest.raises(ValueError, match="let each thruster have an opposite one"):
        allocation.thruster_shares(POSITION[:4], DIRECTION[:4])
