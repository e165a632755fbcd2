"""What C computes in the widest registers of a processor: numpy's values, and the same bits in narrow ones."""

import ctypes
import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fmus.native.twin import compile_library, sources_of

PROGRAM = """
#include "element_products.h"
#include "sines.h"

void turn(int quickest, int n, const double *angle, double *sine, double *cosine);
void multiply(int quickest, int n, const double *a, const double *b, double *result);

void turn(int quickest, int n, const double *angle, double *sine, double *cosine)
{
    (quickest ? quickest_sines() : sines_one_by_one)(n, angle, sine, cosine);
}

void multiply(int quickest, int n, const double *a, const double *b, double *result)
{
    (quickest ? quickest_two_products() : two_products)(n, a, b, a + n, b + n, result);
}
"""
LARGEST = 1e8  # rad; the C library's functions are called beyond


@pytest.fixture(scope="module")
def library(once):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")

    def make(folder):
        folder.mkdir()
        (folder / "products.c").write_text(PROGRAM, encoding="utf-8")
        sources = {*sources_of("sines"), *sources_of("element_products")}
        compile_library([*sorted(sources), folder / "products.c"], folder / "products.so")

    return ctypes.CDLL(str(once("native-wide-registers", make) / "products.so"))


def pointers(*arrays):
    return [ctypes.c_void_p(array.ctypes.data) for array in arrays]


def turned(library, quickest, angle):
    sine, cosine = np.empty((2, len(angle)))
    library.turn(int(quickest), len(angle), *pointers(angle, sine, cosine))
    return sine, cosine


@pytest.mark.parametrize("size", [1.0, 1e3, LARGEST, 1e12])
def test_sines_are_exact_to_rounding_and_the_same_bits_in_narrow_registers(library, size):
    random = np.random.default_rng(1)
    quarters = np.round(random.uniform(-size, size, 500)) * (np.pi / 2.0)
    angle = np.concatenate([random.uniform(-size, size, 5000), quarters, np.nextafter(quarters, 0.0), [0.0, -0.0]])
    sine, cosine = turned(library, True, angle)
    # rounding of the sum at most of 1, and of the rest of the angle, which is below 1
    assert_allclose(sine, np.sin(angle), rtol=0.0, atol=2.3e-16)
    assert_allclose(cosine, np.cos(angle), rtol=0.0, atol=2.3e-16)
    assert_array_equal(turned(library, False, angle), (sine, cosine))


def test_sines_of_what_is_no_number_are_none(library):
    angle = np.array([np.nan, 1.0, np.inf, -np.inf, 0.5, 2e8])
    for quickest in (True, False):
        sine, cosine = turned(library, quickest, angle)
        assert_array_equal(np.isnan(sine), [True, False, True, True, False, False])
        assert_array_equal(np.isnan(cosine), np.isnan(sine))


@pytest.mark.parametrize("n", [0, 1, 4, 7, 33])
def test_two_products_are_rounded_one_by_one(library, n):
    a, b = np.random.default_rng(n).standard_normal((2, 2, n))
    for quickest in (True, False):
        result = np.full(n + 1, 7.0)
        library.multiply(int(quickest), n, *pointers(a, b, result))
        assert_array_equal(result, [*(a[0] * b[0] + a[1] * b[1]), 7.0])  # numpy rounds each product too
