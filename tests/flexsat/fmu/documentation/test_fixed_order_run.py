"""Arrays that multiply in a fixed order give the products of numpy, keep their type, and fill the given array."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.arrays import Array, make_read_only
from flexsat.fmu.documentation.fixed_order_run import FixedOrderArray, use_fixed_order

RNG = np.random.default_rng(2)
SHAPES = [((4,), (4,)), ((3, 4), (4,)), ((4,), (4, 5)), ((3, 4), (4, 5)), ((2, 3, 4), (4,)), ((2, 3, 4), (2, 4, 5))]


@pytest.mark.parametrize("shapes", SHAPES, ids=str)
def test_products_of_all_shapes(shapes):
    a, b = (RNG.standard_normal(shape) for shape in shapes)
    for found in (a.view(FixedOrderArray) @ b, a @ b.view(FixedOrderArray)):
        assert np.shape(found) == np.shape(a @ b)
        assert_allclose(np.asarray(found), a @ b, atol=1e-14)
        assert np.ndim(found) == 0 or isinstance(found, FixedOrderArray)


def test_the_order_of_a_sum_is_that_of_its_terms_alone():
    """Terms that cancel show the order; BLAS takes another one for a vector, a column and a row of a matrix."""
    terms = RNG.standard_normal(301) * 10.0 ** RNG.uniform(0, 12, 301)
    row, ones = terms.view(FixedOrderArray), np.ones(301)
    one, column = row @ ones, row[None] @ np.ones((301, 1))
    wide = np.vstack([row] * 7).view(FixedOrderArray) @ ones
    rows = np.vstack([row] * 7).view(FixedOrderArray).dot(ones)
    assert {float(x) for x in (*np.ravel(column), *wide, *rows)} == {float(column[0, 0])}
    assert abs(float(one) - float(column[0, 0])) < 1e-12 * np.abs(terms).sum()


def test_results_are_written_to_the_given_array():
    matrix, vector, out = RNG.standard_normal((3, 4)).view(FixedOrderArray), RNG.standard_normal(4), np.empty(3)
    assert np.matmul(matrix, vector, out=out) is out
    assert_allclose(out, np.asarray(matrix) @ vector, atol=1e-14)
    assert matrix.dot(vector, out=np.empty(3)).tobytes() == out.tobytes()
    assert np.multiply(matrix[0], 2.0, out=vector) is vector
    assert np.array_equal(vector, 2.0 * np.asarray(matrix[0]))
    matrix *= 2.0
    assert isinstance(matrix, FixedOrderArray)


def test_sines_are_rounded_from_extended_precision():
    angles = RNG.uniform(-100.0, 100.0, 1000)
    for function in (np.sin, np.cos):
        found = np.asarray(function(angles.view(FixedOrderArray)))
        assert np.array_equal(found, function(angles.astype(np.longdouble)).astype(np.float64))
        assert_allclose(found, function(angles), rtol=0.0, atol=2e-16)


def test_all_that_a_component_prepares_and_shows_is_replaced():
    @dataclass(frozen=True, kw_only=True)
    class Inner:
        weights: Array

        def __post_init__(self) -> None:
            make_read_only(self)

    @dataclass(frozen=True, kw_only=True)
    class Outer:
        count: int
        matrix: Array
        inner: Inner

        def __post_init__(self) -> None:
            make_read_only(self)

    class Slave:
        def __init__(self) -> None:
            self.values = np.zeros(2)

        def view(self, _name: str) -> Array:
            return self.values

        def in_use(self, prepared: Outer) -> Outer:
            return prepared

    slave = Slave()
    use_fixed_order(slave)
    prepared = slave.in_use(Outer(count=1, matrix=np.eye(2), inner=Inner(weights=np.ones(3))))

    assert isinstance(prepared.matrix, FixedOrderArray)
    assert isinstance(prepared.inner.weights, FixedOrderArray)
    assert not prepared.matrix.flags.writeable
    assert isinstance(slave.view("any"), FixedOrderArray)
    slave.view("any")[0] = 3.0
    assert slave.values[0] == 3.0
