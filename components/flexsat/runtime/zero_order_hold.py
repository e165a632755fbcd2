"""Exact sampling of linear systems whose inputs are held. numpy alone: FMUs resample when a parameter changes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array, Index
from ..fixed_order import product

TAYLOR_TERMS = 18  # with the norm scaled below 1/2 the remainder is under 2^-18/18! < 1e-21
SMALL = 32  # states that are sampled together although they do not act on each other: tiny products take as long


def transition(a: Array, period: float) -> tuple[Array, Array]:
    """Return exp(a t) at t = period and its integral from 0 to the period, (n, n) each.

    By scaling, Taylor polynomials, and squaring: both double together. The plant and the controller need it at run
    time, where scipy is not available; the test compares it with scipy's exponential of the augmented matrix,
    which is slower, as that matrix is larger than a. Relative error: a few units of rounding times the number of
    squarings. States that do not act on each other are sampled apart, to the same bits: the other terms are zeros.
    """
    count = _squarings(a, period)
    exponential, integral = _in_groups(a, lambda part: _sampled(part, period, count))
    return exponential, integral


def transition_and_half(a: Array, period: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the transition over a period and that over half of it: the first is the square of the second.

    Both have the bits of `transition`, of whose last squaring they are the two sides.
    """
    count, count_of_half = _squarings(a, period), _squarings(a, 0.5 * period)

    def sampled(part: Array) -> tuple[Array, ...]:
        half = _sampled(part, 0.5 * period, count_of_half)
        whole = _doubled(*half) if count else _sampled(part, period, 0)  # without squarings both are polynomials
        return (*whole, *half)

    exponential, integral, half_exponential, half_integral = _in_groups(a, sampled)
    return (exponential, integral), (half_exponential, half_integral)


def _squarings(a: Array, period: float) -> int:
    norm = period * float(np.linalg.norm(a, 1))
    return max(0, int(np.ceil(np.log2(norm))) + 1) if norm > 0.0 else 0


def _sampled(a: Array, period: float, squarings: int) -> tuple[Array, Array]:
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


def _doubled(exponential: Array, integral: Array) -> tuple[Array, Array]:
    return product(exponential, exponential), integral + product(exponential, integral)


def _in_groups(a: Array, sample: Callable[[Array], tuple[Array, ...]]) -> list[Array]:
    """Return the matrices of all states from those that `sample` gives for groups that do not act on each other."""
    if len(a) <= SMALL or len(groups := _groups(a)) == 1:
        return list(sample(a))
    parts = [sample(a[np.ix_(group, group)]) for group in groups]
    whole = [np.zeros_like(a) for _ in parts[0]]
    for group, matrices in zip(groups, parts, strict=True):
        for target, matrix in zip(whole, matrices, strict=True):
            target[np.ix_(group, group)] = matrix
    return whole


def _groups(a: Array) -> list[Index]:
    """Return the states in groups; those that act on each other in ascending order, in which products add terms."""
    linked = (a != 0.0) | (a.T != 0.0) | np.eye(len(a), dtype=bool)
    first, before = np.arange(len(a)), np.full(len(a), -1)  # the first state that each is linked with
    while not np.array_equal(first, before):
        before = first
        first = np.where(linked, first, len(a)).min(axis=1)
        first = first[first]
    groups, few = [], np.zeros(0, dtype=np.intp)
    for name in np.unique(first):
        members = np.flatnonzero(first == name)
        if len(members) < SMALL:
            few = members = np.concatenate([few, members])
        if len(members) >= SMALL:
            groups.append(members)
            few = few[:0] if members is few else few
    return [*groups, few] if len(few) else groups


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
