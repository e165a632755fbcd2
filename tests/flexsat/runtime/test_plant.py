"""The plant against PHYSICS section 2 written out independently, and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from flexsat.runtime import plant as stepper


def equations(spacecraft, torque, jitter, force, moment):
    """Return the right-hand side of PHYSICS section 2, inputs held; state p, v, w, eta, eta', rho, wheel angle."""
    m, n = spacecraft.mode_count, spacecraft.wheel_count
    lv, lw, axis = spacecraft.translation, spacecraft.rotation, spacecraft.wheels.axis
    slope, position, lift = spacecraft.wheels.slope, spacecraft.wheels.position, spacecraft.wheels.deflection
    mass, inertia = spacecraft.mass, spacecraft.inertia
    none = np.zeros((3, 3))
    left = np.block([[mass * np.eye(3), none, lv], [none, inertia, lw], [lv.T, lw.T, np.eye(m)]])
    pushes = jitter[0][:, None] * spacecraft.lateral_a + jitter[1][:, None] * spacecraft.lateral_b
    twists = jitter[2][:, None] * spacecraft.lateral_a + jitter[3][:, None] * spacecraft.lateral_b
    total_force = force + pushes.sum(axis=0)
    total_moment = moment + np.cross(position, pushes).sum(axis=0) + twists.sum(axis=0) - axis.T @ torque
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
        spin = rho / spacecraft.wheel_set.inertia - np.sum(axis * mount, axis=1)
        return np.concatenate([turn, change[:6], speed, change[6:], torque, spin])

    return derivative


def reference(design, start, segments):
    """Integrate by DOP853 over segments of (duration, inputs); return the end state."""
    y = start
    for duration, held in segments:
        run = solve_ivp(
            equations(design.spacecraft, *held), (0.0, duration), y, method="DOP853", rtol=1e-12, atol=1e-15
        )
        y = run.y[:, -1]
    return y


def start_vector(matrices, parameters):
    """Return the state vector of `equations` at the start of a run."""
    momentum = stepper.init(stepper.prepare(matrices, parameters, 0.01)).momentum
    q = parameters
    return np.concatenate([q.mrp, q.velocity, q.rate, q.modal_displacement, q.modal_velocity, momentum, q.wheel_angle])


def as_vector(plant, state, outputs):
    eta, _, speed = np.split(stepper.structure_motion(plant, state), [plant.modes, plant.modes + 6])
    parts = [outputs.mrp, outputs.velocity, outputs.rate, eta, speed, state.momentum, outputs.wheel_angle]
    return np.concatenate(parts)


def test_second_order_where_every_term_counts(design, quiet_run, run):
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
    start = start_vector(design.plant, parameters)
    exact = reference(design, start, segments)
    parts = {"mrp": (0, 3), "velocity": (3, 6), "rate": (6, 9), "eta": (9, 9 + m), "eta'": (9 + m, 9 + 2 * m)}
    parts["angle"] = (9 + 2 * m + n, len(exact))
    errors = {name: [] for name in parts}
    for step in (0.01, 0.005, 0.0025):
        plant = stepper.prepare(design.plant, parameters, step)
        found = as_vector(plant, *run(design.spacecraft, plant, segments))
        # exact but for the sum of 160 roundings: torque is held
        assert_allclose(found[9 + 2 * m : 9 + 2 * m + n], exact[9 + 2 * m : 9 + 2 * m + n], rtol=1e-12)
        for name, (a, b) in parts.items():
            errors[name].append(np.linalg.norm(found[a:b] - exact[a:b]) / np.linalg.norm(exact[a:b]))
    for name, error in errors.items():
        order = np.log2(error[1] / error[2])
        # two, up to the next term of the error: a step of 5 ms turns the fastest mode by .2 rad
        assert abs(order - 2.0) < 0.2, f"{name}: order {order:.2f}, errors {error}"
        assert error[2] < 5e-3, name  # .3 % is seen in eta': none of the terms is missing


def test_second_order_while_wheels_spin_up_from_rest(centralised, quiet_run, run):
    """Wheel momentum that is all made under way: it counts at mid-step."""
    torque = 50.0 * np.array([80.0, -50.0, 60.0, -30.0, 70.0, -40.0])
    segments = [(0.4, (torque, np.zeros((4, 6)), np.zeros(3), np.zeros(3)))]
    parameters = quiet_run(centralised.plant, rate=np.array([0.03, -0.02, 0.025]))
    exact = reference(centralised, start_vector(centralised.plant, parameters), segments)
    error = []
    for step in (0.01, 0.005, 0.0025, 0.00125):
        plant = stepper.prepare(centralised.plant, parameters, step)
        found = as_vector(plant, *run(centralised.spacecraft, plant, segments))
        error.append(np.linalg.norm((found - exact)[6:9]))
    assert_allclose(np.log2(np.divide(error[:-1], error[1:])), 2.0, atol=0.1)  # 2.07, 2.05, 2.03 seen


def test_accurate_in_the_mission_regime(design, quiet_run, run):
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
    plant = stepper.prepare(design.plant, parameters, 0.005)
    start, m = start_vector(design.plant, parameters), plant.modes
    exact = reference(design, start, segments)
    found = as_vector(plant, *run(design.spacecraft, plant, segments))
    error = np.linalg.norm((found - exact)[9 : 9 + m]) / np.linalg.norm(exact[9 : 9 + m])
    assert error < 1e-4


def test_torque_free_precession(centralised, quiet_run, run, rigid):
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
        plant = stepper.prepare(matrices, parameters, step)
        state, outputs = run(
            centralised.spacecraft, plant, [(duration, (np.zeros(6), np.zeros((4, 6)), np.zeros(3), np.zeros(3)))]
        )
        error.append(np.linalg.norm(outputs.rate - exact))
    momentum = stepper.telemetry(plant, state).angular_momentum
    assert error[1] < 1e-4 * start[0]  # (k w h)^2/12 a radian: (.4 x .3 x .02)^2 / 24 x 1.2 rad, and as much again
    assert_allclose(error[0] / error[1], 4.0, rtol=0.1)  # order 2
    assert_allclose(momentum, inertia * start, atol=1e-4 * np.linalg.norm(inertia * start))  # the same order, in C


def test_tumble_through_the_shadow_set(centralised, quiet_run, rigid):
    """Two turns and a bit about a fixed axis: the attitude is the rotation by rate times time, always the short one."""
    matrices = rigid(centralised)
    rate = np.array([0.0, 0.0, 0.9])
    plant = stepper.prepare(matrices, quiet_run(matrices, rate=rate, mrp=np.array([0.3, 0.2, -0.1])), 0.01)
    first = Rotation.from_mrp([0.3, 0.2, -0.1])
    state, nothing = stepper.init(plant), np.zeros(plant.input_count)
    switches, last = 0, np.array(state.mrp)
    for k in range(1600):
        outputs = stepper.step(plant, state, nothing)
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


def test_spinning_up_one_wheel(centralised, quiet_run, run, rigid):
    """A rigid body at rest: body and rotor turn against each other, the motor's torque times time each."""
    matrices = rigid(centralised)
    inertia, rotor, torque, duration = centralised.spacecraft.inertia[0, 0], matrices.wheel_inertia[0], 2.0, 3.0
    commanded = np.zeros(6)
    commanded[0] = torque
    plant = stepper.prepare(matrices, quiet_run(matrices), 0.005)
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


def test_gyroscopics_can_be_switched_off(design, quiet_run, run):
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
    ends = {}
    for name, parameters in cases.items():
        plant = stepper.prepare(design.plant, parameters, 1e-3)
        ends[name] = stepper.structure_motion(plant, run(design.spacecraft, plant, [(0.05, nothing)])[0])
    assert np.array_equal(ends["without"], ends["no momentum"])
    assert np.abs(ends["with"] - ends["without"]).max() > 1e-6


def test_motors_are_limited(design, quiet_run, run):
    n = design.plant.wheels
    limited = stepper.prepare(design.plant, quiet_run(design.plant, torque_limit=0.7), 0.005)
    free = stepper.prepare(design.plant, quiet_run(design.plant), 0.005)
    asked = np.linspace(-3.0, 3.0, n)
    rest = (np.zeros((4, n)), np.zeros(3), np.zeros(3))
    clipped, seen = run(design.spacecraft, limited, [(0.05, (asked, *rest))])
    given, expected = run(design.spacecraft, free, [(0.05, (np.clip(asked, -0.7, 0.7), *rest))])
    assert_allclose(clipped.vector, given.vector, rtol=1e-14)  # the same numbers
    for name in ("rate", "gyro_site_rate", "wheel_speed"):
        assert_allclose(getattr(seen, name), getattr(expected, name), rtol=1e-14)
    with pytest.raises(ValueError, match="torque_limit must be > 0"):
        quiet_run(design.plant, torque_limit=0.0)


def test_inputs_are_left_as_they_were(centralised, quiet_run):
    plant = stepper.prepare(centralised.plant, quiet_run(centralised.plant, torque_limit=0.1), 0.005)
    given = np.full(plant.input_count, 2.0)
    stepper.step(plant, stepper.init(plant), given)
    assert np.all(given == 2.0)


def test_invalid_parameters_are_refused(centralised, quiet_run):
    with pytest.raises(ValueError, match=r"initial.mrp: norm must be <= 1 \(short rotation\), got 1.2"):
        quiet_run(centralised.plant, mrp=np.array([1.2, 0.0, 0.0]))
    with pytest.raises(ValueError, match=r"dispersion\.inertia: every relative error must be > -1"):
        quiet_run(centralised.plant, inertia_dispersion=np.array([0.0, -1.0, 0.0]))
    with pytest.raises(ValueError, match="period must be > 0"):
        stepper.prepare(centralised.plant, quiet_run(centralised.plant), 0.0)


def test_accelerometers_feel_every_term(distributed, quiet_run):
    """a . (v' + w x v + w' x r + w x (w x r)) and the deflection's acceleration; anywhere, along any axis."""
    rng = np.random.default_rng(11)
    m, n, k = distributed.plant.modes, distributed.plant.wheels, len(distributed.plant.accelerometer_axis)
    axis, position = rng.standard_normal((k, 3)), 10.0 * rng.standard_normal((k, 3))
    matrices = replace(distributed.plant, accelerometer_axis=axis, accelerometer_position=position)
    rate, velocity = np.array([0.4, -0.3, 0.5]), np.array([0.2, 0.5, -0.4])
    parameters = quiet_run(matrices, rate=rate, velocity=velocity, wheel_speed=np.linspace(-20.0, 20.0, n))
    nothing = (np.zeros(n), np.zeros((4, n)), np.zeros(3), np.zeros(3))
    change = equations(distributed.spacecraft, *nothing)(0.0, start_vector(matrices, parameters))
    acceleration, turning, flexing = change[3:6], change[6:9], change[9 + m : 9 + 2 * m]
    rigid = acceleration + np.cross(rate, velocity) + np.cross(turning, position)
    rigid += np.cross(rate, np.cross(rate, position))
    exact = np.sum(axis * rigid, axis=1) + matrices.accelerometer_deflection @ flexing
    sensed = stepper.init(stepper.prepare(matrices, parameters, 1e-3)).outputs.accelerometer_site_acceleration
    assert_allclose(sensed, exact, atol=1e-12 * np.abs(exact).max())  # rounding of products and of a solve of 31 rows
