"""The native plant by itself: momentum, energy, and the order of its steps."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import plant as interface
from fmus.native.twin import Twin


@pytest.fixture(scope="module")
def passive(plant_library, plants):
    """Return a function that runs without inputs for 1 s: telemetry at each 20 ms, (momentum, energy), and outputs."""
    random = np.random.default_rng(7)
    matrices = plants["corrected"]
    m, n = matrices.modes, matrices.wheels
    displacement, velocity = random.standard_normal(m) / matrices.frequency, random.standard_normal(m)
    speed = random.uniform(-40.0, 40.0, n)

    def run(amplitude, step, **values):
        drift = -matrices.mass_matrix[:3, 6:] @ velocity / matrices.mass_matrix[0, 0]
        given = {
            "initial__rate": amplitude * np.array([0.02, -0.03, 0.01]),
            "initial__velocity": amplitude * drift,
            "initial__modal__displacement": amplitude * displacement,
            "initial__modal__velocity": amplitude * velocity,
            "initial__wheel__speed_offset": speed - matrices.nominal_speed,
        }
        native = Twin(plant_library, interface.ports(matrices), **(given | values))
        native.start()
        momentum, energy = [], []
        for k in range(round(1.0 / step)):
            if k % round(0.02 / step) == 0:
                native.evaluate()
                momentum.append(native.view("angular_momentum").copy())
                energy.append(native.view("energy")[0])
            native.advance(k * step, step)
        native.evaluate()
        return np.array(momentum), np.array(energy), native.arrays["real"].copy()

    return run


def test_angular_momentum(passive, plants):
    """With wheels on the bus it is kept but for the integrator's error, of order 2; with wheels on the structure to
    second order in its motion: a quarter of the drift for half of the motion (PHYSICS section 2).
    """
    on_bus = plants["corrected"].mounts == 1
    runs = ((1.0, 0.004), (1.0, 0.002)) if on_bus else ((0.2, 0.0005), (0.1, 0.0005))
    drift = []
    for amplitude, step in runs:
        momentum, _, _ = passive(amplitude, step, modes=0)
        drift.append(np.linalg.norm(momentum - momentum[0], axis=1).max())
    assert_allclose(drift[0] / drift[1], 4.0, rtol=0.1)  # the third order is the rest
    assert drift[1] < 1e-3 * np.linalg.norm(momentum[0])


def test_energy(passive, plants):
    """Without damping it is kept to the integrator's order; with damping it decays."""
    undamped = -np.ones(plants["corrected"].modes)
    drift = []
    for step in (0.004, 0.002):
        _, energy, _ = passive(1.0, step, dispersion__damping=undamped)
        drift.append(np.abs(energy - energy[0]).max())
    assert drift[0] / drift[1] > 3.6  # order 2 or better
    _, energy, _ = passive(1.0, 0.002)
    assert np.all(np.diff(energy) < 0.0)


def test_steps_are_of_second_order(passive):
    ends = [passive(1.0, step)[2] for step in (0.004, 0.002, 0.001)]
    errors = [np.abs(end - ends[2]).max() for end in ends[:2]]
    # errors h^2 against that of a quarter of the smaller: (16 - 1)/(4 - 1) = 5
    assert_allclose(errors[0] / errors[1], 5.0, rtol=0.1)
