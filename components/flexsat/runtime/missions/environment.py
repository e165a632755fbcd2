"""Run-time environment of a circular orbit: solar pressure, gravity gradient, magnetic torque, a constant. numpy alone.

All outputs follow from time and attitude: there is nothing to remember between steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array, make_read_only
from ..rotations import skew

EARTH = 3.986004418e14  # m3/s2, WGS 84
EARTH_RADIUS = 6.3781370e6  # m, WGS 84: of the shadow
FIELD_RADIUS = 6.3712e6  # m, IGRF: where the equatorial field is given
SUM_OF_COEFFICIENTS = 1.0 + 1e-12  # rounding of two decimals


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvironmentParameters:
    """Parameters of one run. Named as the ports are: messages reach those who set them."""

    orbit_radius: float  # m
    inclination: float  # rad, of the orbit against the inertial x-y plane
    node: float  # rad, from inertial x to the ascending node
    argument: float  # rad, from the node at t = 0
    inertia: Array  # (3, 3) [kg.m2], body axes
    gravity_gradient: bool
    sun_direction: Array  # (3,), inertial
    pressure: float  # N/m2, of sunlight that is absorbed; 0: none
    area: float  # m2
    normal: Array  # (3,), body
    centre_of_pressure: Array  # (3,) [m], body
    specular: float  # share of the light
    diffuse: float
    shadow: bool  # whether the Earth takes the sunlight
    equatorial_field: float  # T, at FIELD_RADIUS
    dipole_axis: Array  # (3,), inertial: to the magnetic pole in the north
    residual_dipole: Array  # (3,) [A.m2], body
    constant_force: Array  # (3,) [N], body
    constant_torque: Array  # (3,) [N.m], body

    def __post_init__(self) -> None:
        if not self.orbit_radius > EARTH_RADIUS:
            raise ValueError(f"orbit.radius must be > {EARTH_RADIUS:.7g} m, the Earth's, got {self.orbit_radius!r}")
        for name, direction in (("solar.sun_direction", self.sun_direction), ("solar.normal", self.normal),
                                ("magnetic.dipole_axis", self.dipole_axis)):  # fmt: skip
            if not np.linalg.norm(direction) > 1e-6:
                raise ValueError(f"{name} must be a direction, got {tuple(np.asarray(direction).tolist())}")
        if not self.specular + self.diffuse <= SUM_OF_COEFFICIENTS:
            raise ValueError(
                f"solar.specular + solar.diffuse must be at most 1, got {self.specular!r} + {self.diffuse!r}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedEnvironment:
    """Numbers that no step changes; directions are unit vectors."""

    radius: float  # m
    rate: float  # rad/s, of the orbit
    argument: float  # rad
    towards_node: Array  # (3,), inertial
    along_orbit: Array  # (3,), inertial: where the orbit is a quarter later
    gradient: float  # 1/s2: 3 mu / R^3, or 0
    field: float  # T: of the dipole at the orbit, over its equator
    parameters: EnvironmentParameters
    sun: Array  # (3,), inertial
    normal: Array  # (3,), body
    pole: Array  # (3,), inertial

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvironmentOutputs:
    """At one time; torques about the body origin."""

    force: Array  # (3,) [N], body: all
    torque: Array  # (3,) [N.m], body: all
    solar_force: Array  # (3,) [N], body
    solar_torque: Array  # (3,) [N.m], body
    gravity_torque: Array  # (3,) [N.m], body
    magnetic_torque: Array  # (3,) [N.m], body
    position: Array  # (3,) [m], inertial
    field: Array  # (3,) [T], inertial
    sunlit: bool


def prepare(parameters: EnvironmentParameters) -> PreparedEnvironment:
    """Compute the orbit and the unit vectors."""
    rate = float(np.sqrt(EARTH / parameters.orbit_radius**3))
    node, tilt = parameters.node, parameters.inclination
    return PreparedEnvironment(
        radius=parameters.orbit_radius,
        rate=rate,
        argument=parameters.argument,
        towards_node=np.array([np.cos(node), np.sin(node), 0.0]),
        along_orbit=np.array([-np.sin(node) * np.cos(tilt), np.cos(node) * np.cos(tilt), np.sin(tilt)]),
        gradient=3.0 * rate * rate if parameters.gravity_gradient else 0.0,
        field=parameters.equatorial_field * (FIELD_RADIUS / parameters.orbit_radius) ** 3,
        parameters=parameters,
        sun=_unit(parameters.sun_direction),
        normal=_unit(parameters.normal),
        pole=_unit(parameters.dipole_axis),
    )


def step(prepared: PreparedEnvironment, time: float, quaternion: Array) -> EnvironmentOutputs:
    """Return forces and torques at `time` [s] with an attitude (4,), body from inertial.

    Sources: gravity gradient, solar pressure on a flat plate: Wertz (1978), Spacecraft Attitude Determination and
    Control, eqs. 17-31 and 17-57; dipole field: the same, appendix H.
    """
    parameters = prepared.parameters
    body = _matrix(quaternion)
    angle = prepared.argument + prepared.rate * time
    outward = np.cos(angle) * prepared.towards_node + np.sin(angle) * prepared.along_orbit
    nadir = body @ outward  # its sign does not matter
    gravity = prepared.gradient * np.cross(nadir, parameters.inertia @ nadir)

    field = prepared.field * (prepared.pole - 3.0 * float(prepared.pole @ outward) * outward)
    magnetic = np.cross(parameters.residual_dipole, body @ field)

    towards_sun = float(outward @ prepared.sun)
    aside = prepared.radius * np.sqrt(max(0.0, 1.0 - towards_sun * towards_sun))
    sunlit = not (parameters.shadow and towards_sun < 0.0 and aside < EARTH_RADIUS)
    light = plate_force(prepared, body @ prepared.sun) if sunlit else np.zeros(3)
    solar = np.cross(parameters.centre_of_pressure, light)
    return EnvironmentOutputs(
        force=light + parameters.constant_force,
        torque=solar + gravity + magnetic + parameters.constant_torque,
        solar_force=light,
        solar_torque=solar,
        gravity_torque=gravity,
        magnetic_torque=magnetic,
        position=prepared.radius * outward,
        field=field,
        sunlit=sunlit,
    )


def plate_force(prepared: PreparedEnvironment, sun: Array) -> Array:
    """Return the force (3,) [N] of sunlight from a direction `sun` (3,), body, on a plate lit on either side."""
    parameters = prepared.parameters
    cosine = float(prepared.normal @ sun)
    lit = prepared.normal if cosine >= 0.0 else -prepared.normal
    cosine = abs(cosine)
    along_sun = 1.0 - parameters.specular
    along_normal = 2.0 * (parameters.specular * cosine + parameters.diffuse / 3.0)
    return np.asarray(-parameters.pressure * parameters.area * cosine * (along_sun * sun + along_normal * lit))


def _matrix(quaternion: Array) -> Array:
    """Return the direction cosines (3, 3), body from inertial, of a quaternion whose norm may not be one exactly."""
    x, y, z, w = (quaternion / np.sqrt(float(quaternion @ quaternion))).tolist()
    cross = skew((x, y, z))
    return np.asarray(np.eye(3) - 2.0 * w * cross + 2.0 * (cross @ cross))


def _unit(direction: Array) -> Array:
    return np.asarray(direction / np.linalg.norm(direction), np.float64)
