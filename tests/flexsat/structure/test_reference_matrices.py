"""Our finite elements on the authors' own mesh, against the matrices of their public release (BSD 2-Clause)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from scipy.sparse import csc_array

from flexsat.parameters import Plate
from flexsat.structure.kirchhoff_plate import PlateMatrices, assemble
from flexsat.structure.mesh import Mesh
from flexsat.structure.modes import solve_modes

# PHYSICS section 1, column "authors (D)" [Hz], printed to four digits
PUBLISHED = [0.3441, 0.3441, 0.4117, 0.5285, 0.5285, 1.026, 1.245, 1.917, 1.917, 2.158, 2.286, 2.286, 3.076, 3.076]
PUBLISHED += [3.146, 3.146, 3.881, 3.944, 4.156, 4.606, 5.05, 5.05, 5.41, 5.41, 5.966]


@pytest.fixture(scope="module")
def matrices(authors_fem) -> PlateMatrices:
    mesh = Mesh(
        nodes=authors_fem["nodes"], triangles=authors_fem["triangles"].astype(np.intp), hole=np.arange(6, dtype=np.intp)
    )
    return assemble(mesh, Plate())


def relative(found: np.ndarray, published: np.ndarray) -> float:
    return float(np.abs(found - published).max() / np.abs(published).max())


# The published ones were assembled in another order: 1e-12 is some thousand roundings. Their area is
# 623.538 m2 to 1e-14 or better.
SAME = 1e-12


def test_mass(authors_fem, matrices):
    assert relative(matrices.mass.toarray(), authors_fem["mass_nodal"]) < SAME


def test_coupling(authors_fem, matrices):
    found = np.vstack([matrices.translation, matrices.rotation])
    assert relative(found, authors_fem["mass_coupling"]) < SAME


def test_rigid_mass(authors_fem, matrices):
    published = authors_fem["mass_rigid"]
    assert_allclose(np.diag(published)[:3], matrices.total_mass, rtol=SAME)
    assert relative(matrices.inertia, published[3:, 3:]) < SAME
    assert_allclose(published[:3, 3:], 0.0, atol=SAME * 4200.0 * 16.0)  # the centroid is the origin: mass times radius


def frequencies(mass: csc_array, stiffness: csc_array, clamped: np.ndarray) -> np.ndarray:
    free = np.setdiff1d(np.arange(mass.shape[0]), clamped)
    values = eigh(stiffness.toarray()[np.ix_(free, free)], mass.toarray()[np.ix_(free, free)], eigvals_only=True)
    return np.sqrt(values[:25]) / (2.0 * np.pi)


def test_their_stiffness_gives_their_frequencies(authors_fem, matrices):
    stiffness = csc_array(0.5 * (authors_fem["stiffness"] + authors_fem["stiffness"].T))
    found = frequencies(matrices.mass, stiffness, authors_fem["clamped_dofs"])
    # the table prints one value for a pair, whose members are up to .18 % apart on their unsymmetric mesh
    assert_allclose(found, PUBLISHED, rtol=2e-3)


def test_our_stiffness_is_as_near_as_elements_differ(authors_fem, matrices):
    frequency, _ = solve_modes(matrices, authors_fem["clamped_dofs"].astype(np.intp), 25)
    spread = frequency / (2.0 * np.pi) / PUBLISHED - 1.0
    assert np.abs(spread[:19]).max() < 0.06  # PHYSICS section 1: another element, the same wave lengths
    assert np.abs(spread).max() < 0.125  # 12 % at mode 25, stated to a whole percent
