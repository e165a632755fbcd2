"""Motors of reaction wheels: torque that falls with speed, and a command of finite steps. numpy alone.

A motor's back voltage leaves it less torque the faster the wheel turns: up to some speed its limit is that of the
current, above it falls in a line to zero at the wheel's greatest speed. Torque that slows a wheel down is not limited
so. The speed is that of the wheel against its mount, at the start of a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Index, make_read_only
from .plant_parameters import PlantParameters


@dataclass(frozen=True, slots=True, kw_only=True)
class Motors:
    """What the motors of one run limit beside their greatest torque, for steps of one length."""

    quantised: Index  # (q,) wheels whose command has steps
    torque_step: Array  # (q,) [N.m]
    limited: Index  # (l,) wheels with a speed limit
    speed_limit: Array  # (l,) [rad/s]
    slope: Array  # (l,) [N.m.s/rad]: of the torque that speeds a wheel up, over what it lacks to its limit
    most: Array  # (l,) [N.m]

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare_motors(parameters: PlantParameters, most: Array, inertia: Array, step: float) -> Motors:
    """Prepare for the greatest torques (n,) [N.m] and inertias (n,) [kg.m2] of the wheels, and steps of `step` [s]."""
    ones = np.ones(len(most))
    steps, speed, full = (
        ones * given for given in (parameters.torque_step, parameters.speed_limit, parameters.full_torque_speed)
    )
    quantised, limited = np.flatnonzero(steps > 0.0), np.flatnonzero(speed > 0.0)
    stopping = inertia / step  # the torque that reaches the limit in one step: a steeper fall would overshoot
    falling = (full > 0.0) & (full < speed)
    slope = np.minimum(np.divide(most, speed - full, out=stopping.copy(), where=falling), stopping)
    return Motors(
        quantised=quantised,
        torque_step=steps[quantised],
        limited=limited,
        speed_limit=speed[limited],
        slope=slope[limited],
        most=most[limited],
    )


def quantise(motors: Motors, torque: Array) -> None:
    """Round commanded torques (n,) [N.m] to whole steps, in place."""
    if len(motors.quantised):
        given = torque[motors.quantised]
        torque[motors.quantised] = motors.torque_step * np.rint(given / motors.torque_step)


def limit_by_speed(motors: Motors, speed: Array, torque: Array) -> None:
    """Limit torques (n,) [N.m] that speed wheels up, at relative speeds (n,) [rad/s], in place."""
    if len(motors.limited):
        own = speed[motors.limited]
        rise = np.minimum(np.maximum(motors.slope * (motors.speed_limit - own), 0.0), motors.most)
        fall = np.minimum(np.maximum(motors.slope * (motors.speed_limit + own), 0.0), motors.most)
        torque[motors.limited] = np.maximum(np.minimum(torque[motors.limited], rise), -fall)
