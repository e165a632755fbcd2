"""The environment against closed forms."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.ports import environment as interface
from flexsat.runtime.missions import environment
from flexsat.runtime.missions.environment import EARTH, EARTH_RADIUS, FIELD_RADIUS
from flexsat.runtime.rotations import matrix_from_mrp, quaternion_from_mrp
from fmus.mission_numbers import MISSION_DATA, values_of

ROUNDING = 1e-12  # relative: a few products of doubles
REST = np.array([0.0, 0.0, 0.0, 1.0])


def act(time: float = 0.0, quaternion: np.ndarray = REST, **given: Any) -> environment.EnvironmentOutputs:
    """Return the outputs at a time, with an attitude, for values of parameters (dots as `__`)."""
    values = values_of(interface.ports(MISSION_DATA), given)
    return environment.step(environment.prepare(interface.parameters(values)), time, quaternion)


def test_gravity_gradient_is_the_closed_form():
    mrp = (0.1, -0.2, 0.3)
    radius, time = 7.0e6, 1234.0
    found = act(time, np.array(quaternion_from_mrp(mrp)), orbit__radius=radius, orbit__inclination=0.4, orbit__node=0.9)
    angle = math.sqrt(EARTH / radius**3) * time
    x, y, z = math.cos(angle), math.sin(angle) * math.cos(0.4), math.sin(angle) * math.sin(0.4)
    place = radius * np.array([x * math.cos(0.9) - y * math.sin(0.9), x * math.sin(0.9) + y * math.cos(0.9), z])
    seen = matrix_from_mrp(mrp) @ place
    expected = 3.0 * EARTH / radius**5 * np.cross(seen, MISSION_DATA.inertia @ seen)

    assert_allclose(found.position, place, rtol=ROUNDING)
    assert_allclose(found.gravity_torque, expected, rtol=1e-11)


def test_no_gravity_gradient_along_a_principal_axis():
    found = act(orbit__inclination=0.0, gravity_gradient__inertia=(2e5, 0, 0, 0, 3e5, 0, 0, 0, 4e5))

    assert np.abs(found.gravity_torque).max() == 0.0


def test_the_dipole_on_an_equatorial_and_a_polar_orbit():
    radius, field = 2.0 * FIELD_RADIUS, 2.98e-5
    at_equator = act(orbit__radius=radius, orbit__inclination=0.0)
    quarter = 0.5 * math.pi / math.sqrt(EARTH / radius**3)
    over_pole = act(quarter, orbit__radius=radius, orbit__inclination=0.5 * math.pi)

    # a dipole: to the north over the equator; twice as strong, into the Earth, over the pole in the north
    assert_allclose(at_equator.field, [0.0, 0.0, field / 8.0], rtol=ROUNDING, atol=1e-20)
    assert_allclose(over_pole.field, [0.0, 0.0, -2.0 * field / 8.0], rtol=ROUNDING, atol=1e-20)
    assert_allclose(at_equator.magnetic_torque, np.cross([10.0, 10.0, 10.0], at_equator.field), rtol=ROUNDING)


@pytest.mark.parametrize(
    ("specular", "diffuse", "factor"), [(0.0, 0.0, 1.0), (1.0, 0.0, 2.0), (0.0, 1.0, 5.0 / 3.0)],
    ids=["black", "mirror", "white"],
)  # fmt: skip
def test_sunlight_face_on(specular: float, diffuse: float, factor: float):
    for side in (1.0, -1.0):
        found = act(solar__sun_direction=(0.0, 0.0, side), solar__specular=specular, solar__diffuse=diffuse,
                    solar__area=600.0, solar__centre_of_pressure=(0.2, 0.0, 0.0))  # fmt: skip
        force = -side * factor * 4.54e-6 * 600.0

        assert_allclose(found.solar_force, [0.0, 0.0, force], rtol=ROUNDING)
        assert_allclose(found.solar_torque, [0.0, -0.2 * force, 0.0], rtol=ROUNDING)


def test_a_mirror_is_pushed_along_its_normal_alone_and_a_black_plate_along_the_light():
    sun = np.array([math.sin(0.6), 0.0, math.cos(0.6)])
    light = 4.54e-6 * 623.5
    mirror = act(solar__sun_direction=tuple(sun), solar__specular=1.0, solar__diffuse=0.0)
    black = act(solar__sun_direction=tuple(sun), solar__specular=0.0, solar__diffuse=0.0)

    assert_allclose(mirror.solar_force, [0.0, 0.0, -2.0 * light * math.cos(0.6) ** 2], rtol=ROUNDING, atol=1e-18)
    assert_allclose(black.solar_force, -light * math.cos(0.6) * sun, rtol=ROUNDING)


def test_the_shadow_lasts_as_long_as_the_earth_is_wide():
    radius, sun = 7.0e6, (1.0, 0.0, 0.0)
    rate = math.sqrt(EARTH / radius**3)
    half = math.asin(EARTH_RADIUS / radius)
    lit = [act((math.pi + share * half) / rate, orbit__radius=radius, orbit__inclination=0.0,
               solar__sun_direction=sun).sunlit for share in (-1.001, -0.999, 0.0, 0.999, 1.001)]  # fmt: skip

    assert lit == [True, False, False, False, True]


def test_forces_and_torques_add_up():
    found = act(50.0, constant__torque=(1e-3, 2e-3, 3e-3), constant__force=(1e-2, 0.0, 0.0))
    total = found.solar_torque + found.gravity_torque + found.magnetic_torque

    assert_allclose(found.torque, total + np.array([1e-3, 2e-3, 3e-3]), rtol=ROUNDING)
    assert_allclose(found.force, found.solar_force + np.array([1e-2, 0.0, 0.0]), rtol=ROUNDING)
    for part in (found.solar_torque, found.gravity_torque, found.magnetic_torque):
        assert np.abs(part).max() > 0.0
