"""Dry friction in the bearings of reaction wheels: it brakes a wheel against its mount, then holds it. numpy alone.

What brakes the rotor turns the structure: the torque is an internal one and enters where the motor's does, so that
angular momentum is kept as it is under motor torques. Over a step the friction is the constant torque, of at most the
given size, that brings the relative speed at the step's end nearest to zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Index, make_read_only
from ..fixed_order import inverse, product
from .prepared_plant import PreparedPlant


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedFriction:
    """The friction of some wheels, for one prepared plant; it has no state."""

    wheels: Index  # (b,) those with friction
    limits: Array  # (b,) [N.m]
    step_length: float  # s
    wheel_inertia: float  # kg.m2
    mount_speed: Array  # (b, 2 m + 6 + held): axial speed of the mounts at the end of a step
    torque_of_speed: Array  # (b, b) [N.m.s/rad]: coupled through the structure
    held_torque: Index  # (b,) where the wheels' torques stand in the work array of a step

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare(plant: PreparedPlant, limits: Array) -> PreparedFriction:
    """Prepare for the friction torques (n,) [N.m]; wheels of friction 0 turn freely."""
    size, n = 2 * plant.modes + 6, plant.wheels
    wheels = np.flatnonzero(limits > 0.0)
    speed = plant.output_map[size : size + n, :size][wheels]  # of the mounts alone: the rotors' own is added below
    mount_speed = product(speed, plant.whole_step[:size])
    response = mount_speed[:, size + wheels] + np.eye(len(wheels)) * (plant.step_length / plant.wheel_inertia)
    return PreparedFriction(
        wheels=wheels,
        limits=limits[wheels],
        step_length=plant.step_length,
        wheel_inertia=plant.wheel_inertia,
        mount_speed=mount_speed,
        torque_of_speed=inverse(response),
        held_torque=size + wheels,
    )


def add(friction: PreparedFriction, work: Array, momentum: Array, torque: Array) -> None:
    """Add the friction of one step to the wheels' torques, (n,), which also stand in `work`, in place.

    Parameters
    ----------
    friction : of the plant that is stepped
    work : structure state, then what is held over the step, with the gyroscopic terms of the step before: they
        change so little in a step that a wheel which is held turns by less than rounding shows
    momentum : (n,) axial momentum at the step's start [N.m.s]
    torque : (n,) motor torques [N.m]

    Wheels that brake at once are coupled through the structure. A limit that one of them meets leaves the others
    off by their coupling, wheel inertia over that of the structure, until the next step.
    """
    wheels = friction.wheels
    unbraked = (
        friction.mount_speed @ work
        + (momentum[wheels] + friction.step_length * torque[wheels]) / friction.wheel_inertia
    )
    braking = np.clip(-(friction.torque_of_speed @ unbraked), -friction.limits, friction.limits)
    torque[wheels] += braking
    work[friction.held_torque] += braking
