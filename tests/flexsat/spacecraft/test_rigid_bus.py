"""Bus and structure as one body: kinetic energy and inertia of the parts, and wheels along any axis."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.description.built_in import configuration
from flexsat.description.placement import ALONG, Bus, Device, direction
from flexsat.design.chain import plant_matrices
from flexsat.parameters import Modes
from flexsat.runtime import plant
from flexsat.spacecraft.assembly import build_spacecraft, lateral_axes

BUS = Bus(mass=700.0, inertia=(300.0, 400.0, 500.0, 20.0, -30.0, 10.0), centre_of_mass=(0.4, -0.3, -1.2))
MODES = 12
FEW_ULP = 1e-12


@pytest.fixture(scope="module")
def bare():
    return replace(configuration("centralised"), modes=Modes(plant=MODES, design=MODES))


@pytest.fixture(scope="module")
def joined(bare):
    return replace(bare, bus=BUS)


def test_the_kinetic_energy_is_that_of_structure_and_bus(bare, joined):
    structure, whole = build_spacecraft(bare), build_spacecraft(joined)
    place, inertia = np.array(BUS.centre_of_mass), BUS.inertia_matrix
    centre = BUS.mass * place / (structure.mass + BUS.mass)
    rng = np.random.default_rng(1)
    for _ in range(5):
        speed, rate, modal = rng.normal(size=3), rng.normal(size=3), rng.normal(size=MODES)
        of_structure = np.concatenate([speed - np.cross(rate, centre), rate, modal])  # at the centre of the aperture
        of_bus = speed + np.cross(rate, place - centre)
        parts = of_structure @ structure.mass_matrix @ of_structure + BUS.mass * of_bus @ of_bus + rate @ inertia @ rate

        moving = np.concatenate([speed, rate, modal])
        assert moving @ whole.mass_matrix @ moving == pytest.approx(parts, rel=FEW_ULP)


def test_the_inertia_of_the_whole_is_that_of_its_parts_moved_to_its_centre_of_mass(bare, joined):
    structure, whole = build_spacecraft(bare), build_spacecraft(joined)
    place = np.array(BUS.centre_of_mass)
    centre = BUS.mass * place / (structure.mass + BUS.mass)

    def moved(mass, arm):
        return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    parts = structure.inertia + moved(structure.mass, -centre) + BUS.inertia_matrix + moved(BUS.mass, place - centre)
    assert_allclose(whole.inertia, parts, rtol=FEW_ULP, atol=FEW_ULP * structure.inertia.max())
    assert whole.mass == structure.mass + BUS.mass
    # the devices are where they were, seen from the centre of mass
    assert_allclose(whole.gyros.position + centre, structure.gyros.position, atol=1e-14)


def test_lateral_axes_are_perpendicular_and_do_not_depend_on_the_sense_of_the_axis():
    axes = np.random.default_rng(2).normal(size=(50, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    first, second = lateral_axes(axes)
    triads = np.stack([axes, first, second], axis=1)
    assert_allclose(triads @ triads.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (50, 3, 3)), atol=4e-16 * 3)
    for one, other in zip(lateral_axes(-axes), (first, second), strict=True):
        assert np.array_equal(one, other)


def test_lateral_axes_of_wheels_along_body_axes_are_the_other_body_axes():
    first, second = lateral_axes(np.array([ALONG[name] for name in ("+x", "-y", "+z")]))
    assert np.array_equal(first, [ALONG["+y"], ALONG["+x"], ALONG["+x"]])
    assert np.array_equal(second, [ALONG["+z"], ALONG["+z"], ALONG["+y"]])


def test_a_pyramid_on_an_offset_bus_keeps_the_angular_momentum_that_its_wheels_exchange(joined, quiet_run):
    axes = [direction(axis) for axis in ((1.0, 0.0, 1.0), (0.0, -1.0, -1.0), (-1.0, 0.2, 1.0), (0.0, 1.0, -1.0))]
    config = replace(joined, wheels=tuple(Device(site="bus", axis=axis) for axis in axes))
    craft = build_spacecraft(config)
    matrices = plant_matrices(craft, np.array([30.0, 31.0, 32.0, 33.0]), 1e-3)
    prepared = plant.prepare(matrices, quiet_run(matrices, wheel_speed=matrices.nominal_speed), 1e-3)
    state = plant.init(prepared)
    inputs = np.zeros(prepared.input_count)
    torque = np.array([0.3, -0.2, 0.1, 0.25])
    inputs[:4] = torque
    before = plant.telemetry(prepared, state).angular_momentum.copy()
    for _ in range(2000):
        plant.step(prepared, state, inputs, None)

    after = plant.telemetry(prepared, state)
    given = np.linalg.norm(torque @ np.array(axes)) * 2.0  # N.m.s that the wheels have taken in 2 s
    assert_allclose(after.angular_momentum, before, atol=1e-6 * given)
    # what the wheels took the body lost: rigid rotation and the modes' part of the momentum about the centre of mass
    body = craft.inertia @ state.outputs.rate + craft.rotation @ after.modal_velocity
    assert_allclose(body, -(torque @ np.array(axes)) * 2.0, atol=2e-4 * given)
