"""Directional derivatives of the native plant: its accelerations with respect to its inputs, with the state held."""

import ctypes

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fmus.native.twin import Twin

FOLLOWS = "accelerometer_site.acceleration"
# Differences of accelerations of 1e-2 m/s2 over steps of 1 in inputs: what is linear errs by rounding alone.
ROUNDING = 1e-12


class Differentiated:
    """A native plant in motion, with its derivatives from C and from differences of outputs that follow inputs."""

    def __init__(self, pair, **values):
        self.random = np.random.default_rng(8)
        self.pair = pair(modes=30, **values)
        self.pair.run(20, self.random)
        self.twin: Twin = self.pair.native
        self.inputs = self.pair.inputs
        self.places = self.twin.table.span(FOLLOWS)

    def exact(self, seed):
        """Return the derivatives of all reals in a direction of the inputs."""
        given, change = np.zeros_like(self.twin.arrays["real"]), np.zeros_like(self.twin.arrays["real"])
        given[self.twin.table.run("input")] = seed
        arrays = (ctypes.c_void_p(array.ctypes.data) for array in (given, change))
        component = ctypes.byref(self.twin.component)
        assert self.twin._library.component_differentiate(component, *arrays) == 0
        return change

    def difference(self, seed, step):
        """Return the quotient of differences of the accelerations, on the side that the direction points to."""
        present = self.inputs.copy()
        found = []
        for inputs in (present, present + step * seed):
            self.inputs[:] = inputs
            self.twin.follow_inputs()
            found.append(self.twin.view(FOLLOWS).copy())
        self.inputs[:] = present
        return (found[1] - found[0]) / step

    def check(self, seed, step=1.0):
        """Compare both, and return the derivative."""
        change = self.exact(seed)
        found = change[self.places]
        others = np.delete(change, np.r_[self.places])
        assert not others.any()
        assert_allclose(found, self.difference(seed, step), rtol=0.0, atol=ROUNDING / step)
        return found


def test_each_input_and_any_direction(pair, plants):
    plant = Differentiated(pair)
    limit = plant.pair.matrices.torque_limit
    plant.inputs[:] = 0.1 * limit * plant.random.uniform(-1.0, 1.0, len(plant.inputs))
    moving = 0
    for seed in 0.5 * limit * np.eye(len(plant.inputs)):
        moving += plant.check(seed).any()
    # what only turns the spacecraft about z moves no accelerometer
    about_z = np.count_nonzero(plants["corrected"].wheel_axis[:, 2]) + plants["corrected"].mounts + 1
    assert moving == len(plant.inputs) - about_z
    seeds = 0.5 * limit * plant.random.uniform(-1.0, 1.0, (2, len(plant.inputs)))
    one, two = map(plant.check, seeds)
    assert_allclose(plant.check(seeds.sum(axis=0)), one + two, rtol=0.0, atol=ROUNDING)


def test_torques_at_their_limit(pair):
    """Beyond the limit nothing changes; at it what the direction points to counts."""
    plant = Differentiated(pair)
    limit = plant.pair.matrices.torque_limit
    torque = plant.inputs[: plant.pair.matrices.wheels]
    seed = np.zeros(len(plant.inputs))
    seed[0] = 0.1 * limit
    for value, sign, moves in ((1.5, 1, False), (-1.5, 1, False), (1, 1, False), (1, -1, True), (-1, 1, True),
                               (-1, -1, False)):  # fmt: skip
        torque[0] = value * limit
        assert plant.check(sign * seed).any() == moves


@pytest.mark.parametrize(("friction", "held"), [(1e3, True), (1e-4, False)])
def test_wheels_with_friction(pair, plants, friction, held):
    """A wheel that is held passes its torque on to its mount; one that slides, too, as friction stays the same."""
    at_rest = -plants["corrected"].nominal_speed if held else 0.0
    limits = np.zeros(plants["corrected"].wheels)
    limits[::2] = friction
    plant = Differentiated(pair, wheel__friction_torque=limits, initial__wheel__speed_offset=at_rest)
    speeds = plant.twin.view("wheel.speed")[::2]
    assert (np.abs(speeds).max() < 1e-9) == held
    free = Differentiated(pair)
    plant.inputs[:] *= 0.1  # below the limit
    free.inputs[:] = plant.inputs
    for _ in range(3):
        seed = 1e-3 * plant.random.uniform(-1.0, 1.0, len(plant.inputs))
        found = plant.check(seed)
        apart = np.abs(found - free.exact(seed)[free.places]).max() / np.abs(found).max()
        assert (apart > 1e-3) if held else (apart < 1e-12)


def test_a_derivative_changes_nothing(pair):
    plant = Differentiated(pair, wheel__friction_torque=0.05)
    before, values = plant.twin.save(), plant.twin.arrays["real"].copy()
    plant.exact(np.ones(len(plant.inputs)))

    assert plant.twin.save()[0] == before[0]
    np.testing.assert_array_equal(plant.twin.arrays["real"], values)
