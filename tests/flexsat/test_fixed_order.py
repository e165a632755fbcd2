"""Products and linear systems in a fixed order are those of numpy's, but for rounding."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.fixed_order import BLOCK, complement, inverse, on_grid, product, solve

RNG = np.random.default_rng(5)
FEW_ULP = 1e-13  # sums of up to 40 terms


def test_products_with_matrices_and_vectors():
    a, b = RNG.standard_normal((7, 40)), RNG.standard_normal((40, 5))

    assert_allclose(product(a, b), a @ b, atol=FEW_ULP)
    assert_allclose(product(b.T, a.T), (a @ b).T, atol=FEW_ULP)
    assert_allclose(product(a, b[:, 1]), a @ b[:, 1], atol=FEW_ULP)
    # the memory layout does not decide the order
    assert np.array_equal(product(np.asfortranarray(a), np.asfortranarray(b)), product(a, b))


@pytest.mark.parametrize("size", [1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 3])
def test_linear_systems_of_sizes_around_the_block(size):
    a, b = RNG.standard_normal((size, size)), RNG.standard_normal((size, 3))
    before = a.copy(), b.copy()

    x = solve(a, b)

    # backward stable: the residual is rounding, whatever the condition
    assert np.abs(a @ x - b).max() < 1e-14 * size * max(1.0, np.abs(a).max() * np.abs(x).max())
    assert_allclose(inverse(a) @ a, np.eye(size), atol=1e-15 * size * np.linalg.cond(a))
    assert np.array_equal(a, before[0])
    assert np.array_equal(b, before[1])


def test_pivots_are_searched_below_the_diagonal():
    assert_allclose(solve(np.array([[0.0, 2.0], [1.0, 1.0]]), np.array([[4.0], [3.0]])), [[1.0], [2.0]], rtol=1e-15)
    with pytest.raises(np.linalg.LinAlgError, match="Singular"):
        solve(np.array([[1.0, 2.0], [2.0, 4.0]]), np.eye(2))


def test_the_complement_is_orthonormal_and_orthogonal_to_the_columns():
    columns = RNG.standard_normal((9, 3))

    basis = complement(columns)

    assert_allclose(basis.T @ basis, np.eye(6), atol=FEW_ULP)
    assert_allclose(columns.T @ basis, 0.0, atol=FEW_ULP)
    with pytest.raises(np.linalg.LinAlgError, match="not independent"):
        complement(np.zeros((4, 2)))


def test_grid_of_each_column():
    values = np.array([[3.0, -1e-6], [-0.1, 0.0], [1e-16, 1e-22]])
    rounded = on_grid(values)

    # 2^-40 of the power of two above the largest, half a step at most
    assert np.all(np.abs(rounded - values).max(axis=0) <= np.array([4.0, 2.0**-19]) * 2.0**-41)
    assert np.array_equal(rounded[2], [0.0, 0.0])
    assert not np.signbit(on_grid(np.array([[1.0], [-1e-20]]))[1, 0])  # zeros are alike in every bit
    assert np.array_equal(on_grid(rounded), rounded)
    assert np.array_equal(on_grid(-values) + 0.0, -rounded + 0.0)
