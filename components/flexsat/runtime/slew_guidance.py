"""Run-time slew guidance: bang-coast-bang about a fixed axis, shaped for the mode that it excites most. numpy alone.

The rigid profile drives momentum up at 80 % of the torque, coasts at 80 % of the speed band, and comes back. The
feed-forward torque is that profile's torque through a three-tap filter with zeros at one flexible pole, centred on the
profile: its middle tap is now. Two references follow from it (PHYSICS section 6): `smoothed` (the rigid profile
itself, modes at rest) and `time_optimal` (the linear model without gyroscopic terms rolled forward under the shaped
torque).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaper:
    """Filter torque(t) = sum of weight times rigid torque(t + shift): zeros at one pole, unit gain at rest."""

    weights: Array  # (3,)
    shifts: Array  # (3,) [s]: +spacing, 0, -spacing

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """A rest-to-rest rotation about one axis with a trapezoidal rate."""

    axis: Array  # (3,) unit vector
    angle: float  # rad
    start: float  # s
    ramp: float  # s, duration of each of the two torque pulses
    coast_rate: float  # rad/s
    coast: float  # s, between the pulses

    @property
    def end(self) -> float:
        """End of the rigid manoeuvre [s]."""
        return self.start + 2.0 * self.ramp + self.coast

    def rate(self, time: Array) -> Array:
        """Return the rate [rad/s] at times (k,) [s]."""
        if self.ramp == 0.0:
            return np.zeros_like(time)
        rising = (time - self.start) / self.ramp
        falling = (self.end - time) / self.ramp
        return np.asarray(self.coast_rate * np.clip(np.minimum(rising, falling), 0.0, 1.0))

    def rotation(self, time: Array) -> Array:
        """Return the angle turned [rad] at times (k,) [s]: the integral of `rate`."""
        if self.ramp == 0.0:
            return np.zeros_like(time)
        since = np.clip(time - self.start, 0.0, None)
        left = np.clip(self.end - time, 0.0, None)
        up = 0.5 * self.coast_rate * np.minimum(since, self.ramp) ** 2 / self.ramp
        level = self.coast_rate * np.clip(since - self.ramp, 0.0, self.coast)
        down = 0.5 * self.coast_rate * (self.ramp - np.minimum(left, self.ramp) ** 2 / self.ramp)
        return np.asarray(up + level + down)


def plan(rotation: Array, start: float, inertia: Array, torque: Array, momentum: Array) -> Profile:
    """Plan the quickest rest-to-rest rotation within torque and momentum.

    Parameters
    ----------
    rotation : (3,) rotation vector to turn by [rad]
    start : [s]
    inertia : (3, 3) [kg.m2]
    torque, momentum : (3,) capability about each body axis [N.m], [N.m.s]

    Source: P, section 4. The wheels must turn J n: its largest share of the capability decides.
    """
    angle = math.hypot(*rotation.tolist())
    if angle == 0.0:
        return Profile(axis=np.array([1.0, 0.0, 0.0]), angle=0.0, start=start, ramp=0.0, coast_rate=0.0, coast=0.0)
    axis = rotation / angle
    acceleration, rate = capability_about(axis, inertia, torque, momentum)
    rate = min(rate, float(np.sqrt(angle * acceleration)))  # a short turn never reaches the speed limit
    ramp = rate / acceleration
    return Profile(axis=axis, angle=angle, start=start, ramp=ramp, coast_rate=rate, coast=angle / rate - ramp)


def capability_about(axis: Array, inertia: Array, torque: Array, momentum: Array) -> tuple[float, float]:
    """Return the greatest acceleration [rad/s2] and rate [rad/s] about a unit vector; arguments as in `plan`."""
    needed = np.abs(inertia @ axis)
    return 1.0 / float(np.max(needed / torque)), 1.0 / float(np.max(needed / momentum))


def shaper_for_pole(frequency: float, damping_ratio: float, period: float) -> Shaper:
    """Return the three-tap filter with zeros at a pole, on a grid of `period` [s].

    The spacing is the least number of periods at which all weights are positive: just over a quarter of the damped
    period (P, section 4).
    """
    damped = frequency * np.sqrt(1.0 - damping_ratio**2)
    steps = int(np.floor(0.5 * np.pi / (damped * period))) + 1
    spacing = steps * period
    decay = np.exp(-damping_ratio * frequency * spacing)
    weights = np.array([1.0, -2.0 * decay * np.cos(damped * spacing), decay**2])
    return Shaper(weights=weights / weights.sum(), shifts=np.array([spacing, 0.0, -spacing]))
