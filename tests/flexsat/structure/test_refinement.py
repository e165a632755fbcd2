"""Modes are the same bits, however an eigenvalue solver rounds, mixes pairs, and chooses signs."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from numpy.testing import assert_allclose

from flexsat.parameters import Aperture, Plate
from flexsat.structure import modes
from flexsat.structure.mesh import record_mesh
from flexsat.structure.modes import build_structure
from flexsat.structure.refinement import Eigenpairs, refine

PLATE = Plate()  # with all the modes that are simulated


@pytest.fixture(scope="module")
def of_record():
    return build_structure(record_mesh(Aperture()), PLATE)


def disturbed(seed, pairs):
    """Return an eigenvalue solver that errs by ten times what two kernels of OpenBLAS differ by, mixing as it likes."""
    rng = np.random.default_rng(seed)

    def eigh(stiffness, mass):
        values, vectors = solver(stiffness, mass)
        vectors = vectors * rng.choice([-1.0, 1.0], len(values))
        for k in pairs:
            c, s = np.cos(angle := rng.uniform(0.0, 2.0 * np.pi)), np.sin(angle)
            vectors[:, k : k + 2] = vectors[:, k : k + 2] @ np.array([[c, -s], [s, c]])
        vectors += 1e-8 * np.abs(vectors).max(axis=0) * rng.standard_normal(vectors.shape)
        return values * (1.0 + 1e-9 * rng.standard_normal(len(values))), vectors

    solver = scipy.linalg.eigh
    return eigh


def test_another_solver_gives_the_same_bits(of_record, monkeypatch):
    pairs = modes.degenerate_pairs(of_record.frequency)
    assert len(pairs) > 60
    monkeypatch.setattr(scipy.linalg, "eigh", disturbed(1, pairs))
    unrounded = []

    def noted(*arguments):
        unrounded.append(refine(*arguments))
        return unrounded[-1]

    monkeypatch.setattr(modes, "refine", noted)
    again = build_structure(replace(of_record.mesh), PLATE)

    for name in ("frequency", "deflection", "slope", "translation", "rotation", "damping"):
        assert getattr(again, name).tobytes() == getattr(of_record, name).tobytes(), name
    # margin: before they are rounded to 1e-12 of the largest, two solvers' shapes agree to 1e-20, or are neighbours
    monkeypatch.setattr(scipy.linalg, "eigh", disturbed(2, pairs))
    build_structure(replace(of_record.mesh), PLATE)
    one, other = (shapes for _, shapes in unrounded)
    assert np.all(np.abs(one - other) <= np.maximum(1e-20 * np.abs(one).max(), np.spacing(np.abs(one))))


def test_a_number_of_modes_that_cuts_a_pair_changes_no_mode(of_record):
    for count in (4, 23, 25):
        fewer = build_structure(of_record.mesh, PLATE, count)
        assert fewer.frequency.tobytes() == of_record.frequency[:count].tobytes()
        for name in ("deflection", "slope"):
            kept = np.ascontiguousarray(getattr(of_record, name)[..., :count])
            assert getattr(fewer, name).tobytes() == kept.tobytes()


def test_refined_pairs_of_a_chain_are_those_of_the_closed_form():
    """Springs in a ring: frequencies 2 sin(pi k / n), pairs of cosine and sine; the row fixes which is which."""
    size = 8
    stiffness = 2.0 * np.eye(size) - np.roll(np.eye(size), 1, axis=0) - np.roll(np.eye(size), -1, axis=0)
    found = Eigenpairs(*np.linalg.eigh(stiffness))
    row = np.eye(size)[0]
    pair = found.vectors[:, 1:3]
    cosine, sine = (row @ pair) / np.linalg.norm(row @ pair)
    turned = pair @ np.array([[cosine, -sine], [sine, cosine]])
    values, vectors = refine(stiffness, np.eye(size), found, turned, {0: row}, 1)

    angle = 2.0 * np.pi * np.arange(size) / size
    assert_allclose(values, 4.0 * np.sin(np.pi / size) ** 2, rtol=4e-16)
    assert_allclose(vectors[:, 0], np.cos(angle) / 2.0, atol=2e-16)
    assert_allclose(np.abs(vectors[:, 1]), np.abs(np.sin(angle)) / 2.0, atol=2e-16)
