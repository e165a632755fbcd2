"""Bound the signals of the closed loop, from the same design as the FMUs."""

from __future__ import annotations

import numpy as np

from flexsat.design.chain import Design
from flexsat.ports.plant import JITTER
from flexsat.ports.table import Port

SIGMAS = 4.0  # standard deviations of the broadband jitter inside the bound
STABLE_RATE = 0.5  # rad/s: up to here the plant's explicit momentum terms are stable at 1 ms (flexsat.runtime.plant)

Range = tuple[float | None, float | None]  # lower, upper; None: no bound


def signal_ranges(design: Design) -> dict[str, Range]:
    """Return the range of each signal that has one, by port name (the same in every component), in SI units.

    Wheel torques are limited by the motor, speeds by the controller's band about the nominal ones; attitude
    parameters are those of the short rotation. Jitter: all harmonics of a mount in phase at the top of the speed band,
    and four standard deviations of its broadband part.
    """
    wheels, nominal = design.config.wheel_set, design.plant.nominal_speed
    most, widest = float(wheels.torque_limit.max()), float(wheels.speed_band.max())
    torque, band = (-most, most), (-widest, widest)
    speed = (float(np.min(nominal - wheels.speed_band)), float(np.max(nominal + wheels.speed_band)))
    ranges: dict[str, Range] = {
        "wheel.torque": torque,
        "reference.torque": torque,
        "applied.wheel.torque": torque,
        "wheel.speed": speed,
        "encoder.speed": speed,
        "reference.wheel.speed": band,
        "estimate.wheel.speed": band,
        "attitude.quaternion": (-1.0, 1.0),
        "star_tracker.quaternion": (-1.0, 1.0),
        **dict.fromkeys(("attitude.mrp", "star_tracker.mrp", "reference.mrp", "estimate.mrp"), (-1.0, 1.0)),
        **dict.fromkeys(("rate", "gyro_site.rate"), (-STABLE_RATE, STABLE_RATE)),
        "rms_deformation": (0.0, None),
        "energy": (0.0, None),
        "command.start_time": (0.0, None),
    }
    for name, bound in zip(JITTER, _jitter_bounds(design), strict=True):
        ranges[name] = (-bound, bound)
    return ranges


def _jitter_bounds(design: Design) -> list[float]:
    """Return the largest component on any mount: force x, y, z [N], torque x, y, z [N.m]."""
    sensors, wheels = design.sensors, design.config.wheel_set
    square = (np.abs(sensors.nominal_speed) + wheels.speed_band) ** 2
    force = (wheels.imbalance_force + wheels.harmonic_force.sum(axis=1)) * square + SIGMAS * wheels.broadband_force
    torque = (wheels.imbalance_torque + wheels.harmonic_torque.sum(axis=1)) * square + SIGMAS * wheels.broadband_torque
    bounds = np.abs(sensors.wrench_of_jitter) @ np.concatenate([force, force, torque, torque])
    return [float(np.max(part)) for part in np.split(bounds, len(JITTER))]


def range_text(port: Port, ranges: dict[str, Range]) -> str:
    """Return a port's range as text: declared limits for parameters, bounds of the loop for signals."""
    if port.kind == "boolean":
        return "false, true"
    low, high = ranges.get(port.name, (None, None))
    if port.causality == "parameter":
        low, high = port.minimum, port.maximum
    match low, high:
        case None, None:
            return "any"
        case _, None:
            return f"≥ {low:.4g}"
        case None, _:
            return f"≤ {high:.4g}"
    return f"±{high:.4g}" if low == -high else f"{low:.4g} to {high:.4g}"  # type: ignore[operator]
