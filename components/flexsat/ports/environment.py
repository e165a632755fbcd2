"""Ports and parameters of the environment."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..quantities import FULL_TURN
from ..runtime.missions.environment import EARTH_RADIUS, EnvironmentParameters
from ..runtime.missions.mission_data import MissionData
from .table import Port


def ports(model: MissionData) -> tuple[Port, ...]:
    """Return the ports of the environment; area and inertia are those of a spacecraft."""
    attitude = ("attitude.quaternion",)
    return (
        Port(name="attitude.quaternion", causality="input", unit="1", size=4, start=(0.0, 0.0, 0.0, 1.0),
             description="attitude, scalar-last quaternion, body from inertial"),
        Port(name="external.force", causality="output", unit="N", size=3, frame="body", variability="discrete",
             depends_on=attitude, description="force of the environment: sunlight and the constant one"),
        Port(name="external.torque", causality="output", unit="N.m", size=3, frame="body", variability="discrete",
             depends_on=attitude, display_unit="mN.m",
             description="torque of the environment about the body origin: the sum of all four"),
        Port(name="solar.force", causality="output", unit="N", size=3, frame="body", variability="discrete",
             depends_on=attitude, display_unit="mN", description="force of sunlight"),
        Port(name="solar.torque", causality="output", unit="N.m", size=3, frame="body", variability="discrete",
             depends_on=attitude, display_unit="mN.m", description="torque of sunlight"),
        Port(name="gravity_gradient.torque", causality="output", unit="N.m", size=3, frame="body",
             variability="discrete", depends_on=attitude, display_unit="mN.m",
             description="torque of the gravity gradient"),
        Port(name="magnetic.torque", causality="output", unit="N.m", size=3, frame="body", variability="discrete",
             depends_on=attitude, display_unit="mN.m", description="torque of the field on the residual dipole"),
        Port(name="orbit.position", causality="output", unit="m", size=3, frame="inertial", variability="discrete",
             description="place in the orbit, from the centre of the Earth"),
        Port(name="magnetic.field", causality="output", unit="T", size=3, frame="inertial", variability="discrete",
             description="field of the Earth's dipole"),
        Port(name="solar.lit", causality="output", kind="boolean", description="false in the shadow of the Earth"),
        Port(name="orbit.radius", causality="parameter", unit="m", start=4.2164e7, minimum=EARTH_RADIUS, maximum=1e12,
             description="radius of the circular orbit"),
        Port(name="orbit.inclination", causality="parameter", unit="rad", start=0.5, minimum=-FULL_TURN,
             maximum=FULL_TURN, display_unit="deg",
             description="inclination of the orbit against the inertial x-y plane"),
        Port(name="orbit.node", causality="parameter", unit="rad", start=0.0, minimum=-FULL_TURN,
             maximum=FULL_TURN, display_unit="deg", description="ascending node, from inertial x"),
        Port(name="orbit.argument", causality="parameter", unit="rad", start=0.0, minimum=-FULL_TURN,
             maximum=FULL_TURN, display_unit="deg", description="place in the orbit at t = 0, from the node"),
        Port(name="gravity_gradient.enabled", causality="parameter", kind="boolean", start=True,
             description="whether there is a gravity gradient"),
        Port(name="gravity_gradient.inertia", causality="parameter", unit="kg.m2", size=9, frame="body",
             start=tuple(model.inertia.ravel().tolist()), minimum=-1e12, maximum=1e12,
             description="inertia about the centre of mass, row after row"),
        Port(name="solar.pressure", causality="parameter", unit="N/m2", start=4.54e-6, minimum=0.0, maximum=1.0,
             description="pressure of sunlight that is absorbed: 1361 W/m2 over the speed of light; 0: none"),
        Port(name="solar.sun_direction", causality="parameter", unit="1", size=3, frame="inertial",
             start=(math.sqrt(0.5), 0.0, math.sqrt(0.5)), minimum=-1e12, maximum=1e12,
             description="direction to the Sun, of any length"),
        Port(name="solar.area", causality="parameter", unit="m2", start=model.area, minimum=0.0, maximum=1e9,
             description="area of the plate that stands for the spacecraft, lit on either side"),
        Port(name="solar.normal", causality="parameter", unit="1", size=3, frame="body", start=(0.0, 0.0, 1.0),
             minimum=-1e12, maximum=1e12, description="normal of the plate, of any length"),
        Port(name="solar.centre_of_pressure", causality="parameter", unit="m", size=3, frame="body",
             start=(0.1, 0.05, 0.0), minimum=-1e6, maximum=1e6,
             description="where sunlight acts, from the body origin"),
        Port(name="solar.specular", causality="parameter", unit="1", start=0.5, minimum=0.0, maximum=1.0,
             description="share of the light that is reflected as by a mirror"),
        Port(name="solar.diffuse", causality="parameter", unit="1", start=0.1, minimum=0.0, maximum=1.0,
             description="share of the light that is scattered (Lambert); the rest is absorbed"),
        Port(name="solar.shadow", causality="parameter", kind="boolean", start=True,
             description="whether the Earth casts a shadow, a cylinder"),
        Port(name="magnetic.equatorial_field", causality="parameter", unit="T", start=2.98e-5, minimum=0.0, maximum=1.0,
             description="field of the dipole at 6371.2 km over its equator: IGRF-13 for 2020; 0: none"),
        Port(name="magnetic.dipole_axis", causality="parameter", unit="1", size=3, frame="inertial",
             start=(0.0, 0.0, 1.0), minimum=-1e12, maximum=1e12,
             description="direction to the magnetic pole in the north, of any length; it does not turn"),
        Port(name="magnetic.residual_dipole", causality="parameter", unit="A.m2", size=3, frame="body",
             start=(10.0, 10.0, 10.0), minimum=-1e6, maximum=1e6, description="residual dipole of the spacecraft"),
        Port(name="constant.force", causality="parameter", unit="N", size=3, frame="body", start=0.0, minimum=-1e6,
             maximum=1e6, description="a constant force at the body origin"),
        Port(name="constant.torque", causality="parameter", unit="N.m", size=3, frame="body", start=0.0, minimum=-1e6,
             maximum=1e6, display_unit="mN.m", description="a constant torque"),
    )  # fmt: skip


def parameters(value: Callable[[str], Any]) -> EnvironmentParameters:
    """Return the parameters of a run; `value` gives the value of a port.

    Raises
    ------
    ValueError
        For an orbit within the Earth, a direction without a length, or light reflected more than once.
    """
    return EnvironmentParameters(
        orbit_radius=value("orbit.radius"),
        inclination=value("orbit.inclination"),
        node=value("orbit.node"),
        argument=value("orbit.argument"),
        inertia=np.reshape(np.array(value("gravity_gradient.inertia"), np.float64), (3, 3)),
        gravity_gradient=value("gravity_gradient.enabled"),
        sun_direction=np.array(value("solar.sun_direction")),
        pressure=value("solar.pressure"),
        area=value("solar.area"),
        normal=np.array(value("solar.normal")),
        centre_of_pressure=np.array(value("solar.centre_of_pressure")),
        specular=value("solar.specular"),
        diffuse=value("solar.diffuse"),
        shadow=value("solar.shadow"),
        equatorial_field=value("magnetic.equatorial_field"),
        dipole_axis=np.array(value("magnetic.dipole_axis")),
        residual_dipole=np.array(value("magnetic.residual_dipole")),
        constant_force=np.array(value("constant.force")),
        constant_torque=np.array(value("constant.torque")),
    )
