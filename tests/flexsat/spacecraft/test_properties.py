"""Envelopes of wheels against closed forms; free modes and how wheels and gyros reach them against the mass matrix."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.description.built_in import configuration
from flexsat.parameters import Modes
from flexsat.spacecraft.assembly import RIGID, build_spacecraft
from flexsat.spacecraft.properties import envelope, mode_table

ROUNDING = 1e-12
PYRAMID = np.array([[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1]]) / np.sqrt(2.0)


@pytest.mark.parametrize(
    ("axes", "about", "weakest"),
    [
        # a cube: two wheels along each axis
        (np.vstack([np.eye(3), -np.eye(3)]), (2.0, 2.0, 2.0), 2.0),
        # a box: one wheel more along x
        (np.vstack([np.eye(3), [[1.0, 0.0, 0.0]]]), (2.0, 1.0, 1.0), 1.0),
        # a pyramid of four, half-angle 45 degrees: all four about z; about x the two that lean along it
        (PYRAMID, (np.sqrt(2.0), np.sqrt(2.0), 2.0 * np.sqrt(2.0)), np.sqrt(2.0)),
        # three wheels at right angles, turned: about (1, 1, 1) each gives its most
        (np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3.0, (1.5, 1.5, 1.5), 1.0),
    ],
)  # fmt: skip
def test_the_envelope_of_wheels(axes, about, weakest):
    found = envelope(axes)
    assert_allclose(found.about, about, rtol=ROUNDING)
    assert found.weakest == pytest.approx(weakest, rel=ROUNDING)
    # no wheel needs more than one for it, and no face is nearer in any direction of a fine grid
    directions = np.random.default_rng(4).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert np.abs(directions @ axes.T).sum(axis=1).min() >= weakest * (1.0 - ROUNDING)


def test_wheels_in_one_plane_have_no_envelope():
    with pytest.raises(ValueError, match="the axes lie in one plane"):
        envelope(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8, 0.0]]))


def test_free_modes_and_their_reach():
    craft = build_spacecraft(replace(configuration("centralised"), modes=Modes(plant=30)))
    modes = mode_table(craft)

    # a free mode of frequency w obeys det(K - w^2 M) = 0: the coupling lifts it, or leaves it where it is uncoupled
    stiffness = np.zeros_like(craft.mass_matrix)
    stiffness[RIGID:, RIGID:] = np.diag(craft.frequency**2)
    for k in (0, 5, 12):
        dynamic = stiffness - modes.free[k] ** 2 * craft.mass_matrix
        scale = np.linalg.norm(stiffness) + modes.free[k] ** 2 * np.linalg.norm(craft.mass_matrix)
        assert np.abs(np.linalg.eigvalsh(dynamic)).min() < 1e-12 * scale
    assert np.all(modes.free >= craft.frequency * (1.0 - 1e-9))
    # wheels on the bus reach what moves the bus, and nothing else: the gyros there see the same
    uncoupled = np.isclose(modes.free[:, None], craft.frequency, rtol=1e-9).any(axis=1)
    assert np.count_nonzero(uncoupled) > 10
    assert np.all(modes.controllability[uncoupled] < 1e-9)
    assert modes.controllability.max() == 1.0
    # the structure carries all of the mass, and its lowest modes most of it
    assert 0.75 < modes.effective_mass[2].sum() < 1.0
    assert np.all(modes.effective_inertia.sum(axis=1) < 1.0)
