"""Refine eigenpairs of a stiffness and a mass matrix until they are the same with any library.

Where stiffnesses span many orders of magnitude, eigenvectors of LAPACK agree between two processors to 9 digits. A few
Newton corrections with residuals in double-double arithmetic leave 1e-25: rounded to doubles they are the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..double_double import Pair, column_dots, exactly, sparse_product

CORRECTIONS = 4  # each multiplies the error by that of LAPACK's eigenvectors: 1e-8, more where frequencies lie close


@dataclass(frozen=True, slots=True)
class Eigenpairs:
    """All eigenvalues and mass-normalised eigenvectors of a problem, as a library gives them."""

    values: Array  # (n,)
    vectors: Array  # (n, n)


def refine(
    stiffness: Array, mass: Array, found: Eigenpairs, vectors: Array, pairs: dict[int, Array], first_mode: int = 0
) -> tuple[Array, Array]:
    """Return eigenvalues, (m,), and their vectors, (n, m), corrected and rounded to doubles.

    Parameters
    ----------
    stiffness, mass : (n, n), symmetric
    found : all eigenpairs, which the corrections are made of
    vectors : (n, m): the ones to refine, with each degenerate pair whole, and turned as it is to be
    pairs : the first index of each degenerate pair among these, and the row (n,) whose product with the second is zero
    first_mode : number of the first of them among all
    """
    count = vectors.shape[1]
    x = exactly(vectors)
    partner = np.arange(count)
    for first in pairs:
        partner[first], partner[first + 1] = first + 1, first
    own = np.arange(count)
    for _ in range(CORRECTIONS):
        forces, momenta = sparse_product(stiffness, x), sparse_product(mass, x)
        norms = column_dots(x, momenta)
        values = column_dots(x, forces).high / norms.high
        residual = (forces - momenta.times(values)).high
        shares = found.vectors.T @ residual
        gaps = values - found.values[:, None]
        gaps[first_mode + own, own] = gaps[first_mode + partner, own] = np.inf
        shares /= gaps
        change = found.vectors @ shares - x.high * (0.5 * (norms - exactly(np.ones(count))).high)
        crossed = column_dots(Pair(x.high[:, partner], x.low[:, partner]), momenta).high
        for first in pairs:
            change[:, [first, first + 1]] -= 0.5 * crossed[first] * x.high[:, [first + 1, first]]
        x = x + change
        for first, row in pairs.items():
            x = _turned(x, first, row)
    forces, momenta = sparse_product(stiffness, x), sparse_product(mass, x)
    return column_dots(x, forces).high / column_dots(x, momenta).high, x.high


def _turned(x: Pair, first: int, row: Array) -> Pair:
    """Return the vectors with a pair turned by the small angle after which the row does not see the second one."""
    seen = column_dots(
        exactly(np.repeat(row[:, None], 2, axis=1)), Pair(x.high[:, first : first + 2], x.low[:, first : first + 2])
    )
    angle = seen.high[1] / seen.high[0]
    change = np.zeros_like(x.high)
    change[:, first], change[:, first + 1] = angle * x.high[:, first + 1], -angle * x.high[:, first]
    return x + change
