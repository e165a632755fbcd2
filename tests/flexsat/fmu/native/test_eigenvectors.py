"""Eigenvalues and eigenvectors in C against their definition, and against numpy's."""

import ctypes
import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fmus.native.twin import compile_library, sources_of

ROUNDING = 1e-13  # of 100 rows: each of some hundred reflections errs by 1e-16 of the largest element


@pytest.fixture(scope="module")
def library(once):
    """Return the compiled functions."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")

    def make(folder):
        folder.mkdir()
        compile_library(sources_of("eigenvectors"), folder / "eigenvectors.so", ["-O1"])

    return ctypes.CDLL(str(once("native-eigenvectors", make) / "eigenvectors.so"))


def eigen(library, matrix):
    """Return eigenvalues and eigenvectors, as numpy does."""
    n = len(matrix)
    lost = np.array(matrix, dtype=float)
    real, imaginary, rows, work = np.zeros(n), np.zeros(n), np.zeros((n, n)), np.zeros(n * (n + 2))
    arrays = (ctypes.c_void_p(array.ctypes.data) for array in (lost, real, imaginary, rows, work))
    assert library.eigenvectors(n, *arrays) == 0
    vectors = np.zeros((n, n), dtype=complex)
    for k in range(n):
        if imaginary[k] > 0.0:
            vectors[:, k] = rows[k] + 1j * rows[k + 1]
        else:
            vectors[:, k] = rows[k] if imaginary[k] == 0.0 else vectors[:, k - 1].conj()
    return real + 1j * imaginary, vectors


def check(library, matrix):
    """Check values and vectors by their definition, and the sum and number of the values; return both."""
    matrix = np.asarray(matrix, dtype=float)
    size = max(np.abs(matrix).max(), np.finfo(float).tiny)
    values, vectors = eigen(library, matrix)
    assert_allclose(matrix @ vectors, vectors * values, atol=ROUNDING * size)
    assert_allclose(np.linalg.norm(vectors, axis=0), 1.0, rtol=1e-14)
    assert_allclose(values.sum(), np.trace(matrix), atol=ROUNDING * size * len(matrix))
    return values, vectors


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 20, 100])
def test_random_matrices(library, n):
    matrix = np.random.default_rng(n).standard_normal((n, n))
    values, vectors = check(library, matrix)
    expected, of_numpy = np.linalg.eig(matrix)
    assert_allclose(np.sort_complex(values), np.sort_complex(expected), atol=1e-11)
    assert_allclose(np.linalg.cond(vectors), np.linalg.cond(of_numpy), rtol=1e-8)


def test_symmetric_matrix(library):
    matrix = np.random.default_rng(1).standard_normal((30, 30))
    values, vectors = check(library, matrix + matrix.T)
    assert np.all(values.imag == 0.0)
    assert_allclose(vectors.T @ vectors, np.eye(30), atol=1e-12)


def test_equal_eigenvalues_with_independent_vectors(library):
    """Two equal oscillators, coupled to nothing, in turned coordinates."""
    turned, _ = np.linalg.qr(np.random.default_rng(2).standard_normal((6, 6)))
    block = np.array([[0.0, 2.0], [-2.0, -0.1]])
    matrix = turned @ np.kron(np.eye(3), block) @ turned.T
    _, vectors = check(library, matrix)
    assert np.linalg.cond(vectors) < 100.0


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((4, 4)),
        np.eye(5),
        np.diag([1.0, -2.0, 3.0]),
        np.triu(np.ones((6, 6))),
        [[0.0, 1.0], [0.0, 0.0]],
        [[0.0, 2.0], [-2.0, -4.0]],  # critically damped
        np.roll(np.eye(8), 1, axis=0),  # a cycle, which Francis' step maps to itself
        np.diag(np.ones(7), 1),
        [[0.0, 1e150], [-1e-150, 0.0]],
    ],
    ids=["zero", "identity", "diagonal", "triangular", "nilpotent", "critical", "cycle", "chain", "badly scaled"],
)
def test_special_matrices(library, matrix):
    check(library, matrix)


def test_matrices_that_are_not_numbers_end(library):
    matrix = np.full((5, 5), np.nan)
    n, work = 5, np.zeros(35)
    arrays = [np.zeros(5), np.zeros(5), np.zeros((5, 5))]
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (matrix, *arrays, work))
    assert library.eigenvectors(n, *pointers) in (0, 1)
