"""Nominal wheel speeds, and the response they come from against a state-space frequency response."""

import control
import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.parameters import RPM
from flexsat.spacecraft.linear_model import linearise
from flexsat.spacecraft.wheel_speeds import imbalance_response

GRID = (100.0 - 200.0 / 60.0) / 999.0 * 60.0  # rpm between speeds of the release's grid


def test_nominal_speeds(centralised, distributed):
    """PHYSICS section 5, printed to 1 rpm; a grid step of 5.8 rpm either way is the same valley."""
    found = centralised.response.nominal / RPM
    assert_allclose(found, [351.0, 351.0, 223.0] * 2, atol=1.0)
    found = distributed.response.nominal / RPM
    assert_allclose([found.min(), found.max()], [223.0, 833.0], atol=1.0)
    assert np.all(np.abs(found / GRID - 200.0 / GRID - np.round(found / GRID - 200.0 / GRID)) < 1e-6)  # on the grid


@pytest.mark.parametrize("wheel", [0, 2, 7, 20])
def test_response_of_one_wheel(distributed, wheel):
    """Modal velocities of the linear model at rest, by python-control, for force and torque along both lateral axes."""
    craft = distributed.spacecraft
    model = linearise(craft, np.zeros(33), 80.0)
    n = model.index.unfiltered
    inputs = wheel + 33 * np.arange(4)
    data = craft.wheel_set
    scale = [data.imbalance_force[wheel]] * 2 + [data.imbalance_torque[wheel]] * 2
    pick = np.eye(n)[model.index.modal_velocity]
    system = control.ss(model.a[:n, :n], model.b_jitter[:n, inputs] * scale, pick, np.zeros((25, 4)))
    frequency = 2.0 * np.pi * np.array([3.5, 5.0, 13.7, 60.0])
    expected = [np.linalg.svd(system(1j * w), compute_uv=False)[0] for w in frequency]
    # two ways to solve one linear system; resonances amplify rounding by 1/(2 zeta), 1e2
    assert_allclose(imbalance_response(craft, frequency)[wheel], expected, rtol=1e-9)


def test_moving_maximum_and_its_minimum(design):
    """The worst response within 25 rpm either side, whose least value inside the range is the choice."""
    response = design.response
    hertz = response.speed / (2.0 * np.pi)
    assert_allclose(hertz[[0, -1]], [200.0 / 60.0, 100.0], rtol=1e-12)
    raw = imbalance_response(design.spacecraft, response.speed[:30]) * hertz[:30] ** 2
    assert_allclose(response.response[:, :30], raw, rtol=1e-12)  # the same solution
    half = 4  # nine points of 5.8 rpm are 52 rpm, the nearest odd number to 50 rpm
    for k in range(half, len(hertz) - half, 37):
        assert_allclose(response.worst[:, k], response.response[:, k - half : k + half + 1].max(axis=1), rtol=1e-15)
    chosen = np.searchsorted(response.speed, response.nominal * (1.0 - 1e-9))
    inner = response.worst[:, half:-half]
    assert_allclose(response.worst[np.arange(len(chosen)), chosen], inner.min(axis=1), rtol=1e-15)
    assert np.all(response.nominal >= response.speed[half])
