"""Products of arranged matrices in C: numpy's, and the same bits however a processor adds."""

import ctypes
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fmus.native.twin import compile_library, sources_of

PROGRAM = """
#include <stdlib.h>
#include "panel_products.h"
#include "wide_registers.h"

int wide_registers(void);
int multiply(int quickest, int rows, int columns, const double *a, const double *x, double *dense, double *sparse);

int wide_registers(void) { return has_wide_registers(); }

int multiply(int quickest, int rows, int columns, const double *a, const double *x, double *dense, double *sparse)
{
    Memory memory = {calloc, free, NULL, 0};
    Panels panels;
    Sparse elements;

    if (panels_take(&memory, rows, columns, &panels) || sparse_of(&memory, rows, columns, a, &elements))
        return 1;
    if (!quickest) {
        panels.product = panel_product;
        panels.products = panel_products;
    }
    panels_fill(a, &panels);
    panels_add_times(&panels, x, dense);
    panels.products(&panels, x + columns, x, dense + rows, dense + 2 * rows);
    sparse_times(&elements, x, sparse);
    memory_release(&memory);
    return 0;
}
"""


@pytest.fixture(scope="module")
def libraries(once):
    """Return the library with two or four sums at once, and that with one."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")

    def make(folder):
        folder.mkdir()
        (folder / "multiply.c").write_text(PROGRAM, encoding="utf-8")
        sources = [*sources_of("panel_products"), folder / "multiply.c"]
        compile_library(sources, folder / "two.so")
        compile_library(sources, folder / "one.so", ["-U__SSE2__"])

    folder = once("native-panels", make)
    return [ctypes.CDLL(str(folder / name)) for name in ("two.so", "one.so")]


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (7, 3), (8, 8), (20, 33), (65, 40), (24, 90)])
def test_products(libraries, rows, columns):
    random = np.random.default_rng(rows)
    a = random.standard_normal((rows, columns)) * (random.uniform(size=(rows, columns)) < 0.3)
    a[rows // 2 : rows // 2 + 3] = 0.0
    a[:, : columns // 3] = 0.0
    a[:8, columns // 2 : columns // 2 + 6] = 0.0  # a gap between two runs
    x, before = random.standard_normal((2, columns)), random.standard_normal(rows)
    found = []
    for library, quickest in ((libraries[0], True), (libraries[0], False), (libraries[1], False)):
        dense, sparse = np.tile(before, (3, 1)), before.copy()
        pointers = (ctypes.c_void_p(array.ctypes.data) for array in (a, x, dense, sparse))
        assert library.multiply(quickest, rows, columns, *pointers) == 0
        assert_allclose(dense[:2], before + x @ a.T, rtol=1e-13, atol=1e-14)
        assert_array_equal(dense[2], dense[0])
        assert_allclose(sparse, a @ x[0], rtol=1e-13, atol=1e-14)
        found.append(dense)
    assert_array_equal(found[0], found[1])
    assert_array_equal(found[0], found[2])


def test_the_widest_registers_are_used_where_there_are_any(libraries):
    flags = re.findall(r"^flags\s*:.*$", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    assert libraries[0].wide_registers() == int(bool(flags) and "avx2" in flags[0].split())
    assert libraries[1].wide_registers() == 0
