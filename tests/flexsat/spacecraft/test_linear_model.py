"""The linear model against the nonlinear plant, stepped from each state in turn, and its gyroscopic terms."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.runtime import plant as nonlinear
from flexsat.spacecraft.linear_model import linearise

STEP = 1e-4  # s
SMALL = 1e-6  # perturbation: products of two are 1e-12, a millionth of it


@pytest.fixture(scope="module")
def nominal_plant(design, quiet_run):
    parameters = quiet_run(design.plant, wheel_speed=design.model.nominal_speed)
    return nonlinear.prepare(design.plant, parameters, STEP)


def stepped(design, plant, x, inputs):
    """Take one plant step from a linear state; return the linear state after it, the outputs and the true change."""
    index, inertia = design.model.index, design.plant.wheel_inertia[0]
    state = nonlinear.init(plant)
    # translation moves with the structure, so that there is no net linear momentum
    drift = -design.plant.mass_matrix[:3, 6:] @ x[index.modal_velocity] / design.plant.mass_matrix[0, 0]
    state.mrp = tuple(x[index.mrp])
    state.momentum[:] = inertia * (design.model.nominal_speed + x[index.wheel_speed])
    nonlinear.set_motion(
        plant, state, np.concatenate([x[index.modal_displacement], drift, x[index.rate], x[index.modal_velocity]])
    )
    outputs = nonlinear.step(plant, state, inputs)
    end = np.zeros(index.unfiltered)
    end[index.mrp], end[index.rate] = outputs.mrp, outputs.rate
    moved = nonlinear.telemetry(plant, state)
    end[index.modal_displacement], end[index.modal_velocity] = moved.modal_displacement, moved.modal_velocity
    end[index.wheel_speed] = state.momentum / inertia - design.model.nominal_speed
    return end, outputs


def test_every_column_is_the_plants_derivative(design, nominal_plant):
    """State, gyros, encoders, accelerometers after one step from each unit state, and under each unit input."""
    model, n = design.model, design.model.index.unfiltered
    wheels, gyros = design.plant.wheels, model.gyro_count
    a, b_torque, b_jitter = model.sampled(STEP)
    half, half_torque, half_jitter = model.sampled(0.5 * STEP)
    inputs = np.zeros(nominal_plant.input_count)
    rest, _ = stepped(design, nominal_plant, np.zeros(n), inputs)
    assert_allclose(rest, 0.0, atol=1e-15)  # nothing moves at rest; rounding of nominal speeds of order 1e2
    filtered = model.a[model.index.filter_rate] / model.filter_corner
    still = linearise(design.spacecraft, model.nominal_speed, 80.0, gyroscopic=False)
    gyroscopic = filtered - still.a[model.index.filter_rate] / model.filter_corner
    filter_torque = model.b_torque[model.index.filter_rate] / model.filter_corner
    filter_jitter = model.b_jitter[model.index.filter_rate] / model.filter_corner

    def compare(x, u, name):
        inputs[:wheels], inputs[wheels:-6] = u[:wheels], design.spacecraft.wrench_of_jitter @ u[wheels:]
        end, outputs = stepped(design, nominal_plant, SMALL * x, SMALL * inputs)
        expected = a[:n, :n] @ x + b_torque[:n] @ u[:wheels] + b_jitter[:n] @ u[wheels:]
        scale = max(np.abs(expected).max(), STEP)
        # the gyroscopic terms held at mid-step err by (w h)^3 of each step, (100 rad/s x 1e-4 s)^3 = 1e-6 at the
        # fastest coupling, and products of the perturbation with itself by 1e-6
        moving = model.index.wheel_speed.start
        assert_allclose(end[:moving] / SMALL, expected[:moving], atol=2e-6 * scale, err_msg=name)
        # wheel speeds of order 1e2 are rounded at 1e-14, over the perturbation
        assert_allclose(end[moving:] / SMALL, expected[moving:], atol=2e-6 * scale + 5e-8, err_msg=name)
        measured = np.concatenate([outputs.gyro_site_rate, outputs.wheel_speed - model.nominal_speed]) / SMALL
        rows = np.r_[:gyros, len(model.c) - 3 - wheels : len(model.c) - 3]
        assert_allclose(measured, model.c[rows][:, :n] @ expected, atol=2e-6 * scale + 5e-8, err_msg=name)
        # the plant's accelerations keep the gyroscopic terms that were held over the step: those of its middle
        middle = half[:n, :n] @ x + half_torque[:n] @ u[:wheels] + half_jitter[:n] @ u[wheels:]
        sensed = filtered[:, :n] @ expected + gyroscopic[:, :n] @ (middle - expected)
        sensed += filter_torque @ u[:wheels] + filter_jitter @ u[wheels:]
        found = outputs.accelerometer_site_acceleration / SMALL
        # again 1e-6 of the state's change, times squared frequencies up to 1.8e3 and deflections of .02
        assert_allclose(found, sensed, atol=4e-5 * max(scale, STEP), err_msg=name)

    nothing = np.zeros(5 * wheels)
    for k in range(n):
        compare(np.eye(n)[k], nothing, f"state {k}")
    for k in range(5 * wheels):
        compare(np.zeros(n), np.eye(5 * wheels)[k], f"input {k}")


def test_star_tracker_row_is_small_rotation_angles(design):
    model = design.model
    expected = np.zeros((3, model.index.size))
    expected[:, :3] = 4.0 * np.eye(3)  # an MRP is a quarter of a small angle
    assert_allclose(model.c[-3:], expected, rtol=0.0)


def test_filter_is_butterworth(design):
    """Alone, the filter rows have the poles of a second-order Butterworth filter, and unit gain at rest."""
    model = design.model
    corner = 2.0 * np.pi * 80.0
    k, start = model.index.accelerometers, model.index.filter_output.start
    block = model.a[start:, start:]
    assert_allclose(np.abs(np.linalg.eigvals(block)), corner, rtol=1e-7)  # repeated 13 times: rounding to the root
    assert_allclose(np.linalg.eigvals(block).real, -corner / np.sqrt(2.0), rtol=1e-7)
    gain = -np.linalg.solve(block, np.vstack([np.zeros((k, k)), corner * np.eye(k)]))[:k]
    assert_allclose(gain, np.eye(k), atol=1e-13)  # rounding


def test_gyroscopic_matrix_does_no_work(design):
    momentum = np.linspace(-30.0, 40.0, design.plant.wheels)  # those of opposite wheels do not cancel
    g = design.spacecraft.gyroscopic_matrix(momentum)
    assert np.abs(g).max() > 1.0  # N.m.s: there is something to test
    assert_allclose(g + g.T, 0.0, atol=1e-15 * np.abs(g).max())  # rounding


def test_gyroscopic_matrix_of_one_wheel(design):
    """A wheel about z on a body turning about x: the torque w x h is about -y, on the left-hand side."""
    momentum = np.zeros(design.plant.wheels)
    momentum[2] = 2.0
    force = design.spacecraft.gyroscopic_matrix(momentum)[:, 3]
    assert_allclose(force[3:6], [0.0, -2.0, 0.0], atol=0.0)


def test_undamped_model_keeps_energy(design):
    """d/dt of the quadratic energy vanishes identically without damping, gyroscopic terms included."""
    undamped = replace(design.spacecraft, damping=np.zeros(design.plant.modes))
    model = linearise(undamped, design.model.nominal_speed, 80.0)
    index, n = model.index, model.index.rate.start
    mass = design.spacecraft.mass_matrix  # with the couplings that rounding leaves, as the model has them
    # without net linear momentum the translation follows eta': its energy is taken out of the mass
    reduced = mass[3:, 3:] - mass[3:, :3] @ mass[:3, 3:] / mass[0, 0]
    moving = slice(index.rate.start, index.wheel_speed.start)
    energy = np.zeros((index.unfiltered, index.unfiltered))
    energy[3:n, 3:n] = np.diag(undamped.frequency**2)
    energy[moving, moving] = reduced
    power = energy @ model.a[: index.unfiltered, : index.unfiltered]
    # rounding of M^-1 times M, at the scale of the terms that cancel
    assert_allclose(power + power.T, 0.0, atol=1e-11 * np.abs(power).max())


def test_gyroscopic_terms_can_be_left_out(design):
    model = linearise(design.spacecraft, design.model.nominal_speed, 80.0, gyroscopic=False)
    still = linearise(design.spacecraft, np.zeros(design.plant.wheels), 80.0)
    assert_allclose(model.a, still.a, atol=0.0)
    # opposite wheels on the bus cancel each other; at the sites their mounts do not move alike
    assert np.any(model.a != design.model.a) == (design.config.name == "distributed")
