"""The native plant against the Python stepper: outputs, telemetry, step lengths, saved states, messages."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from flexsat.runtime import plant

# Both sum in other orders: 1e-16 a step, times the condition of the free modes, 100, and of what cancels in a site's
# acceleration. The differences seen are 1e-12.
SAME = 1e-11


def motion_of(plants, random):
    """Return values of ports for a run in which every term counts."""
    m, n = plants["corrected"].modes, plants["corrected"].wheels
    return {
        "seed": 5,
        "initial__attitude_deviation": 1e-4,
        "initial__mrp": [0.1, -0.2, 0.05],
        "initial__rate": [1e-3, -2e-3, 5e-4],
        "initial__velocity": [0.1, 0.2, -0.3],
        "initial__modal__displacement": 1e-3 * random.standard_normal(m),
        "initial__modal__velocity": 1e-3 * random.standard_normal(m),
        "initial__wheel__speed_offset": random.uniform(-5.0, 5.0, n),
        "initial__wheel__angle": random.uniform(-1.0, 1.0, n),
        "dispersion__frequency": random.uniform(-0.1, 0.1, m),
        "dispersion__damping": random.uniform(-0.5, 0.5, m),
        "dispersion__inertia": [0.02, 0.03, 0.01],
        "dispersion__participation": random.uniform(-0.1, 0.0, m),
    }


def motors_of(plants, random):
    """Return values of ports for motors of unequal limits: some cannot speed their wheels up, some little, some all."""
    speed = plants["corrected"].nominal_speed
    limit = speed * random.uniform(0.95, 1.3, len(speed))
    limit[::4] = 0.0  # none
    return {
        "wheel__torque_limit_factor": random.uniform(0.2, 1.2, len(speed)),
        "wheel__speed_limit": limit,
        "wheel__full_torque_speed": random.choice([0.0, 0.9, 1.0], len(speed)) * limit,
        "wheel__torque_step": random.choice([0.0, 0.05], len(speed)),
    }


def few_modes(values, count):
    """Return the values with the given number of modes simulated, the others at rest."""
    changed = values | {"modes": count}
    for name in ("initial__modal__displacement", "initial__modal__velocity"):
        changed[name] = np.where(np.arange(len(values[name])) < count, values[name], 0.0)
    return changed


def test_full_plant(pair, plants):
    random = np.random.default_rng(3)
    both = pair(**motion_of(plants, random))
    assert max(both.differences().values()) < SAME
    both.run(2000, random)

    assert both.differences() == {name: pytest.approx(0.0, abs=SAME) for name in both.differences()}
    assert np.abs(both.native.view("rate")).max() > 1e-3  # it moves


@pytest.mark.parametrize("layout", ["centralised"], indirect=True)
def test_motors_of_unequal_limits(pair, plants):
    random = np.random.default_rng(9)
    both = pair(**few_modes(motion_of(plants, random), 20) | motors_of(plants, random))
    both.run(1000, random)
    assert both.differences() == {name: pytest.approx(0.0, abs=SAME) for name in both.differences()}


def test_friction_and_step_lengths(pair, plants):
    """Masters may alternate between step lengths, and change the friction during a run."""
    random = np.random.default_rng(4)
    both = pair(**few_modes(motion_of(plants, random), 30))
    for friction, step in (
        (0.05, 1e-3),
        (0.0, 5e-3),
        (0.3, 2e-3),
        (0.3, 1e-3),
        (0.3, 7e-4),
        (0.02, 1e-2),
        (0.02, 1e-3),
    ):
        limits = friction * random.uniform(0.5, 1.0, both.matrices.wheels)
        limits[::3] = 0.0
        both.native.set("wheel.friction_torque", limits)
        both.change_step(step)
        both.native.tuned()
        both.run(40, random)

        assert max(both.differences().values()) < SAME


def test_wheels_are_held_by_friction(pair, plants):
    """A wheel that starts at rest against its mount stays so, to rounding of its speed in inertial space."""
    at_rest = -plants["corrected"].nominal_speed
    both = pair(wheel__friction_torque=1.0, initial__wheel__speed_offset=at_rest, modes=20)
    both.inputs[-3:] = [5.0, -3.0, 1.0]
    for _ in range(50):
        both.advance()

    assert np.abs(both.native.view("wheel.speed")).max() < 1e-12
    assert np.abs(both.native.view("rate")).max() > 1e-7


@pytest.mark.parametrize(
    "values",
    [
        {"as_published": 1, "initial__random_wheel_phases": 0},
        {"modes": 1, "gyroscopics": 0},
        {"modes": 7, "dispersion__damping": -1.0},  # undamped
        {
            "modes": 12,
            "dispersion__frequency": -0.999,
            "dispersion__damping": 10.0,
        },  # real eigenvalues
    ],
    ids=["published", "one mode", "undamped", "creeping"],
)
def test_parameters(pair, values):
    random = np.random.default_rng(6)
    both = pair(**values, initial__rate=[2e-3, 1e-3, -1e-3])
    both.run(200, random)

    assert max(both.differences().values()) < SAME


def test_critically_damped_modes_keep_their_own_coordinates(pair, plants):
    """Damping of twice the frequency leaves an uncoupled mode one eigenvector; the coupled ones come near to that."""
    matrices = plants["corrected"]
    scale = 11.0 * matrices.damping / (2.0 * matrices.frequency)  # within the ranges: low frequency, high damping
    both = pair(modes=12, dispersion__damping=10.0, dispersion__frequency=scale - 1.0)
    random = np.random.default_rng(7)
    both.run(100, random)
    both.change_step(3e-3)
    both.run(100, random)

    assert max(both.differences().values()) < SAME


def test_outputs_follow_inputs(pair, plants):
    """Accelerations are those with the present inputs; what the next step does is not changed by reading them."""
    random = np.random.default_rng(8)
    both = pair(**few_modes(motion_of(plants, random), 40), wheel__friction_torque=0.05)
    both.run(20, random)
    before = both.native.view("accelerometer_site.acceleration").copy()
    both.excite(random)
    plant.feed_through(both.plant, both.state, both.inputs, both.friction)
    both.native.follow_inputs()
    assert max(both.differences().values()) < SAME
    assert np.abs(both.native.view("accelerometer_site.acceleration") - before).max() > 1e-6
    both.run(20, random)

    assert max(both.differences().values()) < SAME


def test_a_saved_state_continues_bit_for_bit(pair, plants):
    random = np.random.default_rng(9)
    values = few_modes(motion_of(plants, random), 50) | {"wheel__friction_torque": 0.05}
    first, second = pair(**values), pair(**values)
    first.run(30, random)
    first.native.advance(first.time, 4e-3)  # the last length is part of the state: reading accelerations depends on it
    saved = first.native.save()
    inputs = random.standard_normal((20, len(first.inputs)))

    ends = []
    for native in (first.native, second.native):
        native.restore(saved)
        native.follow_inputs()
        for row in inputs:
            native.arrays["real"][native.table.run("input")] = row
            native.advance(0.0, 1e-3)
        native.evaluate()
        ends.append(native.save())
    assert ends[0][0] == ends[1][0]
    assert_array_equal(ends[0][1]["real"], ends[1][1]["real"])


def test_no_memory_is_taken_after_the_start(pair):
    """Step lengths that come later are prepared in memory that was taken at the start."""
    both = pair(modes=30)
    both.native.component.memory.allocate = None  # a call would crash
    for k in range(12):
        both.native.advance(0.0, 1e-3 * (k % 7 + 1))
    both.native.view("wheel.friction_torque")[:] = 0.1
    both.native.tuned()
    both.native.follow_inputs()
    both.native.evaluate()
    both.native.restore(both.native.save())
    assert np.all(np.isfinite(both.native.arrays["real"]))
