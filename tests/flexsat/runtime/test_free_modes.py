"""The free structure's modes against scipy's exponential of the whole matrix, and where no two coordinates exist."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from flexsat.design.chain import plant_matrices
from flexsat.runtime import bearing_friction
from flexsat.runtime import plant as stepper
from flexsat.runtime.free_modes import ClampedModes, FreeModes, vibration
from flexsat.spacecraft.assembly import build_spacecraft

MODES = 60


def clamped_matrix(mass, stiffness, damping):
    """Return the matrix of (eta, eta') under no forces, with the momentum of the whole at zero."""
    m = len(stiffness)
    effective = mass[6:, 6:] - mass[6:, :6] @ np.linalg.solve(mass[:6, :6], mass[:6, 6:])
    return np.block(
        [
            [np.zeros((m, m)), np.eye(m)],
            [-np.linalg.solve(effective, np.diag(stiffness)), -np.linalg.solve(effective, np.diag(damping))],
        ]
    )


@pytest.mark.parametrize("damping_factor", [0.0, 1.0, 100.0, 400.0])
def test_transition_is_the_exponential(distributed, damping_factor):
    """Undamped, as designed, and with some modes overdamped, whose eigenvalues are real."""
    craft = distributed.spacecraft
    stiffness, damping = craft.frequency**2, damping_factor * craft.damping
    free = vibration(craft.mass_matrix, stiffness, damping)
    assert isinstance(free, FreeModes)
    assert np.all(free.oscillates) == (damping_factor < 100.0)
    matrix, scale = clamped_matrix(craft.mass_matrix, stiffness, damping), np.tile(craft.frequency, 2)
    scale[len(stiffness) :] = 1.0  # (omega eta, eta'), which are of one size
    to_motion = np.vstack([free.displacement, free.velocity])
    for time in (5e-4, 0.01, 1.0):
        whole, held = free.transition(time)
        found = to_motion @ whole.times(free.of_structure)
        assert_allclose(scale[:, None] * found / scale, scale[:, None] * expm(matrix * time) / scale, atol=1e-12)
        integral = to_motion @ held.times(free.of_structure)
        # A times the integral is the exponential less one
        exact = np.linalg.solve(matrix, expm(matrix * time) - np.eye(len(matrix)))
        assert_allclose(scale[:, None] * integral / scale, scale[:, None] * exact / scale, atol=1e-12)
        assert_allclose(whole.after(to_motion), to_motion @ whole.times(np.eye(len(scale))), atol=1e-14)


def test_a_mode_at_its_critical_damping_takes_the_coordinates_that_couple():
    """Two equal eigenvalues, one eigenvector: eta = t exp(-2 t) after an impulse."""
    clamped = vibration(np.eye(7), np.array([4.0]), np.array([4.0]))
    assert isinstance(clamped, ClampedModes)
    assert isinstance(vibration(np.eye(7), np.array([4.0]), np.array([4.0 - 1e-6])), FreeModes)
    whole, _ = clamped.transition(0.7)
    motion = clamped.displacement @ whole.times(clamped.of_structure @ np.array([[0.0], [1.0]]))
    assert_allclose(motion, [[0.7 * np.exp(-1.4)]], rtol=1e-14)


def test_coordinates_that_couple_step_as_those_that_do_not(design, quiet_run):
    """Both forms of one plant under random loads, one wheel braked."""
    rng = np.random.default_rng(10)
    m, n = design.plant.modes, design.plant.wheels
    parameters = quiet_run(
        design.plant,
        rate=np.array([0.02, -0.03, 0.01]),
        modal_velocity=rng.standard_normal(m),
        wheel_speed=rng.uniform(20.0, 40.0, n),
    )
    ends = []
    for fixed_order in (False, True):
        plant = stepper.at_step(stepper.prepare_motion(design.plant, parameters, fixed_order=fixed_order), 1e-3)
        assert len(plant.coupled) == (2 * m if fixed_order else 0)
        state, brake = stepper.init(plant), bearing_friction.prepare(plant, 30.0 * np.eye(n)[1])
        draw = np.random.default_rng(11)
        for _ in range(300):
            outputs = stepper.step(plant, state, draw.standard_normal(plant.input_count), brake)
        ends.append(np.concatenate([stepper.structure_motion(plant, state), outputs.flat]))
    assert_allclose(ends[1], ends[0], rtol=1e-9, atol=1e-11 * np.abs(ends[0]).max())


def test_a_step_of_more_modes_is_second_order_too(quiet_run, distributed):
    """All that acts on 60 modes, one step of 1 ms in two and in four: errors in eta' fall by four."""
    config = replace(distributed.config, modes=replace(distributed.config.modes, plant=MODES))
    matrices = plant_matrices(build_spacecraft(config), distributed.plant.nominal_speed, 1e-3)
    rng = np.random.default_rng(9)
    parameters = quiet_run(
        matrices,
        rate=np.array([0.08, -0.05, 0.06]),
        velocity=np.array([0.3, -0.2, 0.1]),
        modal_displacement=rng.standard_normal(MODES) / matrices.frequency,
        modal_velocity=rng.standard_normal(MODES),
        wheel_speed=rng.uniform(-80.0, 80.0, 33),
    )
    inputs = rng.standard_normal(33 + 66 + 6)
    ends = []
    for step in (0.004, 0.002, 0.001, 0.0005):
        plant = stepper.prepare(matrices, parameters, step)
        state = stepper.init(plant)
        for _ in range(round(0.2 / step)):
            stepper.step(plant, state, inputs)
        ends.append(stepper.structure_motion(plant, state))
    change = [np.linalg.norm(after - before) for before, after in pairwise(ends)]
    assert_allclose([change[0] / change[1], change[1] / change[2]], 4.0, rtol=0.1)


def test_coordinates_of_another_machine_are_replaced_by_the_saved_motion(distributed, quiet_run):
    """Bits stay where they mean the saved motion; others are computed anew from it."""
    rate = np.array([1e-3, -2e-3, 3e-3])
    flexing = np.linspace(-1.0, 1.0, distributed.plant.modes)
    plant = stepper.prepare(distributed.plant, quiet_run(distributed.plant, rate=rate, modal_velocity=flexing), 1e-3)
    state = stepper.init(plant)
    for _ in range(20):
        stepper.step(plant, state, np.ones(plant.input_count))
    saved, motion = state.vector.copy(), stepper.structure_motion(plant, state)
    stepper.agree(plant, state, motion)
    assert np.array_equal(state.vector, saved)
    state.work.z[:] = state.work.z[::-1].copy()  # as if the coordinates of each mode had been found in another order
    stepper.agree(plant, state, motion)
    assert_allclose(state.vector, saved, rtol=1e-9, atol=1e-12 * np.abs(saved).max())
    assert_allclose(stepper.structure_motion(plant, state), motion, rtol=1e-12)
    with pytest.raises(ValueError, match=r"structure is \(3,\) in the saved state, and \(56,\) in this"):
        stepper.agree(plant, state, np.zeros(3))
