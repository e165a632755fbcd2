"""A regulator's gain is the same bits, whatever error a Riccati solver leaves."""

import numpy as np
from numpy.testing import assert_allclose
from scipy.linalg import solve_discrete_are

from flexsat.design.refined_gain import refined_gain
from flexsat.runtime.zero_order_hold import zero_order_hold

PERIOD = 5e-3  # s


def problem():
    """Return a, b, q, r of two oscillators and a free axis, with states that cost from 1e-2 to 1e8."""
    a = np.zeros((6, 6))
    a[0, 1] = a[2, 3] = a[4, 5] = 1.0
    a[3, 2:4], a[5, 4:6] = [-4.0, -0.02], [-90.0, -0.1]
    b = np.zeros((6, 2))
    b[1], b[3], b[5] = [1e-3, 0.0], [2e-4, 1e-4], [1e-4, -3e-4]
    ad, bd = zero_order_hold(a, b, PERIOD)
    return ad, bd, np.diag([1e7, 1e3, 1e8, 10.0, 1e4, 1e-2]), 0.1 * np.eye(2)


def test_errors_of_the_solver_do_not_show():
    a, b, q, r = problem()
    cost = solve_discrete_are(a, b, q, r)
    gain = refined_gain(a, b, q, r, cost)

    scale = np.sqrt(np.outer(np.diag(cost), np.diag(cost)))
    for seed in range(5):
        error = np.random.default_rng(seed).standard_normal(cost.shape)
        disturbed = cost + 1e-6 * scale * (error + error.T)  # as much as two kernels of OpenBLAS differ by
        assert refined_gain(a, b, q, r, disturbed).tobytes() == gain.tobytes()


def test_the_gain_is_that_of_the_riccati_equation():
    a, b, q, r = problem()
    cost = solve_discrete_are(a, b, q, r)
    expected = np.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)

    gain = refined_gain(a, b, q, r, cost)

    # the solver's own error is 1e-9 of the states' costs
    cost_of_one = np.sqrt(np.diag(cost))
    assert_allclose(gain / cost_of_one, expected / cost_of_one, atol=1e-8 * np.abs(expected / cost_of_one).max())
