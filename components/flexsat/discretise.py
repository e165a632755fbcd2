"""Exact sampling of linear systems whose inputs are held. numpy alone: FMUs resample when a parameter changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TAYLOR_TERMS = 18  # with the norm scaled below 1/2 the remainder is under 2^-18/18! < 1e-21


def matrix_exponential(matrix: Array) -> Array:
    """Return exp(matrix), (n, n), by scaling, a Taylor polynomial and squaring.

    The plant and the controller need it at run time, where scipy is not available; the test compares it with
    scipy's. Relative error a few units of rounding times the number of squarings.
    """
    norm = float(np.linalg.norm(matrix, 1))
    squarings = max(0, int(np.ceil(np.log2(norm))) + 1) if norm > 0.0 else 0
    scaled = matrix / 2.0**squarings
    term = np.eye(len(matrix))
    result = term.copy()
    for k in range(1, TAYLOR_TERMS + 1):
        term = term @ scaled / k
        result += term
    for _ in range(squarings):
        result = result @ result
    return result


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
    Van Loan (1978), IEEE Trans. Automatic Control 23(3), 395-404.
    """
    n, m = b.shape
    if a.shape != (n, n):
        raise ValueError(f"zero_order_hold: a must be ({n}, {n}) to match b {b.shape}, got {a.shape}")
    if not period > 0.0:
        raise ValueError(f"zero_order_hold: period must be > 0 s, got {period!r}")
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = a, b
    sampled = matrix_exponential(period * block)
    return sampled[:n, :n], sampled[:n, n:]
