"""A plant whose appendages turn in a run: momentum is kept, and a free body turns as its new inertia says."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import plant as interface
from flexsat.ports.table import PortTable
from flexsat.runtime import plant
from flexsat.runtime.turning.angles import at_angles
from flexsat.runtime.turning.state import turned_state

START = np.deg2rad([25.0, -15.0])


@pytest.fixture
def turn(at):
    """Return the plant at the start, its state with everything in motion, and what turns its arrays to angles."""
    matrices, random = at(25.0), np.random.default_rng(4)
    table = PortTable(interface.ports(matrices))
    values = {port.name: np.array(port.starts) if port.size else port.starts[0] for port in table}
    values |= {
        "initial.rate": np.array([2e-3, -1e-3, 3e-3]),
        "initial.modal.displacement": 1e-3 * random.standard_normal(matrices.modes),
        "initial.modal.velocity": 1e-3 * random.standard_normal(matrices.modes),
    }
    parameters = interface.parameters(matrices, values.__getitem__)
    inputs = np.zeros(matrices.wheels + 6 * matrices.mounts + 6)

    def prepared(angles):
        return plant.prepare(at_angles(matrices, np.asarray(angles)), parameters, 1e-3)

    start = prepared(START)
    return start, plant.init(start), prepared, inputs


def momentum(prepared, state):
    return plant.telemetry(prepared, state).angular_momentum


def test_momentum_at_an_angle_of_a_run(turn):
    _, _, prepared, inputs = turn
    there = prepared([1.4, 0.6])
    state = plant.init(there)
    before = momentum(there, state)
    for _ in range(1000):
        plant.step(there, state, inputs)
    assert np.abs(state.outputs.rate - there.motion.parameters.rate).max() > 1e-4  # gyroscopic torques have acted
    # to second order in the tilt of the axes with the structure, 1e-3 (PHYSICS section 2)
    assert_allclose(momentum(there, state), before, rtol=0.0, atol=1e-6 * np.abs(state.momentum).max())


def test_a_turning_array_keeps_momentum(turn):
    here, state, prepared, inputs = turn
    before = momentum(here, state)
    for k in range(20):  # a slow turn, by steps
        there = prepared(START + np.array([0.05, -0.03]) * (k + 1))
        state = turned_state(here, there, state, inputs)
        assert_allclose(momentum(there, state), before, rtol=0.0, atol=1e-13 * np.abs(before).max() * (k + 1))
        here = there
        before = momentum(here, state)


def test_a_turn_there_and_back_is_none(turn):
    here, state, prepared, inputs = turn
    before = plant.structure_motion(here, state)
    there = prepared([2.0, -1.0])
    away = turned_state(here, there, state, inputs)
    assert np.abs(plant.structure_motion(there, away) - before).max() > 1e-3
    back = turned_state(there, here, away, inputs)
    assert_allclose(plant.structure_motion(here, back), before, atol=1e-13)
    assert_allclose(back.speed, state.speed, rtol=1e-12)


def test_the_momenta_of_the_modes_are_kept(turn):
    """What a slow turn keeps is not the modal velocities but their momenta, which count the motion of the body."""
    here, state, prepared, inputs = turn
    m = here.modes
    there = prepared([2.0, -1.0])
    before = here.motion.mass[6:] @ plant.structure_motion(here, state)[m:]
    after = there.motion.mass[6:] @ plant.structure_motion(there, turned_state(here, there, state, inputs))[m:]
    assert_allclose(after, before, rtol=1e-11, atol=1e-14)
