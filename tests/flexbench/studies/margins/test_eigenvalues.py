"""Eigenvalues of a loop over all its steps, without the many that are zero."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.periodic_loop import largest_eigenvalues
from flexsat.description.built_in import configuration
from flexsat.design.chain import build_design
from flexsat.spacecraft.variation import with_modes


@pytest.mark.parametrize("turn", [1.0, np.exp(0.5j)], ids=["real", "complex"])
def test_a_product_of_narrow_matrices_has_the_eigenvalues_of_the_product_in_the_other_order(turn):
    left, right = np.random.default_rng(1).normal(size=(2, 60, 4))
    found = largest_eigenvalues(turn * left @ right.T)

    expected = turn * np.linalg.eigvals(right.T @ left)
    assert 4 <= len(found) < 10  # of 60; the product is rounded
    found = found[np.argsort(abs(found))[-4:]]
    assert_allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-12)  # rounding of sums of 60


def test_no_eigenvalue_is_lost_that_is_small_beside_the_norm():
    triangle = np.array([[1e-9, 1.0, 5.0], [0.0, 0.5, 2.0], [0.0, 0.0, -2.0]])
    assert_allclose(np.sort(largest_eigenvalues(triangle).real), [-2.0, 1e-9, 0.5], rtol=1e-6)


def test_nothing_moves():
    assert largest_eigenvalues(np.zeros((3, 3))).tolist() == [0.0]


def test_delayed_torques_add_states_and_no_eigenvalues():
    """A loop over 20 steps with six steps' torques on their way: the spectral radius of the whole matrix."""
    design = build_design(with_modes(configuration("centralised"), 6))
    monodromy = DesignedLoop(design=design).at(0.03).monodromy()
    found = largest_eigenvalues(monodromy)

    assert len(found) < 0.8 * len(monodromy)
    assert abs(found).max() == pytest.approx(abs(np.linalg.eigvals(monodromy)).max(), rel=1e-11)
