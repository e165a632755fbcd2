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

from ..allocation import least_peak, least_squares
from ..arrays import Array, make_read_only
from ..fixed_order import inverse, product


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheels:
    """What each wheel may give to a slew, and the ways to divide a body torque between the wheels.

    The torque of a slew acts about one axis, so that each wheel has a fixed share of it; which division is the quickest
    depends on the slew: torques limit short ones, momentum long ones.
    """

    axes: Array  # (n, 3)
    limits: Array  # (k, n): weights of the divisions, relative to the largest
    allocations: Array  # (k, n, 3): wheel torques of a body torque, by least squares over these weights
    by_peak: bool  # divide by the least peak share of the limits instead
    per_torque: Array  # (n,) [1/(N.m)]: one over the torque that it may give; 0 for a wheel that has none
    per_rise: Array  # (n,) [1/(N.m.s)]: one over the momentum that it can still gain
    per_fall: Array  # (n,) [1/(N.m.s)]: one over the momentum that it can still lose

    def __post_init__(self) -> None:
        make_read_only(self)


def wheels_for(axes: Array, torque: Array, momentum: Array, offset: Array, by_peak: bool = False) -> Wheels:
    """Return what wheels of unequal limits may give.

    Parameters
    ----------
    axes : (n, 3) unit vectors
    torque, momentum : (n,) that a slew may use [N.m], [N.m.s]
    offset : (n,) momentum at rest [N.m.s], beside that of the nominal speed
    by_peak : divide torques so that the largest share of a wheel's limit is the least, not the sum of squares

    Raises
    ------
    ValueError
        If a wheel stands beyond the momentum that it may use, or no wheel gives a torque about some axis.
    """
    equal = product(axes, inverse(product(axes.T, axes)))
    # the regulator drives offsets that need no net momentum back to zero: both ends of that are provided for
    kept = product(equal, product(axes.T, offset))
    rise, fall = momentum - np.maximum(offset, kept), momentum + np.minimum(offset, kept)
    if np.any(short := np.minimum(rise, fall) <= 0.0):
        k = int(np.flatnonzero(short)[0])
        raise ValueError(
            f"wheel.speed_offset: wheel {k + 1} has {momentum[k] - min(rise[k], fall[k]):.4g} N.m.s at rest, of"
            f" {momentum[k]:.4g} N.m.s that a slew may use; set the offset lower, or slew.authority or wheel.speed_band"
            " higher"
        )
    works = torque > 0.0
    by_momentum, by_torque = (
        weight / max(float(weight.max()), 1e-300) for weight in (np.minimum(rise, fall) * works, torque)
    )
    alike = np.array_equal(by_momentum, by_torque)
    weights = [by_momentum] if alike else [by_momentum, by_torque, np.sqrt(by_momentum * by_torque)]
    try:
        allocations = [least_squares(axes, weight) for weight in weights]
    except np.linalg.LinAlgError:
        raise ValueError(
            "wheel.torque_limit_factor: the wheels that have torque cannot turn the body about all axes"
        ) from None
    return Wheels(
        axes=axes,
        limits=np.array(weights),
        by_peak=by_peak,
        allocations=np.array(allocations),
        per_torque=np.divide(1.0, torque, out=np.zeros_like(torque), where=works),
        per_rise=1.0 / rise,
        per_fall=1.0 / fall,
    )


def share_of(wheels: Wheels, division: int, torque: Array) -> Array:
    """Return the wheel torques (n,) of a body torque (3,) by one of the divisions."""
    if wheels.by_peak:
        return least_peak(wheels.axes, wheels.limits[division], torque)
    share: Array = wheels.allocations[division].dot(torque)  # of their class, which may sum in a fixed order
    return share


def limits_about(wheels: Wheels, needed: Array) -> tuple[Array, Array]:
    """Return the greatest accelerations and rates [rad/s2], [rad/s], (k, m), by allocation.

    Parameters
    ----------
    wheels : what they may give
    needed : (3, m) inertia times the axes of the slews [kg.m2]
    """
    if wheels.by_peak:
        share = np.array([[least_peak(wheels.axes, limits, one) for one in needed.T] for limits in wheels.limits])
    else:
        share = (wheels.allocations @ needed).swapaxes(1, 2)  # (k, m, n)
    torque = (np.abs(share) * wheels.per_torque).max(axis=2)
    momentum = np.maximum(share * wheels.per_rise, -share * wheels.per_fall).max(axis=2)
    return 1.0 / torque, 1.0 / momentum


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
    axis, angle = axis_of(rotation)
    return trapezium(axis, angle, start, *capability_about(axis, inertia, torque, momentum))


def axis_of(rotation: Array) -> tuple[Array, float]:
    """Return unit vector and angle of a rotation vector [rad]; the x axis for none."""
    angle = math.hypot(*rotation.tolist())
    return (rotation / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])), angle


def trapezium(axis: Array, angle: float, start: float, acceleration: float, rate: float) -> Profile:
    """Return the quickest rest-to-rest rotation about an axis, within acceleration [rad/s2] and rate [rad/s]."""
    if angle == 0.0:
        return Profile(axis=axis, angle=0.0, start=start, ramp=0.0, coast_rate=0.0, coast=0.0)
    rate = min(rate, float(np.sqrt(angle * acceleration)))  # a short turn never reaches the speed limit
    ramp = rate / acceleration
    return Profile(axis=axis, angle=angle, start=start, ramp=ramp, coast_rate=rate, coast=angle / rate - ramp)


def durations(angles: Array, acceleration: Array, rate: Array) -> Array:
    """Return how long rest-to-rest turns by angles [rad] last [s], all of one shape."""
    peak = np.minimum(rate, np.sqrt(angles * acceleration))
    return np.asarray(angles / np.where(peak > 0.0, peak, 1.0) + peak / acceleration)


def remaining_duration(angle: float, acceleration: float, rate: float, initial: float) -> float:
    """Return how long a turn by an angle [rad], from an initial rate [rad/s] to rest, lasts at least [s].

    The angle must be at least that of braking from the initial rate.
    """
    peak = min(max(rate, initial), math.sqrt(angle * acceleration + 0.5 * initial**2))
    coast = (angle - (peak**2 - 0.5 * initial**2) / acceleration) / peak
    return (2.0 * peak - initial) / acceleration + max(0.0, coast)


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
