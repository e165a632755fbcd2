"""Double-double arithmetic against exact fractions."""

from fractions import Fraction

import numpy as np

from flexsat.double_double import Pair, column_dots, exactly, product, sparse_product

RNG = np.random.default_rng(3)
ACCURACY = Fraction(1, 10**30)  # of the sum of magnitudes: some units of 2^-105


def pair(*shape):
    """Return random pairs with numbers over ten orders of magnitude."""
    high = RNG.standard_normal(shape) * 10.0 ** RNG.uniform(-5, 5, shape)
    return Pair(high, high * RNG.uniform(-1.0, 1.0, shape) * 2.0**-54)


def exact(value, *place):
    return Fraction(float(value.high[place])) + Fraction(float(value.low[place]))


def is_near(found, terms):
    return abs(found - sum(terms)) <= ACCURACY * sum(map(abs, terms))


def test_sums_and_differences():
    a, b = pair(50), pair(50)
    even = np.arange(50) % 2 == 0  # these cancel to 1e-14
    b = Pair(np.where(even, -a.high * (1.0 + 1e-14), b.high), np.where(even, 0.3 * a.low, b.low))
    for k in range(50):
        assert is_near(exact(a + b, k), [exact(a, k), exact(b, k)])
        assert is_near(exact(a - b, k), [exact(a, k), -exact(b, k)])
        assert is_near(exact(a + b.high, k), [exact(a, k), Fraction(float(b.high[k]))])
        assert is_near(exact(a.times(b.high), k), [exact(a, k) * Fraction(float(b.high[k]))])


def test_products_of_matrices():
    a, b = pair(4, 9), pair(9, 3)
    found = product(a, b)
    for i in range(4):
        for j in range(3):
            assert is_near(exact(found, i, j), [exact(a, i, k) * exact(b, k, j) for k in range(9)])
    assert np.all(np.abs(found.low) <= np.spacing(np.abs(found.high)))


def test_products_with_few_nonzeros_in_a_row():
    dense = RNG.standard_normal((6, 9)) * (RNG.uniform(size=(6, 9)) < 0.4)
    dense[2] = 0.0
    b = pair(9, 3)
    expected, found = product(exactly(dense), b), sparse_product(dense, b)
    assert np.array_equal(found.high, expected.high)
    assert np.array_equal(found.high[2], np.zeros(3))
    for i in range(6):
        terms = [Fraction(float(dense[i, k])) * exact(b, k, 1) for k in range(9)]
        assert is_near(exact(found, i, 1), terms)


def test_scalar_products_of_columns():
    for rows in (1, 2, 7, 16):
        a, b = pair(rows, 3), pair(rows, 3)
        found = column_dots(a, b)
        for j in range(3):
            assert is_near(exact(found, j), [exact(a, k, j) * exact(b, k, j) for k in range(rows)])
