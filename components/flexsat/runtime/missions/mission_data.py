"""Hold what the FMUs of missions know of a spacecraft: start values of their parameters. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionData:
    """Numbers of one spacecraft that environment, thrusters and manager start with."""

    inertia: Array  # (3, 3) [kg.m2], body axes
    area: float  # m2, of the aperture
    wheel_axis: Array  # (n, 3)
    wheel_inertia: Array  # (n,) [kg.m2]
    torque_limit: Array  # (n,) [N.m]
    nominal_speed: Array  # (n,) [rad/s]
    speed_band: float  # rad/s
    period: float  # s, of the controller
