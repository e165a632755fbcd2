"""Fewer modes and model errors of a spacecraft."""

from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.description.built_in import configuration
from flexsat.description.spacecraft_file import read_spacecraft
from flexsat.parameters import ALL_MODES
from flexsat.spacecraft.assembly import build_spacecraft
from flexsat.spacecraft.variation import ModelErrors, full_spacecraft, keep_modes, with_angles, with_errors
from fmus.turning_array import spacecraft, write_files


@pytest.fixture(scope="module")
def full():
    return full_spacecraft(configuration("distributed"), ALL_MODES)


def test_the_lowest_modes_are_those_of_a_smaller_model(full, distributed):
    """Built with 25 modes, and 25 of 198: the same structure, as modes do not depend on how many are kept."""
    kept, built = keep_modes(full, slice(25)), distributed.spacecraft
    assert kept.frequency[-1] < full.frequency[25] < 2.0 * np.pi * 80.0
    for item in fields(kept):
        one, other = getattr(kept, item.name), getattr(built, item.name)
        if isinstance(one, np.ndarray):
            assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max(), err_msg=item.name)  # of refinement
    # products of the structure with its devices, which run over all of their arrays
    assert_allclose(kept.jitter_influence, built.jitter_influence, atol=1e-9 * np.abs(built.jitter_influence).max())
    assert_allclose(kept.torque_influence, built.torque_influence, atol=1e-9 * np.abs(built.torque_influence).max())


@pytest.mark.parametrize("inertia", [-0.1, 0.0, 0.1])
def test_mass_stays_positive_with_less_inertia(full, inertia):
    """The modes carry all but a thousandth of the inertia: less of it lightens them, more of it is a rigid body."""
    real = with_errors(full, ModelErrors(frequency=0.05, damping=-0.5, inertia=inertia))
    assert np.linalg.eigvalsh(real.mass_matrix)[0] > 0.0
    assert_allclose(real.inertia, (1.0 + inertia) * full.inertia, rtol=1e-15)
    assert_allclose(real.frequency, 1.05 * full.frequency, rtol=1e-15)
    assert_allclose(real.damping, 0.5 * full.damping, rtol=1e-15)


@pytest.mark.parametrize(("name", "value"), [("frequency", -1.0), ("inertia", -1.0), ("damping", -1.5)])
def test_impossible_errors_are_refused(name, value):
    with pytest.raises(ValueError, match=rf"ModelErrors\.{name} must be >=? -1, got {value}"):
        ModelErrors(**{name: value})


def test_angles_of_what_turns_alone(tmp_path):
    """Of three appendages the second stands still: a file with the angles is the same spacecraft."""
    config = read_spacecraft(write_files(tmp_path, 25.0, -15.0)).configurations["robust"]
    turned = with_angles(config, np.deg2rad([70.0, 10.0]).tolist())
    assert [one.angle for one in turned.appendages] == np.deg2rad([70.0, 0.0, 10.0]).tolist()
    expected = spacecraft(tmp_path, 70.0, 10.0)
    assert_allclose(build_spacecraft(turned).mass_matrix, expected.mass_matrix, atol=1e-12)
