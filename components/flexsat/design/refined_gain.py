"""Refine the cost matrix of a linear-quadratic regulator until its gain is the same with any library.

Solvers of the algebraic Riccati equation leave relative errors of up to 2e-6 that depend on the processor's linear
algebra: the slowest closed-loop pole is near the unit circle, and states cost from 1e-2 to 1e8. Newton corrections with
residuals in double-double arithmetic leave 1e-20.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import Array
from ..double_double import Pair, exactly, product
from ..fixed_order import on_grid, symmetric

CORRECTIONS = 4  # of the cost matrix: from 1e-6 to 1e-12 as Newton's method does, then by 1e-7 or better each
GAIN_CORRECTIONS = 2  # of the gain of a cost matrix, by 1e-10 each


def refined_gain(a: Array, b: Array, state_weight: Array, torque_weight: Array, cost: Array) -> Array:
    """Return the gain k of u = -k x, (m, n), rounded to 12 digits of the largest number in each column.

    Parameters
    ----------
    a, b : (n, n), (n, m): of the sampled system
    state_weight, torque_weight : (n, n), (m, m), symmetric
    cost : (n, n): what a solver of the Riccati equation gives

    Source: Hewer (1971), IEEE Trans. Automatic Control 16(4), for the correction.
    """
    exact_a, exact_b = exactly(a), exactly(b)
    solution = exactly(symmetric(cost))
    for _ in range(CORRECTIONS):
        after, cross, gain = _gain(exact_a, exact_b, torque_weight, solution)
        defect = product(exact_a.transposed, after) - solution + state_weight - product(cross.transposed, gain)
        closed = a - b @ gain.high
        change = np.asarray(scipy.linalg.solve_discrete_lyapunov(closed.T, symmetric(defect.high)), np.float64)
        solution = solution + symmetric(change)
    return on_grid(_gain(exact_a, exact_b, torque_weight, solution)[2].high)


def _gain(a: Pair, b: Pair, torque_weight: Array, cost: Pair) -> tuple[Pair, Pair, Pair]:
    """Return cost a, b^T cost a, and the gain (torque_weight + b^T cost b)^-1 b^T cost a."""
    after = product(cost, a)
    cross = product(b.transposed, after)
    weight = product(b.transposed, product(cost, b)) + torque_weight
    gain = exactly(np.asarray(np.linalg.solve(weight.high, cross.high), np.float64))
    for _ in range(GAIN_CORRECTIONS):
        defect = cross - product(weight, gain)
        gain = gain + np.asarray(np.linalg.solve(weight.high, defect.high), np.float64)
    return after, cross, gain
