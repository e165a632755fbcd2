"""Solve the periodic Riccati recursion of the Kalman filter by composing its steps and doubling.

The filter's gain repeats every 20 steps, with the star tracker in one of them, and solvers of algebraic Riccati
equations take one constant step only. Here a step of the recursion

    P -> g + a P (I + h P)^-1 a^T

is kept as the triple (a, g, h). Two steps compose to one of the same form, so that k doublings take 2^k steps, and a
recursion that is periodic over many steps is first composed over one period. g and h stay symmetric and positive
semidefinite throughout.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import groupby

import numpy as np

from ..arrays import Array
from ..fixed_order import product, solve, symmetric

MOST_DOUBLINGS = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class RiccatiStep:
    """One step, or several composed, of a Riccati recursion; each (n, n)."""

    a: Array
    g: Array
    h: Array

    def apply(self, p: Array) -> Array:
        """Return the next P."""
        inner = solve((np.eye(len(p)) + product(self.h, p)).T, p.T).T
        return symmetric(self.g + product(product(self.a, inner), self.a.T))

    def then(self, later: RiccatiStep) -> RiccatiStep:
        """Return the step that does this one and then `later`. Source: Chu et al. (2005), IJC 77(8), eq. (2.9)."""
        solved = solve(np.eye(len(self.a)) + product(self.g, later.h), np.hstack([self.a, self.g]))
        across, spread = solved[:, : len(self.a)], solved[:, len(self.a) :]
        return RiccatiStep(
            a=product(later.a, across),
            g=symmetric(later.g + product(product(later.a, spread), later.a.T)),
            h=symmetric(self.h + product(product(self.a.T, later.h), across)),
        )


def _repeated(step: RiccatiStep, count: int) -> RiccatiStep:
    """Return the step done `count` times, by squaring."""
    if count == 1:
        return step
    half = _repeated(step, count // 2)
    twice = half.then(half)
    return twice.then(step) if count % 2 else twice


def steady_state(steps: list[RiccatiStep], tolerance: float = 1e-12) -> Array:
    """Return the P that a periodic recursion repeats, taken before the first of `steps`.

    Parameters
    ----------
    steps : the steps of one period, in order
    tolerance : relative change over a doubling at which to stop

    Raises
    ------
    ValueError
        If it has not settled after 60 doublings: the pair is not stabilisable or not detectable.
    """
    alike = [list(group) for _, group in groupby(steps, key=id)]
    period = reduce(RiccatiStep.then, (_repeated(group[0], len(group)) for group in alike))
    for _ in range(MOST_DOUBLINGS):
        doubled = period.then(period)
        change = float(np.max(np.abs(doubled.g - period.g)) / np.max(np.abs(doubled.g)))
        period = doubled
        if change < tolerance:
            return period.g
    raise ValueError(
        f"steady_state: relative change still {change:.1e} after {MOST_DOUBLINGS} doublings;"
        " the pair is not stabilisable or not detectable"
    )
