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
    wheel_inertia: Array  # (b,) [kg.m2]
    mount_speed: Array  # (b, vector): axial speed of the mounts at the end of a step, from the state's vector
    torque_of_speed: Array  # (b, b) [N.m.s/rad]: coupled through the structure
    load_of_torque: Array  # (r, b)

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare(plant: PreparedPlant, limits: Array) -> PreparedFriction:
    """Prepare for the friction torques (n,) [N.m]; wheels of friction 0 turn freely."""
    m, n = plant.modes, plant.wheels
    wheels = np.flatnonzero(limits > 0.0)
    speed = plant.output_map[6 : 6 + n][wheels]  # of the mounts alone: the rotors' own is added below
    count = len(plant.observed) - plant.accelerometers
    mount = product(speed[:, :count], plant.observed[:count])  # from the vector, at any time
    of_z, of_momentum = mount[:, : 2 * m], mount[:, 2 * m : 2 * m + 6]
    at_end = plant.motion.free.transition(plant.step_length)[0].after(of_z)
    of_load = product(mount[:, : 2 * m + 6], plant.driven[:-3])
    load_of_torque = plant.load_of_input[:, wheels]
    response = product(of_load, load_of_torque) + np.diag(plant.step_length / plant.wheel_inertia[wheels])
    return PreparedFriction(
        wheels=wheels,
        limits=limits[wheels],
        step_length=plant.step_length,
        wheel_inertia=plant.wheel_inertia[wheels],
        mount_speed=np.hstack([at_end, of_momentum, of_load]),
        torque_of_speed=inverse(response),
        load_of_torque=load_of_torque,
    )


def add(friction: PreparedFriction, vector: Array, momentum: Array, torque: Array, load: Array) -> None:
    """Add the friction of one step to the wheels' torques, (n,), and to the loads of the inputs, (r,), in place.

    Parameters
    ----------
    friction : of the plant that is stepped
    vector : of the state, with the loads of this step; its gyroscopic terms are those of the step before: they change
        so little in a step that a wheel which is held turns by less than rounding shows
    momentum : (n,) axial momentum at the step's start [N.m.s]
    torque : (n,) motor torques [N.m]
    load : (r,) of the inputs

    Wheels that brake at once are coupled through the structure. A limit that one of them meets leaves the others
    off by their coupling, wheel inertia over that of the structure, until the next step.
    """
    wheels = friction.wheels
    unbraked = (
        friction.mount_speed @ vector
        + (momentum[wheels] + friction.step_length * torque[wheels]) / friction.wheel_inertia
    )
    braking = np.clip(-(friction.torque_of_speed @ unbraked), -friction.limits, friction.limits)
    torque[wheels] += braking
    load += friction.load_of_torque @ braking
