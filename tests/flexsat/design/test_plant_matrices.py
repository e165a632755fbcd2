"""The plant's matrices: couplings that rounding alone makes are left out, and nothing else."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import eigh

from flexsat.description.built_in import configuration
from flexsat.design.chain import plant_matrices
from flexsat.runtime.plant_parameters import NO_COUPLING, without_rounding
from flexsat.spacecraft.assembly import Spacecraft, build_spacecraft


@pytest.fixture(scope="module")
def craft() -> Spacecraft:
    """Return the full structure."""
    return build_spacecraft(configuration("centralised", "robust"))


def test_modes_of_the_symmetric_structure_move_the_body_in_one_way_or_not_at_all(craft):
    mass = plant_matrices(craft, np.zeros(6), 1e-3).mass_matrix
    assert_array_equal(np.count_nonzero(mass[:6, 6:], axis=1), [0, 0, 20, 33, 33, 0])  # along z, about x, about y
    assert np.count_nonzero(mass[:6, 6:], axis=0).max() == 1
    assert_array_equal(mass, mass.T)


def test_nothing_but_rounding_is_left_out(craft):
    mass = craft.mass_matrix
    cleaned = without_rounding(mass)
    kept = cleaned != 0.0
    assert_array_equal(cleaned[kept], mass[kept])
    size = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
    assert np.abs(mass / size)[~kept].max() < 0.1 * NO_COUPLING
    assert np.abs(mass / size)[kept].min() > 1e5 * NO_COUPLING
    stiffness = np.diag(np.concatenate([np.zeros(6), craft.frequency**2]))
    free, before = (np.sqrt(eigh(stiffness, matrix, eigvals_only=True)[6:]) for matrix in (cleaned, mass))
    assert_allclose(free, before, rtol=1e-10)  # of a matrix whose inverse is 1e5 times as large: rounding of eigh
