"""Torques against the harmonic jitter, against complex least squares on the closed loop."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from flexsat.description.wheel_set import WheelSet
from flexsat.design.jitter_cancellation import jitter_torque

PERIOD, EFFORT = 0.005, 1e-7
WHEEL = 3


@pytest.fixture(scope="module")
def torques(centralised):
    d = centralised
    return jitter_torque(d.model, d.config.wheel_set, d.fine, d.regulator.gain, d.model, PERIOD, EFFORT)


def sampled(model):
    n = model.index.unfiltered
    inputs = np.hstack([model.b_torque[:n], model.b_jitter[:n]])
    block = np.zeros((n + inputs.shape[1],) * 2)
    block[:n, :n], block[:n, n:] = PERIOD * model.a[:n, :n], PERIOD * inputs
    held = expm(block)[:n]
    return held[:, :n], held[:, n : n + model.index.wheels], held[:, n + model.index.wheels :]


def response(design, torque, jitter):
    """Return modal displacements and torques for phasors of feed-forward (n,) and jitter (4 n,), at WHEEL's speed.

    Unknowns x[k], xh[k], u[k]: z x = a x + b u + j d;  xh = (1 - l c) (a xh + b u + j d) / z + l c x;  u = g - k xh.
    """
    model = design.model
    a, b, j = sampled(model)
    n, g, acc, wheels = model.index.unfiltered, model.gyro_count, model.index.accelerometers, model.index.wheels
    rows = np.r_[0:g, g + acc : g + acc + wheels]
    c, gain, k = model.c[rows][:, :n], design.fine.gain[1][:n][:, rows], design.regulator.gain
    z = np.exp(1j * model.nominal_speed[WHEEL] * PERIOD)
    rest = np.eye(n) - gain @ c
    matrix = np.block(
        [
            [z * np.eye(n) - a, np.zeros((n, n)), -b],
            [-gain @ c, np.eye(n) - rest @ a / z, -rest @ b / z],
            [np.zeros((wheels, n)), k, np.eye(wheels)],
        ]
    )
    x = np.linalg.solve(matrix, np.concatenate([j @ jitter, rest @ j @ jitter / z, torque]))
    return np.concatenate([x[model.index.modal_displacement], np.sqrt(EFFORT) * x[2 * n :]])


def phasors(design):
    """Return the jitter of WHEEL as phasors of exp(j angle at mid-step), (4 n,): forces sin, cos, torques -cos, sin."""
    wheel, n = design.config.wheel, design.model.index.wheels
    square = design.model.nominal_speed[WHEEL] ** 2
    found = np.zeros(4 * n, dtype=complex)
    found[WHEEL::n] = square * np.array(
        [-1j * wheel.imbalance_force, wheel.imbalance_force, -wheel.imbalance_torque, -1j * wheel.imbalance_torque]
    )
    return found


def test_no_torque_costs_less(centralised, torques):
    """Complex least squares over the torques of all wheels, from responses of the closed loop to one of each."""
    n = centralised.model.index.wheels
    jitter = phasors(centralised)
    free = response(centralised, np.zeros(n), jitter)
    each = np.array([response(centralised, unit, 0.0 * jitter) for unit in np.eye(n)]).T
    best = -np.linalg.lstsq(each, free, rcond=None)[0]
    # the normal equations square the condition of the least squares, some 1e4
    assert_allclose(torques @ jitter, best, rtol=1e-5, atol=1e-5 * np.abs(best).max())


def test_a_wheel_without_imbalance_needs_none(centralised):
    d = centralised
    balanced = WheelSet.of([replace(d.config.wheel, imbalance_force=0.0, imbalance_torque=0.0)] * 6)
    assert not jitter_torque(d.model, balanced, d.fine, d.regulator.gain, d.model, PERIOD, EFFORT).any()
