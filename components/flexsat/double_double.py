"""Arithmetic with about 32 digits: a number is the unevaluated sum of two doubles. Elementwise, thus the same anywhere.

Library solvers leave errors that depend on the processor, far above rounding where a problem is ill-conditioned.
Corrected with residuals of this precision, their results agree to many digits more than are kept.
Source: Dekker (1971), Numerische Mathematik 18, 224-242.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array

_SPLITTER = 2.0**27 + 1.0


@dataclass(frozen=True, slots=True)
class Pair:
    """The sum of a leading and a trailing array; this is at most half a unit of the leading one's last place."""

    high: Array
    low: Array

    @property
    def transposed(self) -> Pair:
        """Both parts transposed."""
        return Pair(self.high.T, self.low.T)

    def __neg__(self) -> Pair:
        return Pair(-self.high, -self.low)

    def __add__(self, other: Pair | Array) -> Pair:
        high, low = (other.high, other.low) if isinstance(other, Pair) else (other, 0.0)
        total, error = _sum(self.high, high)
        return _normalised(total, error + (self.low + low))

    def __sub__(self, other: Pair) -> Pair:
        return self + -other

    def times(self, factor: Array) -> Pair:
        """Return the elementwise product with plain doubles."""
        high, low = _split_product(self.high, factor)
        return _normalised(high, low + self.low * factor)


def exactly(values: Array) -> Pair:
    """Return doubles as pairs."""
    return Pair(values, np.zeros_like(values))


def product(a: Pair, b: Pair) -> Pair:
    """Return the matrix product, (n, k) times (k, m)."""
    shape = (len(a.high), b.high.shape[1])
    total, rest = np.zeros(shape), np.zeros(shape)
    upper, lower = _split(a.high)
    upper_b, lower_b = _split(b.high)
    for k in range(len(b.high)):
        left, right = a.high[:, k, None], b.high[k]
        term = left * right
        one, two, three, four = upper[:, k, None], lower[:, k, None], upper_b[k], lower_b[k]
        error = ((one * three - term) + one * four + two * three) + two * four
        total, lost = _sum(total, term)
        rest += error + lost + (left * b.low[k] + a.low[:, k, None] * right)
    return _normalised(total, rest)


def sparse_product(a: Array, x: Pair) -> Pair:
    """Return the matrix product of plain doubles with few nonzeros a row, (n, k), and a pair, (k, m)."""
    width = int(np.max(np.count_nonzero(a, axis=1), initial=1))
    columns = np.argsort(a == 0.0, axis=1, kind="stable")[:, :width]  # those of the nonzeros first
    values = np.take_along_axis(a, columns, axis=1)
    shape = (len(a), x.high.shape[1])
    total, rest = np.zeros(shape), np.zeros(shape)
    for k in range(width):
        factor, column = values[:, k, None], columns[:, k]
        term, error = _split_product(x.high[column], factor)
        total, lost = _sum(total, term)
        rest += error + lost + factor * x.low[column]
    return _normalised(total, rest)


def column_dots(a: Pair, b: Pair) -> Pair:
    """Return the scalar product of each column of a with the same column of b, (m,)."""
    high, low = _split_product(a.high, b.high)
    low += a.high * b.low + a.low * b.high
    while len(high) > 1:
        half, odd = len(high) // 2, len(high) % 2
        total, lost = _sum(high[odd : odd + half], high[odd + half :])
        rest = (low[odd : odd + half] + low[odd + half :]) + lost
        high, low = np.concatenate([high[:odd], total]), np.concatenate([low[:odd], rest])
    return _normalised(high[0], low[0])


def _sum(a: Array, b: Array | float) -> tuple[Array, Array]:
    """Return a + b, and what rounding lost. Source: Knuth, The Art of Computer Programming 2, 4.2.2, theorem B."""
    total = a + b
    second = total - a
    return total, (a - (total - second)) + (b - second)


def _split(a: Array) -> tuple[Array, Array]:
    """Return the upper and the lower half of the digits of a."""
    scaled = _SPLITTER * a
    upper = scaled - (scaled - a)
    return upper, a - upper


def _split_product(a: Array, b: Array) -> tuple[Array, Array]:
    """Return a b elementwise, and what rounding lost."""
    result = a * b
    (one, two), (three, four) = _split(a), _split(b)
    return result, ((one * three - result) + one * four + two * three) + two * four


def _normalised(high: Array, low: Array) -> Pair:
    total = high + low
    return Pair(total, low - (total - high))
