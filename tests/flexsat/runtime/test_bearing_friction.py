"""A wheel that seizes: closed forms for a rigid body, invariants for the flexible one."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.runtime import bearing_friction
from flexsat.runtime import plant as stepper


def friction(plant, size, *wheels):
    limits = np.zeros(plant.wheels)
    limits[list(wheels)] = size
    return bearing_friction.prepare(plant, limits)


def test_a_wheel_brakes_at_the_rate_of_its_friction_and_then_turns_with_the_body(centralised, quiet_run, rigid):
    """Rigid body at rest, one wheel at 40 rad/s: rotor and body end at one rate, which keeps their momentum."""
    matrices, size, step = rigid(centralised), 50.0, 1e-3
    inertia, rotor = centralised.spacecraft.inertia[0, 0], matrices.wheel_inertia[0]
    speed = np.zeros(6)
    speed[0] = 40.0
    plant = stepper.prepare(matrices, quiet_run(matrices, wheel_speed=speed), step)
    state, nothing = stepper.init(plant), np.zeros(plant.input_count)
    seized = friction(plant, size, 0)
    braking = size * (1.0 / rotor + 1.0 / inertia)  # of the relative speed [rad/s2]
    seen = []
    for k in range(1, 4001):
        outputs = stepper.step(plant, state, nothing, seized)
        seen.append(outputs.wheel_speed[0])
        if k == 3000:
            assert_allclose(outputs.wheel_speed[0], 40.0 - braking * 3.0, rtol=1e-11)  # 3000 roundings
    stop = 40.0 / braking
    assert 3.6 < stop < 3.8
    assert np.all(np.diff(seen[: int(stop / step)]) < 0.0)
    assert np.abs(seen[int(stop / step) + 1 :]).max() < 1e-12  # rounding of 40 rad/s; it does not swing through zero
    assert_allclose(outputs.rate, [rotor * 40.0 / (inertia + rotor), 0.0, 0.0], rtol=1e-11, atol=1e-18)


def test_friction_holds_a_wheel_against_its_motor_and_the_motor_overcomes_less_friction(centralised, quiet_run, rigid):
    matrices = rigid(centralised)
    plant = stepper.prepare(matrices, quiet_run(matrices), 1e-3)
    commanded = np.zeros(plant.input_count)
    commanded[1] = 2.0
    for size, torque in ((2.5, 0.0), (1.5, 0.5)):
        state = stepper.init(plant)
        for _ in range(1000):
            outputs = stepper.step(plant, state, commanded, friction(plant, size, 1))
        exact = torque * (1.0 / matrices.wheel_inertia[0] + 1.0 / centralised.spacecraft.inertia[1, 1])
        assert_allclose(outputs.wheel_speed[1], exact, rtol=1e-11, atol=1e-15)


@pytest.mark.parametrize("configuration", ["centralised", "distributed"])
def test_angular_momentum_is_kept_and_energy_lost_while_wheels_seize(request, configuration, quiet_run):
    """The flexible spacecraft turning in all axes, two wheels braked hard, then held."""
    design = request.getfixturevalue(configuration)
    n = design.plant.wheels
    parameters = quiet_run(
        design.plant,
        rate=np.array([2e-3, -3e-3, 1e-3]),
        wheel_speed=np.random.default_rng(3).uniform(20.0, 40.0, n),
    )
    seized, drift = (0, n - 1), []
    for step in (0.004, 0.002):
        plant = stepper.prepare(design.plant, parameters, step)
        state, nothing = stepper.init(plant), np.zeros(plant.input_count)
        brakes = friction(plant, 40.0 * design.plant.wheel_inertia[0] / 0.5, *seized)  # stopped within 0.5 s
        start = stepper.telemetry(plant, state)
        momenta, speeds = [], []
        for _ in range(round(1.0 / step)):
            outputs = stepper.step(plant, state, nothing, brakes)
            momenta.append(stepper.telemetry(plant, state).angular_momentum)
            speeds.append(outputs.wheel_speed[list(seized)].copy())
        exchanged = np.linalg.norm(design.plant.wheel_inertia[0] * parameters.wheel_speed[list(seized)])
        drift.append(np.linalg.norm(momenta - start.angular_momentum, axis=1).max() / exchanged)
        held = np.abs(speeds[len(speeds) * 6 // 10 :])
        assert held.max() < 1e-7 * 40.0  # gyroscopic terms of the step before stand for those of this one
        assert stepper.telemetry(plant, state).energy < start.energy
    if configuration == "centralised":  # the bus does not tilt: the integrator's error, of order 2
        assert_allclose(drift[0] / drift[1], 4.0, rtol=0.1)
        assert drift[1] < 1e-6
    else:  # the momentum that is computed is of second order in the tilt of 33 wheels, shaken by the brakes
        assert drift[1] < 1e-4
    assert np.abs(outputs.rate - parameters.rate).max() > 1e-4  # the body took what the wheels lost


def test_without_friction_no_bit_changes(design, quiet_run):
    plant = stepper.prepare(design.plant, quiet_run(design.plant, rate=np.array([1e-3, 2e-3, 3e-3])), 1e-3)
    torque = np.zeros(plant.input_count)
    torque[: plant.wheels] = 0.1
    ends = []
    for brakes in (None, friction(plant, 0.0, 0)):
        state = stepper.init(plant)
        for _ in range(20):
            outputs = stepper.step(plant, state, torque, brakes)
        ends.append(outputs.flat.copy())
    assert np.array_equal(*ends)


def test_wheels_on_one_axis_are_held_together_within_a_step(centralised, quiet_run, rigid):
    """Opposite wheels on a body that is lighter than they are: each brake turns the mount of the other."""
    matrices = rigid(centralised)
    mass = matrices.mass_matrix.copy()
    mass[3, 3] = 0.5 * matrices.wheel_inertia[0]
    speed = np.array([40.0, 0.0, 0.0, -25.0, 0.0, 0.0])
    matrices = replace(matrices, mass_matrix=mass)
    plant = stepper.prepare(matrices, quiet_run(matrices, wheel_speed=speed), 1e-3)
    outputs = stepper.step(plant, stepper.init(plant), np.zeros(plant.input_count), friction(plant, 1e9, 0, 3))
    assert np.abs(outputs.wheel_speed).max() < 1e-12 * 40.0  # rounding
    turned = matrices.wheel_inertia[0] * (speed[0] - speed[3]) / (mass[3, 3] + 2.0 * matrices.wheel_inertia[0])
    assert_allclose(outputs.rate, [turned, 0.0, 0.0], rtol=1e-12, atol=1e-12)  # momentum is kept
