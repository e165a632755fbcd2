"""Wheels of a layout: how many, their inertia, torque, momentum and imbalance, from the design that flew."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexsat.description.wheel_set import WheelSet
from flexsat.parameters import RPM

from ...runs.flown_design import read_flown


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheels:
    """All wheels of a layout, at their nominal speeds."""

    count: int
    inertia: float  # kg.m2, of all about their own axes
    torque: float  # N.m, limit of the strongest
    turning: float  # N.m, limit of all about body x
    momentum: float  # N.m.s, sum of the magnitudes
    energy: float  # J, of their spin
    slowest: float  # rad/s
    fastest: float  # rad/s
    weight: float  # of all, up to a factor: rotors of one shape and material weigh as inertia to the power 3/5
    imbalance: float  # N, root of the sum of the squares of the lateral forces' amplitudes


def wheels_of(wheels: WheelSet, folder: Path) -> Wheels:
    """Return the wheels of a run of a layout."""
    design = read_flown(folder)
    speed = np.abs(design.nominal_speed)
    return Wheels(
        count=design.wheels,
        inertia=float(wheels.inertia.sum()),
        torque=float(wheels.torque_limit.max()),
        turning=float(np.sum(wheels.torque_limit * np.abs(design.wheel_axis[:, 0]))),
        momentum=float(np.sum(wheels.inertia * speed)),
        energy=float(0.5 * np.sum(wheels.inertia * speed**2)),
        slowest=float(speed.min()),
        fastest=float(speed.max()),
        weight=float(np.sum(wheels.inertia**0.6)),
        imbalance=float(np.sqrt(np.sum((wheels.imbalance_force * speed**2) ** 2))),
    )


ROWS = (
    ("wheels", "1", "count", 1.0),
    ("inertia of all wheels", "kg.m2", "inertia", 1.0),
    ("torque limit of one wheel", "N.m", "torque", 1.0),
    ("torque limit of all about x", "N.m", "turning", 1.0),
    ("momentum stored at nominal speed, all wheels", "N.m.s", "momentum", 1.0),
    ("energy of spin at nominal speed, all wheels", "J", "energy", 1.0),
    ("slowest nominal speed", "rpm", "slowest", RPM),
    ("fastest nominal speed", "rpm", "fastest", RPM),
    ("imbalance force of all wheels, root sum square", "N", "imbalance", 1.0),
)  # title, unit, field, and the value of a unit in SI
