"""The native plant with appendages that turn against the Python stepper: at other angles, and when they change."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexsat.design.chain import plant_matrices
from flexsat.ports import plant as plant_ports
from fmus.native.matrices import compile_with_places, give_matrices
from fmus.native.plant_pair import PlantPair
from fmus.turning_array import spacecraft

SPEED = np.array([40.0, -60.0, 55.0, 30.0, -80.0])  # rad/s
SAME = 1e-11  # as in test_plant.py


@pytest.fixture(scope="module")
def turning(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., PlantPair]:
    """Return a maker of a pair with two arrays that turn."""
    folder: Path = tmp_path_factory.mktemp("turning")
    variants = {"corrected": plant_matrices(spacecraft(folder), SPEED, 1e-3)}
    library = compile_with_places("plant", plant_ports.ports(variants["corrected"]), variants, folder, ["-O0"])
    give_matrices(library, "plant", variants)

    def pair(**values: Any) -> PlantPair:
        moving = {"seed": 3, "initial__rate": [2e-3, -1e-3, 3e-3], "initial__velocity": [0.1, 0.05, -0.02]}
        return PlantPair(library, variants, **(moving | values))

    return pair


def assert_same(both: PlantPair) -> None:
    assert both.differences() == {name: pytest.approx(0.0, abs=SAME) for name in both.differences()}


def test_at_other_angles(turning):
    both = turning(appendage__angle=[2.0, -1.1], modes=7)
    assert_same(both)
    both.run(300, np.random.default_rng(1))
    assert_same(both)


def test_angles_that_change_in_a_run(turning):
    both, random = turning(), np.random.default_rng(2)
    both.run(100, random)
    both.native.view("wheel.friction_torque")[:] = [0.0, 0.01, 0.0, 0.02, 0.03]
    for angles in ([0.5, -0.2], [0.5, 1.0], [np.pi / 2.0, 0.0], np.deg2rad([25.0, -15.0])):
        both.turn(*angles)
        assert_same(both)
        both.run(100, random)
    assert_same(both)
    assert np.abs(both.native.view("modal.displacement")).max() > 1e-4  # it moves


def test_a_state_fits_at_any_angle(turning):
    """A plant of the same parameters takes the state of one that has come to its angle in a run."""
    there, other = turning(), turning(appendage__angle=[1.2, 0.3])
    there.run(50, np.random.default_rng(2))
    there.turn(1.2, 0.3)
    assert there.native.component.state_size == other.native.component.state_size
    assert_array_equal(there.motion.mass, other.motion.mass)


def test_no_angle_changes_the_momentum(turning):
    """The wheel on the array turns with it: what its momentum changes by, the body takes."""
    both = turning()
    both.inputs[:] = 0.0
    for _ in range(20):
        both.advance()
    both.native.evaluate()
    before = both.native.view("angular_momentum").copy()
    both.turn(1.9, 0.4)
    both.native.evaluate()
    assert_allclose(both.native.view("angular_momentum"), before, rtol=1e-12, atol=1e-12 * np.abs(before).max())
