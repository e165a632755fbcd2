"""Dry friction in the bearings of reaction wheels: it brakes a wheel against its mount, then holds it. numpy alone.

What brakes the rotor turns the structure: the torque is an internal one and enters where the motor's does, so that
angular momentum is kept as it is under motor torques. Over a step the friction is the constant torque, of at most the
given size, that brings the relative speed at the step's end nearest to zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array

if TYPE_CHECKING:
    from .plant import Plant


class Bearings:
    """The friction of some wheels, prepared for one plant and its step. No state."""

    def __init__(self, plant: Plant, limits: Array) -> None:
        """Prepare for the friction torques (n,) [N.m]; wheels of friction 0 turn freely."""
        size, n = 2 * plant.modes + 6, plant.wheels
        self._wheels = wheels = np.flatnonzero(limits > 0.0)
        self._limits = limits[wheels]
        self._step, self._inertia = plant.step_length, plant.matrices.wheel_inertia
        speed = plant.output_map[size : size + n, :size][wheels]  # of the mounts alone: the rotors' own is added below
        self._mount_speed = np.ascontiguousarray(speed @ plant.whole_step[:size])
        response = self._mount_speed[:, size + wheels] + np.eye(len(wheels)) * (self._step / self._inertia)
        self._torque_of_speed = np.linalg.inv(response)
        self._places = size + wheels

    def add(self, work: Array, momentum: Array, torque: Array) -> None:
        """Add the friction of one step to the wheels' torques, (n,), which also stand in `work`, in place.

        Parameters
        ----------
        work : structure state, then what is held over the step, with the gyroscopic terms of the step before: they
            change so little in a step that a wheel which is held turns by less than rounding shows
        momentum : (n,) axial momentum at the step's start [N.m.s]
        torque : (n,) motor torques [N.m]

        Wheels that brake at once are coupled through the structure. A limit that one of them meets leaves the others
        off by their coupling, wheel inertia over that of the structure, until the next step.
        """
        wheels = self._wheels
        free = self._mount_speed @ work + (momentum[wheels] + self._step * torque[wheels]) / self._inertia
        friction = np.clip(-(self._torque_of_speed @ free), -self._limits, self._limits)
        torque[wheels] += friction
        work[self._places] += friction
