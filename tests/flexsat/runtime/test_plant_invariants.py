"""The plant: momentum, energy, and what its sensors' sites feel."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from flexsat.runtime import plant as stepper
from flexsat.runtime import rotations


def passive(plant, duration):
    """Return the telemetry at the start and after each step of a run without inputs."""
    state, nothing = stepper.init(plant), np.zeros(plant.input_count)
    seen = [stepper.telemetry(plant, state)]
    for _ in range(round(duration / plant.step_length)):
        stepper.step(plant, state, nothing)
        seen.append(stepper.telemetry(plant, state))
    return seen


def test_angular_momentum_is_kept_to_second_order(distributed, turning):
    """What is not kept is rho w x (N eta x e): half the motion, a quarter of it (PHYSICS section 2)."""
    drift, size = [], []
    for amplitude in (0.2, 0.1, 0.05):
        # the integrator's own error is proportional to the amplitude; .5 ms makes it small compared with the drift
        momentum = np.array(
            [
                t.angular_momentum
                for t in passive(stepper.prepare(distributed.plant, turning(distributed, amplitude), 0.0005), 1.0)
            ]
        )
        drift.append(np.linalg.norm(momentum - momentum[0], axis=1).max())
        size.append(np.linalg.norm(momentum[0]))
    ratio = np.array(drift[:-1]) / drift[1:]
    assert_allclose(ratio, 4.0, rtol=0.05)  # the third order, and the integrator, are the rest
    assert drift[0] < 1e-3 * size[0]


def test_angular_momentum_is_kept_exactly_with_wheels_on_the_bus(centralised, turning):
    """The bus does not tilt: only the integrator errs, by order 2."""
    drift = []
    for step in (0.004, 0.002):
        momentum = np.array(
            [
                t.angular_momentum
                for t in passive(stepper.prepare(centralised.plant, turning(centralised, 1.0), step), 1.0)
            ]
        )
        drift.append(np.linalg.norm(momentum - momentum[0], axis=1).max())
    assert_allclose(drift[0] / drift[1], 4.0, rtol=0.1)  # order 2


def test_energy_without_damping_is_kept_to_the_integrators_order(design, turning):
    drift = []
    for step in (0.004, 0.002):
        energy = np.array(
            [t.energy for t in passive(stepper.prepare(design.plant, turning(design, 1.0, damped=False), step), 1.0)]
        )
        drift.append(np.abs(energy - energy[0]).max())
    assert drift[0] / drift[1] > 3.6  # order 2 or better


def test_energy_decays_in_a_passive_run(design, turning):
    energy = np.array([t.energy for t in passive(stepper.prepare(design.plant, turning(design, 1.0), 0.001), 5.0)])
    change = np.diff(energy)
    # each step may gain what the integrator errs, which is 1e-3 of what damping takes
    assert change.max() < 1e-3 * np.abs(change).max()
    assert energy[-1] < energy[0]


def test_work_of_the_wheel_motors(design, quiet_run, run):
    """Energy gained is torque times the angle that each rotor turns against its mount."""
    rng = np.random.default_rng(8)
    n = design.plant.wheels
    parameters = quiet_run(
        design.plant, wheel_speed=rng.uniform(10.0, 40.0, n), damping_dispersion=np.full(design.plant.modes, -1.0)
    )
    torque = rng.uniform(-1.0, 1.0, n)
    gap = []
    for step in (0.004, 0.002):
        plant = stepper.prepare(design.plant, parameters, step)
        before = stepper.telemetry(plant, stepper.init(plant)).energy
        state, outputs = run(design.spacecraft, plant, [(1.0, (torque, np.zeros((4, n)), np.zeros(3), np.zeros(3)))])
        gained = stepper.telemetry(plant, state).energy - before
        gap.append(abs(gained - torque @ outputs.wheel_angle))
        assert gap[-1] < 1e-5 * abs(gained)
    assert gap[0] / gap[1] > 3.6 or gap[0] < 1e-11 * abs(gained)  # order 2, or nothing but rounding


def test_uniform_motion_changes_nothing(centralised, run, turning):
    """An observer who moves along sees the same rates and modes (Galileo)."""
    seen = []
    for speed in (0.0, 1.0):
        parameters = turning(centralised, 1.0)
        moving = replace(parameters, velocity=parameters.velocity + np.array([speed, 0.0, 0.0]))
        plant = stepper.prepare(centralised.plant, moving, 0.001)
        state, outputs = run(
            centralised.spacecraft, plant, [(1.0, (np.zeros(6), np.zeros((4, 6)), np.zeros(3), np.zeros(3)))]
        )
        seen.append(np.concatenate([outputs.rate, stepper.telemetry(plant, state).modal_displacement]))
    assert_allclose(seen[1], seen[0], atol=1e-6 * np.abs(seen[0]).max())


def test_external_force_and_torque(centralised, quiet_run, run):
    """All modes included: force and torque times time are the momenta of body and structure together."""
    force, moment, duration = np.array([3.0, -2.0, 5.0]), np.array([0.4, -0.3, 0.2]), 2.0
    plant = stepper.prepare(centralised.plant, quiet_run(centralised.plant), 0.005)
    state, _ = run(centralised.spacecraft, plant, [(duration, (np.zeros(6), np.zeros((4, 6)), force, moment))])
    momenta = centralised.plant.mass_matrix[:6] @ stepper.structure_motion(plant, state)[plant.modes :]
    # the body turns by |T| t^2 / 2 J, 5e-6 rad, under way: momenta in its axes turn by as much
    assert_allclose(momenta, duration * np.concatenate([force, moment]), atol=1e-4)
    assert_allclose(stepper.telemetry(plant, state).angular_momentum, duration * moment, rtol=1e-5)


def test_jitter_of_one_wheel(distributed, quiet_run, run):
    """A lateral force at a site gives its impulse and its moment about the origin; a lateral torque its own."""
    n, wheel, duration = 33, 10, 0.5
    craft = distributed.spacecraft
    for kind, lateral in ((0, craft.lateral_a), (1, craft.lateral_b), (2, craft.lateral_a), (3, craft.lateral_b)):
        jitter = np.zeros((4, n))
        jitter[kind, wheel] = 2.0
        plant = stepper.prepare(distributed.plant, quiet_run(distributed.plant), 0.005)
        state, _ = run(craft, plant, [(duration, (np.zeros(n), jitter, np.zeros(3), np.zeros(3)))])
        momenta = distributed.plant.mass_matrix[:6] @ stepper.structure_motion(plant, state)[plant.modes :]
        along = 2.0 * duration * lateral[wheel]
        exact = [along, np.cross(craft.wheels.position[wheel], along)] if kind < 2 else [np.zeros(3), along]
        assert_allclose(momenta, np.concatenate(exact), atol=5e-5)  # turning under way, as above, by the moment of 14 m


def test_wheel_speed_is_relative_and_momentum_inertial(design, quiet_run):
    n = design.plant.wheels
    speeds, rate = np.linspace(-30.0, 30.0, n), np.array([0.1, -0.2, 0.3])
    flexing = np.linspace(-1.0, 1.0, design.plant.modes)
    parameters = quiet_run(design.plant, wheel_speed=speeds, rate=rate, modal_velocity=flexing)
    plant = stepper.prepare(design.plant, parameters, 0.005)
    state = stepper.init(plant)
    mounts = np.array(
        [
            axis @ (rate + slope @ flexing)
            for axis, slope in zip(design.plant.wheel_axis, design.plant.wheel_slope, strict=True)
        ]
    )
    rounding = 1e-13
    assert_allclose(state.momentum, design.plant.wheel_inertia * (speeds + mounts), rtol=rounding)
    assert_allclose(stepper.observe(plant, state).wheel_speed, speeds, atol=30.0 * rounding)


def test_accelerometers_feel_the_derivative_of_velocity(distributed, turning):
    """Inertial acceleration of the sites by central differences of their inertial velocities."""
    plant = stepper.prepare(distributed.plant, turning(distributed, 1.0), 1e-4)
    craft = distributed.spacecraft
    sites = craft.accelerometers
    state, nothing = stepper.init(plant), np.zeros(plant.input_count)
    velocities, matrices = [], []
    for k in range(5):
        if k:
            stepper.step(plant, state, nothing)
        if k == 2:
            sensed = stepper.observe(plant, state).accelerometer_site_acceleration.copy()
        _, v, w, speed = np.split(stepper.structure_motion(plant, state), plant.modes + np.array([0, 3, 6]))
        turned = rotations.matrix_from_mrp(state.mrp).T
        velocities.append((v + np.cross(w, sites.position) + sites.deflection @ speed) @ turned.T)
        matrices.append(turned)
    inertial = (velocities[3] - velocities[1]) / 2e-4
    exact = np.sum((inertial @ matrices[2]) * sites.axis, axis=1)
    # half a step between the gyroscopic terms held and now, 50 us times 40 rad/s; and P drops w x of the deflection
    assert_allclose(sensed, exact, atol=5e-3 * np.abs(exact).max())
