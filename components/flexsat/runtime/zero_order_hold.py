"""Exact sampling of linear systems whose inputs are held. numpy alone: FMUs resample when a parameter changes."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..fixed_order import product

TAYLOR_TERMS = 18  # with the norm scaled below 1/2 the remainder is under 2^-18/18! < 1e-21


def transition(a: Array, period: float) -> tuple[Array, Array]:
    """Return exp(a t) at t = period and its integral from 0 to the period, (n, n) each.

    By scaling, Taylor polynomials, and squaring: both double together. The plant and the controller need it at run
    time, where scipy is not available; the test compares it with scipy's exponential of the augmented matrix,
    which is slower, as that matrix is larger than a. Relative error: a few units of rounding times the number of
    squarings.
    """
    norm = period * float(np.linalg.norm(a, 1))
    squarings = max(0, int(np.ceil(np.log2(norm))) + 1) if norm > 0.0 else 0
    step = period / 2.0**squarings
    scaled = step * a
    term = np.eye(len(a))
    exponential, integral = term.copy(), term.copy()
    for k in range(1, TAYLOR_TERMS + 1):
        term = product(term, scaled) / k
        exponential += term
        integral += term / (k + 1)
    integral *= step
    for _ in range(squarings):
        exponential, integral = _doubled(exponential, integral)
    return exponential, integral


def transition_and_half(a: Array, period: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the transition over a period and that over half of it: the first is the square of the second.

    Both have the bits of `transition`, of whose last squaring they are the two sides.
    """
    half = transition(a, 0.5 * period)
    squared = 0.5 * period * float(np.linalg.norm(a, 1)) > 0.25  # otherwise both are polynomials
    return _doubled(*half) if squared else transition(a, period), half


def _doubled(exponential: Array, integral: Array) -> tuple[Array, Array]:
    return product(exponential, exponential), integral + product(exponential, integral)


def matrix_exponential(matrix: Array) -> Array:
    """Return exp(matrix), (n, n)."""
    return transition(matrix, 1.0)[0]


def zero_order_hold(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    """Sample dx/dt = a x + b u, with u held over each period.

    Parameters
    ----------
    a : (n, n) [1/s in the states' units]
    b : (n, m)
    period : [s]

    Returns
    -------
    ad, bd : (n, n), (n, m)
        x[k+1] = ad @ x[k] + bd @ u[k]. No truncation error; rounding only.

    Raises
    ------
    ValueError
        If the shapes disagree or period is not positive.

    References
    ----------
    Van Loan (1978), IEEE Trans. Automatic Control 23(3), 395-404, whose augmented exponential this equals.
    """
    n = len(b)
    if a.shape != (n, n):
        raise ValueError(f"zero_order_hold: a must be ({n}, {n}) to match b {b.shape}, got {a.shape}")
    if not period > 0.0:
        raise ValueError(f"zero_order_hold: period must be > 0 s, got {period!r}")
    exponential, integral = transition(a, period)
    return exponential, product(integral, b)
