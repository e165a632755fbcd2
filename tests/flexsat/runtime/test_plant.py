"""The plant against PHYSICS section 2 written out anew, closed forms and invariants."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from flexsat.runtime import plant as subject
from flexsat.runtime.plant import Plant


def equations(spacecraft, torque, jitter, force, moment):
    """Return the right-hand side of PHYSICS section 2, inputs held; state p, v, w, eta, eta', rho, wheel angle."""
    m, n = spacecraft.mode_count, spacecraft.wheel_count
    lv, lw, axis = spacecraft.translation, spacecraft.rotation, spacecraft.wheels.axis
    slope, place, lift = spacecraft.wheels.slope, spacecraft.wheels.position, spacecraft.wheels.deflection
    mass, inertia = spacecraft.mass, spacecraft.inertia
    none = np.zeros((3, 3))
    left = np.block([[mass * np.eye(3), none, lv], [none, inertia, lw], [lv.T, lw.T, np.eye(m)]])
    pushes = jitter[0][:, None] * spacecraft.lateral_a + jitter[1][:, None] * spacecraft.lateral_b
    twists = jitter[2][:, None] * spacecraft.lateral_a + jitter[3][:, None] * spacecraft.lateral_b
    total_force = force + pushes.sum(axis=0)
    total_moment = moment + np.cross(place, pushes).sum(axis=0) + twists.sum(axis=0) - axis.T @ torque
    modal = np.einsum("nim,ni->m", lift, pushes) + np.einsum("nim,ni->m", slope, twists - torque[:, None] * axis)

    def derivative(_time, y):
        p, v, w, eta, speed, rho = np.split(y[: 9 + 2 * m + n], [3, 6, 9, 9 + m, 9 + 2 * m])
        mount = w + slope @ speed  # (n, 3): w + N_i eta'
        gyroscopic = np.cross(mount, rho[:, None] * axis)
        linear = mass * v + lv @ speed
        right = np.concatenate(
            [
                total_force - np.cross(w, linear),
                total_moment - np.cross(w, inertia @ w + lw @ speed) - gyroscopic.sum(axis=0),
                modal
                - spacecraft.damping * speed
                - spacecraft.frequency**2 * eta
                - np.einsum("nim,ni->m", slope, gyroscopic)
                - lv.T @ np.cross(w, linear) / mass,  # PHYSICS has +: see test_uniform_motion_changes_nothing
            ]
        )
        change = np.linalg.solve(left, right)
        turn = 0.25 * ((1.0 - p @ p) * w + 2.0 * np.cross(p, w) + 2.0 * p * (p @ w))
        spin = rho / spacecraft.wheel.inertia - np.sum(axis * mount, axis=1)
        return np.concatenate([turn, change[:6], speed, change[6:], torque, spin])

    return derivative


def inputs_of(spacecraft, torque, jitter, force, moment):
    return np.concatenate([torque, spacecraft.wrench_of_jitter @ np.ravel(jitter), force, moment])


def reference(design, start, segments):
    """Integrate by DOP853 over segments of (duration, inputs); return the end state."""
    y = start
    for duration, held in segments:
        run = solve_ivp(
            equations(design.spacecraft, *held), (0.0, duration), y, method="DOP853", rtol=1e-12, atol=1e-15
        )
        y = run.y[:, -1]
    return y


def start_vector(plant):
    q, m = plant.parameters, plant.modes
    state = subject.init(plant)
    return np.concatenate(
        [q.mrp, q.velocity, q.rate, q.modal_displacement, q.modal_velocity, state.momentum, q.wheel_angle]
    ), m


def run(spacecraft, plant, segments):
    """Step through segments of (duration, inputs); return state and outputs at the end."""
    state = subject.init(plant)
    for duration, held in segments:
        for _ in range(round(duration / plant.step_length)):
            state, outputs = subject.step(plant, state, inputs_of(spacecraft, *held))
    return state, outputs


def as_vector(state, outputs):
    return np.concatenate(
        [
            outputs.mrp,
            outputs.velocity,
            outputs.rate,
            outputs.modal_displacement,
            outputs.modal_velocity,
            state.momentum,
            outputs.wheel_angle,
        ]
    )


def test_second_order_where_every_term_counts(design, quiet_run):
    """A tumble at several deg/s with wheels at speed, hard torques, jitter and external loads."""
    rng = np.random.default_rng(5)
    m, n = design.plant.modes, design.plant.wheels
    parameters = quiet_run(
        design.plant,
        mrp=np.array([0.2, -0.3, 0.1]),
        rate=np.array([0.08, -0.05, 0.06]),
        velocity=np.array([0.3, -0.2, 0.1]),
        modal_displacement=rng.standard_normal(m) / design.plant.frequency,
        modal_velocity=rng.standard_normal(m),
        wheel_speed=rng.uniform(-80.0, 80.0, n),
        wheel_angle=rng.uniform(0.0, 6.0, n),
    )
    held = (
        rng.uniform(-20.0, 20.0, n),
        rng.uniform(-5.0, 5.0, (4, n)),
        np.array([30.0, -20.0, 50.0]),
        np.array([300.0, -200.0, 400.0]),
    )
    segments = [(0.4, held)]
    start, _ = start_vector(Plant(design.plant, parameters, 0.01))
    exact = reference(design, start, segments)
    parts = {"mrp": (0, 3), "velocity": (3, 6), "rate": (6, 9), "eta": (9, 9 + m), "eta'": (9 + m, 9 + 2 * m)}
    parts["angle"] = (9 + 2 * m + n, len(exact))
    errors = {name: [] for name in parts}
    for step in (0.01, 0.005, 0.0025):
        found = as_vector(*run(design.spacecraft, Plant(design.plant, parameters, step), segments))
        # exact but for the sum of 160 roundings: torque is held
        assert_allclose(found[9 + 2 * m : 9 + 2 * m + n], exact[9 + 2 * m : 9 + 2 * m + n], rtol=1e-12)
        for name, (a, b) in parts.items():
            errors[name].append(np.linalg.norm(found[a:b] - exact[a:b]) / np.linalg.norm(exact[a:b]))
    for name, error in errors.items():
        order = np.log2(error[1] / error[2])
        # two, up to the next term of the error: a step of 5 ms turns the fastest mode by .2 rad
        assert abs(order - 2.0) < 0.2, f"{name}: order {order:.2f}, errors {error}"
        assert error[2] < 5e-3, name  # .3 % is seen in eta': none of the terms is missing


def test_second_order_while_wheels_spin_up_from_rest(centralised, quiet_run):
    """Wheel momentum that is all made under way: it counts at mid-step."""
    torque = 50.0 * np.array([80.0, -50.0, 60.0, -30.0, 70.0, -40.0])
    segments = [(0.4, (torque, np.zeros((4, 6)), np.zeros(3), np.zeros(3)))]
    parameters = quiet_run(centralised.plant, rate=np.array([0.03, -0.02, 0.025]))
    exact = reference(centralised, start_vector(Plant(centralised.plant, parameters, 0.01))[0], segments)
    error = []
    for step in (0.01, 0.005, 0.0025, 0.00125):
        found = as_vector(*run(centralised.spacecraft, Plant(centralised.plant, parameters, step), segments))
        error.append(np.linalg.norm((found - exact)[6:9]))
    assert_allclose(np.log2(np.divide(error[:-1], error[1:])), 2.0, atol=0.1)  # 2.07, 2.05, 2.03 seen


def test_accurate_in_the_mission_regime(design, quiet_run):
    """PHYSICS section 8: 1e-4 in eta at 5 ms, under slew torques and imbalance forces at the nominal speeds."""
    rng = np.random.default_rng(6)
    n, wheel = design.plant.wheels, design.config.wheel
    speeds = design.model.nominal_speed
    parameters = quiet_run(design.plant, rate=np.array([9e-5, 1e-6, 1e-6]), wheel_speed=speeds)
    push, twist = wheel.imbalance_force * speeds**2, wheel.imbalance_torque * speeds**2
    segments = []
    for _ in range(40):
        jitter = rng.uniform(-1.0, 1.0, (4, n)) * np.stack([push, push, twist, twist])
        torque = 0.8 * wheel.torque_limit * rng.uniform(-1.0, 1.0, n)
        segments.append((0.05, (torque, jitter, np.zeros(3), np.zeros(3))))
    plant = Plant(design.plant, parameters, 0.005)
    start, m = start_vector(plant)
    exact = reference(design, start, segments)
    found = as_vector(*run(design.spacecraft, plant, segments))
    error = np.linalg.norm((found - exact)[9 : 9 + m]) / np.linalg.norm(exact[9 : 9 + m])
    assert error < 1e-4


def turning(design, quiet_run, amplitude, step, damped=True):
    """Prepare a passive run without net linear momentum, wheels at speed."""
    rng = np.random.default_rng(7)
    m, n = design.plant.modes, design.plant.wheels
    velocity = amplitude * rng.standard_normal(m)
    parameters = quiet_run(
        design.plant,
        rate=amplitude * np.array([0.02, -0.03, 0.01]),
        velocity=-design.spacecraft.translation @ velocity / design.spacecraft.mass,
        modal_displacement=amplitude * rng.standard_normal(m) / design.plant.frequency,
        modal_velocity=velocity,
        wheel_speed=rng.uniform(-40.0, 40.0, n),
        damping_dispersion=np.zeros(m) if damped else np.full(m, -1.0),
    )
    return Plant(design.plant, parameters, step)


def passive(plant, duration):
    """Return the telemetry at the start and after each step of a run without inputs."""
    state, nothing = subject.init(plant), np.zeros(plant.input_count)
    seen = [subject.telemetry(plant, state)]
    for _ in range(round(duration / plant.step_length)):
        subject.step(plant, state, nothing)
        seen.append(subject.telemetry(plant, state))
    return seen


def test_angular_momentum_is_kept_to_second_order(distributed, quiet_run):
    """What is not kept is rho w x (N eta x e): half the motion, a quarter of it (PHYSICS section 2)."""
    drift, size = [], []
    for amplitude in (0.2, 0.1, 0.05):
        # the integrator's own error is proportional to the amplitude; .5 ms makes it small beside the drift
        momentum = np.array(
            [t.angular_momentum for t in passive(turning(distributed, quiet_run, amplitude, 0.0005), 1.0)]
        )
        drift.append(np.linalg.norm(momentum - momentum[0], axis=1).max())
        size.append(np.linalg.norm(momentum[0]))
    ratio = np.array(drift[:-1]) / drift[1:]
    assert_allclose(ratio, 4.0, rtol=0.05)  # the third order, and the integrator, are the rest
    assert drift[0] < 1e-3 * size[0]


def test_angular_momentum_is_kept_exactly_with_wheels_on_the_bus(centralised, quiet_run):
    """The bus does not tilt: only the integrator errs, by order 2."""
    drift = []
    for step in (0.004, 0.002):
        momentum = np.array([t.angular_momentum for t in passive(turning(centralised, quiet_run, 1.0, step), 1.0)])
        drift.append(np.linalg.norm(momentum - momentum[0], axis=1).max())
    assert_allclose(drift[0] / drift[1], 4.0, rtol=0.1)  # order 2


def test_energy_without_damping_is_kept_to_the_integrators_order(design, quiet_run):
    drift = []
    for step in (0.004, 0.002):
        energy = np.array([t.energy for t in passive(turning(design, quiet_run, 1.0, step, damped=False), 1.0)])
        drift.append(np.abs(energy - energy[0]).max())
    assert drift[0] / drift[1] > 3.6  # order 2 or better


def test_energy_decays_in_a_passive_run(design, quiet_run):
    energy = np.array([t.energy for t in passive(turning(design, quiet_run, 1.0, 0.001), 5.0)])
    change = np.diff(energy)
    # each step may gain what the integrator errs, which is 1e-3 of what damping takes
    assert change.max() < 1e-3 * np.abs(change).max()
    assert energy[-1] < energy[0]


def test_work_of_the_wheel_motors(design, quiet_run):
    """Energy gained is torque times the angle that each rotor turns against its mount."""
    rng = np.random.default_rng(8)
    n = design.plant.wheels
    parameters = quiet_run(
        design.plant, wheel_speed=rng.uniform(10.0, 40.0, n), damping_dispersion=np.full(design.plant.modes, -1.0)
    )
    torque = rng.uniform(-1.0, 1.0, n)
    gap = []
    for step in (0.004, 0.002):
        plant = Plant(design.plant, parameters, step)
        before = subject.telemetry(plant, subject.init(plant)).energy
        state, outputs = run(design.spacecraft, plant, [(1.0, (torque, np.zeros((4, n)), np.zeros(3), np.zeros(3)))])
        gained = subject.telemetry(plant, state).energy - before
        gap.append(abs(gained - torque @ outputs.wheel_angle))
        assert gap[-1] < 1e-5 * abs(gained)
    assert gap[0] / gap[1] > 3.6 or gap[0] < 1e-11 * abs(gained)  # order 2, or nothing but rounding


def test_uniform_motion_changes_nothing(centralised, quiet_run):
    """An observer who moves along sees the same rates and modes (Galileo)."""
    seen = []
    for speed in (0.0, 1.0):
        plant = turning(centralised, quiet_run, 1.0, 0.001)
        moving = replace(plant.parameters, velocity=plant.parameters.velocity + np.array([speed, 0.0, 0.0]))
        _, outputs = run(
            centralised.spacecraft,
            Plant(centralised.plant, moving, 0.001),
            [(1.0, (np.zeros(6), np.zeros((4, 6)), np.zeros(3), np.zeros(3)))],
        )
        seen.append(np.concatenate([outputs.rate, outputs.modal_displacement]))
    assert_allclose(seen[1], seen[0], atol=1e-6 * np.abs(seen[0]).max())


def rigid(design):
    """Return the plant's matrices with the modes uncoupled from the body: a rigid spacecraft."""
    mass = design.plant.mass_matrix.copy()
    mass[:6, 6:], mass[6:, :6] = 0.0, 0.0
    return replace(design.plant, mass_matrix=mass)


def test_torque_free_precession(centralised, quiet_run):
    """An axisymmetric body: the rate turns about z by (Jz - Jx)/Jx w_z, and momentum stays put in inertial space."""
    matrices = rigid(centralised)
    inertia = np.array([1.0, 1.0, 0.7]) * np.diag(centralised.spacecraft.inertia)
    start, duration = np.array([0.12, 0.0, 0.3]), 10.0
    phase = (inertia[2] / inertia[0] - 1.0) * start[2] * duration
    exact = np.array([start[0] * np.cos(phase), start[0] * np.sin(phase), start[2]])
    error = []
    for step in (0.04, 0.02):
        # the rotors do not turn in inertial space: no wheel momentum
        still = -matrices.wheel_axis @ start
        parameters = quiet_run(matrices, rate=start, wheel_speed=still, inertia_dispersion=np.array([0.0, 0.0, -0.3]))
        plant = Plant(matrices, parameters, step)
        state, outputs = run(
            centralised.spacecraft, plant, [(duration, (np.zeros(6), np.zeros((4, 6)), np.zeros(3), np.zeros(3)))]
        )
        error.append(np.linalg.norm(outputs.rate - exact))
    momentum = subject.telemetry(plant, state).angular_momentum
    assert error[1] < 1e-4 * start[0]  # (k w h)^2/12 a radian: (.4 x .3 x .02)^2 / 24 x 1.2 rad, and as much again
    assert_allclose(error[0] / error[1], 4.0, rtol=0.1)  # order 2
    assert_allclose(momentum, inertia * start, atol=1e-4 * np.linalg.norm(inertia * start))  # the same order, in C


def test_tumble_through_the_shadow_set(centralised, quiet_run):
    """Two turns and a bit about a fixed axis: the attitude is the rotation by rate times time, always the short one."""
    matrices = rigid(centralised)
    rate = np.array([0.0, 0.0, 0.9])
    plant = Plant(matrices, quiet_run(matrices, rate=rate, mrp=np.array([0.3, 0.2, -0.1])), 0.01)
    first = Rotation.from_mrp([0.3, 0.2, -0.1])
    state, nothing = subject.init(plant), np.zeros(plant.input_count)
    switches, last = 0, np.array(state.mrp)
    for k in range(1600):
        _, outputs = subject.step(plant, state, nothing)
        assert np.linalg.norm(outputs.mrp) <= 1.0 + 1e-12  # rounding of a norm of one
        switches += np.linalg.norm(outputs.mrp - last) > 1.0
        last = outputs.mrp.copy()
        if k % 100 == 99:
            exact = first * Rotation.from_rotvec(rate * 0.01 * (k + 1))
            # 1600 rotations, each rounded
            short = outputs.quaternion * np.sign(outputs.quaternion[3])
            assert_allclose(short, exact.as_quat(canonical=True), atol=1e-12)
            assert (Rotation.from_mrp(outputs.mrp).inv() * exact).magnitude() < 1e-11
    assert switches == 2


def test_spinning_up_one_wheel(centralised, quiet_run):
    """A rigid body at rest: body and rotor turn against each other, the motor's torque times time each."""
    matrices = rigid(centralised)
    inertia, rotor, torque, duration = centralised.spacecraft.inertia[0, 0], matrices.wheel_inertia, 2.0, 3.0
    commanded = np.zeros(6)
    commanded[0] = torque
    plant = Plant(matrices, quiet_run(matrices), 0.005)
    _, outputs = run(
        centralised.spacecraft, plant, [(duration, (commanded, np.zeros((4, 6)), np.zeros(3), np.zeros(3)))]
    )
    rounding = 1e-11  # 600 steps
    assert_allclose(outputs.rate, [-torque * duration / inertia, 0.0, 0.0], rtol=rounding, atol=1e-18)
    relative = torque * (1.0 / rotor + 1.0 / inertia)
    assert_allclose(outputs.wheel_speed[0], relative * duration, rtol=rounding)
    assert_allclose(outputs.wheel_angle[0], 0.5 * relative * duration**2, rtol=rounding)
    # the opposite rotor stays where it was, while its mount turns about its axis
    assert_allclose(outputs.wheel_speed[3], -torque * duration / inertia, rtol=rounding)
    assert_allclose(outputs.mrp[0], np.tan(-0.125 * torque * duration**2 / inertia), rtol=rounding)


def test_gyroscopics_can_be_switched_off(design, quiet_run):
    """Spinning wheels without them move the structure as wheels without momentum do, to the last bit."""
    m, n = design.plant.modes, design.plant.wheels
    rng = np.random.default_rng(8)
    rate, modal = np.array([1e-3, -2e-3, 3e-3]), 1e-3 * rng.standard_normal(m)
    still = -design.plant.wheel_axis @ rate - design.spacecraft.wheels.axial_slope @ modal  # no inertial momentum
    moving = {"rate": rate, "modal_velocity": modal}
    at_speed = np.linspace(20.0, 60.0, n)  # opposite wheels must not cancel
    cases = {
        "without": quiet_run(design.plant, wheel_speed=at_speed, gyroscopics=False, **moving),
        "with": quiet_run(design.plant, wheel_speed=at_speed, **moving),
        "no momentum": quiet_run(design.plant, wheel_speed=still, **moving),
    }
    nothing = (np.zeros(n), np.zeros((4, n)), np.zeros(3), np.zeros(3))
    ends = {
        name: run(design.spacecraft, Plant(design.plant, parameters, 1e-3), [(0.05, nothing)])[0].structure
        for name, parameters in cases.items()
    }
    assert np.array_equal(ends["without"], ends["no momentum"])
    assert np.abs(ends["with"] - ends["without"]).max() > 1e-6


def test_motors_are_limited(design, quiet_run):
    n = design.plant.wheels
    limited = Plant(design.plant, quiet_run(design.plant, torque_limit=0.7), 0.005)
    free = Plant(design.plant, quiet_run(design.plant), 0.005)
    asked = np.linspace(-3.0, 3.0, n)
    rest = (np.zeros((4, n)), np.zeros(3), np.zeros(3))
    _, clipped = run(design.spacecraft, limited, [(0.05, (asked, *rest))])
    _, given = run(design.spacecraft, free, [(0.05, (np.clip(asked, -0.7, 0.7), *rest))])
    for name in ("rate", "modal_velocity", "wheel_speed"):
        assert_allclose(getattr(clipped, name), getattr(given, name), rtol=1e-14)  # the same numbers
    with pytest.raises(ValueError, match="torque_limit must be > 0"):
        quiet_run(design.plant, torque_limit=0.0)


def test_inputs_are_left_as_they_were(centralised, quiet_run):
    plant = Plant(centralised.plant, quiet_run(centralised.plant, torque_limit=0.1), 0.005)
    given = np.full(plant.input_count, 2.0)
    subject.step(plant, subject.init(plant), given)
    assert np.all(given == 2.0)


def test_external_force_and_torque(centralised, quiet_run):
    """All modes included: force and torque times time are the momenta of body and structure together."""
    force, moment, duration = np.array([3.0, -2.0, 5.0]), np.array([0.4, -0.3, 0.2]), 2.0
    plant = Plant(centralised.plant, quiet_run(centralised.plant), 0.005)
    state, _ = run(centralised.spacecraft, plant, [(duration, (np.zeros(6), np.zeros((4, 6)), force, moment))])
    momenta = centralised.plant.mass_matrix[:6] @ state.structure[plant.modes :]
    # the body turns by |T| t^2 / 2 J, 5e-6 rad, under way: momenta in its axes turn by as much
    assert_allclose(momenta, duration * np.concatenate([force, moment]), atol=1e-4)
    assert_allclose(subject.telemetry(plant, state).angular_momentum, duration * moment, rtol=1e-5)


def test_jitter_of_one_wheel(distributed, quiet_run):
    """A lateral force at a site gives its impulse and its moment about the origin; a lateral torque its own."""
    n, wheel, duration = 33, 10, 0.5
    craft = distributed.spacecraft
    for kind, lateral in ((0, craft.lateral_a), (1, craft.lateral_b), (2, craft.lateral_a), (3, craft.lateral_b)):
        jitter = np.zeros((4, n))
        jitter[kind, wheel] = 2.0
        plant = Plant(distributed.plant, quiet_run(distributed.plant), 0.005)
        state, _ = run(craft, plant, [(duration, (np.zeros(n), jitter, np.zeros(3), np.zeros(3)))])
        momenta = distributed.plant.mass_matrix[:6] @ state.structure[plant.modes :]
        along = 2.0 * duration * lateral[wheel]
        exact = [along, np.cross(craft.wheels.position[wheel], along)] if kind < 2 else [np.zeros(3), along]
        assert_allclose(momenta, np.concatenate(exact), atol=5e-5)  # turning under way, as above, by the moment of 14 m


def test_wheel_speed_is_relative_and_momentum_inertial(design, quiet_run):
    n = design.plant.wheels
    speeds, rate = np.linspace(-30.0, 30.0, n), np.array([0.1, -0.2, 0.3])
    flexing = np.linspace(-1.0, 1.0, design.plant.modes)
    parameters = quiet_run(design.plant, wheel_speed=speeds, rate=rate, modal_velocity=flexing)
    plant = Plant(design.plant, parameters, 0.005)
    state = subject.init(plant)
    mounts = np.array(
        [
            axis @ (rate + slope @ flexing)
            for axis, slope in zip(design.plant.wheel_axis, design.plant.wheel_slope, strict=True)
        ]
    )
    rounding = 1e-13
    assert_allclose(state.momentum, design.plant.wheel_inertia * (speeds + mounts), rtol=rounding)
    assert_allclose(subject.observe(plant, state).wheel_speed, speeds, atol=30.0 * rounding)


def test_accelerometers_feel_the_derivative_of_velocity(distributed, quiet_run):
    """Inertial acceleration of the sites by central differences of their inertial velocities."""
    plant = turning(distributed, quiet_run, 1.0, 1e-4)
    craft = distributed.spacecraft
    sites = craft.accelerometers
    state, nothing = subject.init(plant), np.zeros(plant.input_count)
    velocities, matrices = [], []
    for k in range(5):
        if k:
            subject.step(plant, state, nothing)
        if k == 2:
            sensed = subject.observe(plant, state).accelerometer_site_acceleration.copy()
        m = plant.modes
        v, w, speed = state.structure[m : m + 3], state.structure[m + 3 : m + 6], state.structure[m + 6 :]
        turned = subject.rotations.matrix_from_mrp(state.mrp).T
        velocities.append((v + np.cross(w, sites.position) + sites.deflection @ speed) @ turned.T)
        matrices.append(turned)
    inertial = (velocities[3] - velocities[1]) / 2e-4
    exact = np.sum((inertial @ matrices[2]) * sites.axis, axis=1)
    # half a step between the gyroscopic terms held and now, 50 us times 40 rad/s; and P drops w x of the deflection
    assert_allclose(sensed, exact, atol=5e-3 * np.abs(exact).max())


def test_refusals(centralised, quiet_run):
    with pytest.raises(ValueError, match=r"initial.mrp: norm must be <= 1 \(short rotation\), got 1.2"):
        quiet_run(centralised.plant, mrp=np.array([1.2, 0.0, 0.0]))
    with pytest.raises(ValueError, match=r"dispersion\.inertia: every relative error must be > -1"):
        quiet_run(centralised.plant, inertia_dispersion=np.array([0.0, -1.0, 0.0]))
    with pytest.raises(ValueError, match="period must be > 0"):
        Plant(centralised.plant, quiet_run(centralised.plant), 0.0)
