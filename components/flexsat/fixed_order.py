"""Linear algebra with a fixed order of operations: the same bits on every processor, with any BLAS and thread count.

The sums inside a BLAS are ordered as suits the processor. Here products are summed by the loops of `numpy.einsum`,
which call no BLAS and are compiled once for all processors, and the rest is elementwise, where IEEE 754 rounds in one
way. A design is computed with these, and a run is prepared; its steps use BLAS.
"""

from __future__ import annotations

import numpy as np

from .arrays import Array

BLOCK = 16  # rows that are eliminated one by one, before the rest is updated by one product


def product(a: Array, b: Array) -> Array:
    """Return the product of a matrix, (n, k), with a matrix, (k, m), or a vector, (k,)."""
    summed = "ij,jk->ik" if b.ndim == 2 else "ij,j->i"
    return np.asarray(np.einsum(summed, np.ascontiguousarray(a), np.ascontiguousarray(b), optimize=False))


def solve(a: Array, b: Array) -> Array:
    """Return x of a x = b, (n, n) and (n, m), by elimination with row pivots, in blocks.

    Raises
    ------
    numpy.linalg.LinAlgError
        If a is singular.
    """
    size = len(a)
    work = np.hstack([a, b])
    blocks = [slice(start, min(start + BLOCK, size)) for start in range(0, size, BLOCK)]
    for block in blocks:
        for k in range(block.start, block.stop):
            _eliminate(work, k, block.stop)
        for k in range(block.start, block.stop - 1):
            rows = slice(k + 1, block.stop)
            work[rows, block.stop :] -= work[rows, k, None] * work[k, block.stop :]
        work[block.stop :, block.stop :] -= product(work[block.stop :, block], work[block, block.stop :])
    x = work[:, size:].copy()
    for block in reversed(blocks):
        for k in reversed(range(block.start, block.stop)):
            x[k] /= work[k, k]
            x[block.start : k] -= work[block.start : k, k, None] * x[k]
        x[: block.start] -= product(work[: block.start, block], x[block])
    return x


def _eliminate(work: Array, k: int, stop: int) -> None:
    """Move the row with the largest number of column k to row k; clear the column below, in the columns up to `stop`.

    The factors stand in the cleared places.
    """
    pivot = k + int(np.abs(work[k:, k]).argmax())
    if pivot != k:
        work[[k, pivot]] = work[[pivot, k]]
    if work[k, k] == 0.0:
        raise np.linalg.LinAlgError("Singular matrix")
    work[k + 1 :, k] /= work[k, k]
    work[k + 1 :, k + 1 : stop] -= work[k + 1 :, k, None] * work[k, k + 1 : stop]


def inverse(a: Array) -> Array:
    """Return the inverse, (n, n); raise numpy.linalg.LinAlgError for a singular matrix."""
    return solve(a, np.eye(len(a)))


def complement(columns: Array) -> Array:
    """Return an orthonormal basis, (n, n - k), of what is orthogonal to k independent columns, (n, k).

    By reflections that turn the columns into the first axes one after the other (Householder).
    """
    size, count = columns.shape
    work, basis = columns.copy(), np.eye(size)
    for k in range(count):
        normal = np.zeros((size, 1))
        normal[k:, 0] = work[k:, k]
        length = np.sqrt(_dot(normal, normal))
        if length == 0.0:
            raise np.linalg.LinAlgError("the columns are not independent")
        normal[k] += np.copysign(length, work[k, k])
        scale = 2.0 / _dot(normal, normal)
        work -= normal * (scale * product(normal.T, work))
        basis -= product(basis, normal) * (scale * normal.T)
    return basis[:, count:]


def _dot(a: Array, b: Array) -> float:
    return float(product(a.T, b)[0, 0])


def on_grid(values: Array, bits: int = 40) -> Array:
    """Return values rounded to a grid of 2^-bits of the power of two above the largest of each column.

    What remains of numbers that are zero but for rounding becomes zero.
    """
    _, exponent = np.frexp(np.max(np.abs(values), axis=0))
    rounded = np.rint(np.ldexp(values, bits - exponent)) + 0.0  # zeros have no sign
    return np.asarray(np.ldexp(rounded, exponent - bits))


def symmetric(matrix: Array) -> Array:
    """Return the symmetric part of a matrix, (n, n)."""
    return np.asarray(0.5 * (matrix + matrix.T))
