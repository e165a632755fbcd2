"""Motors of wheels: torque that falls with speed, speed limits, steps of the command, unequal limits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.runtime import motors
from flexsat.runtime import plant as stepper


def test_a_wheel_nears_its_speed_limit_in_an_exponential(centralised, quiet_run, rigid):
    """Above the speed of full torque, T (W_max - W)/(W_max - W_full): its gap shrinks at one rate."""
    matrices, step, torque, most, full = rigid(centralised), 1e-3, 5.0, 40.0, 39.0
    first = np.eye(6)[0]
    parameters = quiet_run(
        matrices, torque_limit=3.0, wheel_speed=39.5 * first, speed_limit=most * first, full_torque_speed=full * first
    )
    plant = stepper.prepare(matrices, parameters, step)
    state, commanded = stepper.init(plant), np.zeros(plant.input_count)
    commanded[0] = torque
    rate = 3.0 / (most - full) * (1.0 / matrices.wheel_inertia[0] + 1.0 / centralised.spacecraft.inertia[0, 0])
    gaps = [most - stepper.step(plant, state, commanded).wheel_speed[0] for _ in range(3000)]
    # the torque is held over each step: each shortens the gap by the same share
    assert_allclose(gaps, 0.5 * (1.0 - rate * step) ** np.arange(1, 3001), rtol=1e-9)
    commanded[0] = -torque  # braking has all of it
    slower = most - stepper.step(plant, state, commanded).wheel_speed[0] - gaps[-1]
    assert_allclose(slower, 3.0 * step * rate / 3.0, rtol=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_without_a_fall_the_limit_is_met_in_one_step_and_kept(centralised, quiet_run, rigid, sense):
    matrices = rigid(centralised)
    parameters = quiet_run(matrices, torque_limit=5.0, wheel_speed=np.full(6, sense * 39.9999), speed_limit=40.0)
    plant = stepper.prepare(matrices, parameters, 1e-3)
    state, commanded = stepper.init(plant), np.zeros(plant.input_count)
    commanded[:6] = sense * 4.0
    for _ in range(50):
        speed = sense * stepper.step(plant, state, commanded).wheel_speed
    # opposite wheels turn the body nowhere: the rotors alone are sped up
    assert_allclose(speed, 40.0, rtol=1e-12)
    commanded[:6] = -sense * 4.0
    assert np.all(sense * stepper.step(plant, state, commanded).wheel_speed < 40.0 - 3.9e-3 / matrices.wheel_inertia)


def test_commands_are_rounded_to_steps_then_limited(centralised, quiet_run):
    given = quiet_run(centralised.plant, torque_step=np.array([0.1, 0.1, 0.1, 0.0, 0.3, 0.1]))
    prepared = motors.prepare_motors(given, np.full(6, 1.0), centralised.plant.wheel_inertia, 1e-3)
    torque = np.array([0.169, -0.131, 0.25, 0.123, 0.46, 0.0])
    motors.quantise(prepared, torque)
    assert_allclose(torque, [0.2, -0.1, 0.2, 0.123, 0.6, 0.0], rtol=1e-15)


def test_each_motor_has_its_own_limit(centralised, quiet_run):
    """Torques reach the rotors as limited: a failed one gets none."""
    factor = np.array([1.0, 0.5, 0.0, 1.0, 0.25, 1.0])
    given = quiet_run(centralised.plant, torque_limit=0.4, torque_factor=factor)
    plant = stepper.prepare(centralised.plant, given, 1e-3)
    state, commanded = stepper.init(plant), np.zeros(plant.input_count)
    commanded[:6] = 7.0
    before = state.momentum.copy()
    stepper.step(plant, state, commanded)
    assert_allclose(state.momentum - before, 0.4e-3 * factor, rtol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"torque_factor": np.array([1.0, -1.0])}, r"wheel.torque_limit_factor\[2\] must be >= 0, got -1.0"),
        ({"torque_step": np.nan}, r"wheel.torque_step\[1\] must be >= 0, got nan"),
        ({"full_torque_speed": 3.0}, r"wheel.full_torque_speed\[1\] must be at most wheel.speed_limit\[1\] = 0 rad/s"),
    ],
)
def test_what_no_motor_has_is_refused(centralised, quiet_run, changes, message):
    with pytest.raises(ValueError, match=message):
        quiet_run(centralised.plant, **changes)
