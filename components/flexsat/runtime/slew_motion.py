"""The planned rotation about one axis as a piecewise linear rate, whatever guidance planned it. numpy alone.

Its number of knots is that of the guidance, so that a saved state always has the same shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from .slew_guidance import Profile, Shaper


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A rotation about one axis, fixed in the body: it begins and ends at rest. No slew has the angle 0."""

    axis: Array  # (3,) unit vector
    angle: float  # rad, turned by the torque that is held over periods
    times: Array  # (k,) [s], increasing
    rates: Array  # (k,) [rad/s]
    turned: Array  # (k,) [rad]: integral of the rate
    start: float  # s
    end: float  # s
    scale: float  # of the rate that is flown: a torque held over periods then turns by the angle

    def __post_init__(self) -> None:
        make_read_only(self)

    def rate(self, time: Array) -> Array:
        """Return the rate [rad/s] at times (n,) [s]."""
        return np.interp(time, self.times, self.rates)

    def rotation(self, time: Array) -> Array:
        """Return the angle turned [rad] at times (n,) [s]: the integral of `rate`."""
        time = np.clip(time, self.times[0], self.times[-1])
        before = np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 1)
        since = time - self.times[before]
        return np.asarray(self.turned[before] + 0.5 * since * (self.rates[before] + self.rate(time)))


def still(knots: int, start: float = 0.0) -> Motion:
    """Return the motion of no slew."""
    axis = np.array([1.0, 0.0, 0.0])
    return _motion(axis, start + np.arange(2.0), np.zeros(2), knots, angle=0.0, scale=1.0)


def from_profile(profile: Profile, knots: int, period: float, phase: float) -> Motion:
    """Return the motion of a trapezium, whose torque will be held over periods that begin at `phase` [s]."""
    corners = profile.start + np.array([0.0, profile.ramp, profile.ramp + profile.coast, profile.end - profile.start])
    rates = np.array([0.0, profile.coast_rate, profile.coast_rate, 0.0])
    return from_knots(profile.axis, profile.angle, corners, rates, knots, period, phase)


def from_knots(
    axis: Array, angle: float, times: Array, rates: Array, knots: int, period: float, phase: float
) -> Motion:
    """Return the motion with these rates, scaled so that held torques turn by exactly `angle` [rad].

    A torque held over a period changes the rate as the motion does, and between the samples the rate is a straight
    line: each corner inside a period moves the angle by at most its change of slope times T^2/8.
    """
    turned = _sampled_angle(times, rates, period, phase)
    scale = angle / turned if turned > 0.0 else 1.0
    return _motion(axis, times, rates, knots, angle=angle, scale=scale)


def stopped(motion: Motion, time: float, deceleration: float, period: float, phase: float) -> Motion:
    """Return the motion braked from `time` [s] on [rad/s2]; unchanged if it would not end earlier."""
    rate = float(motion.rate(np.array([time]))[0])
    end = time + rate / deceleration
    kept = motion.times < time
    if end >= motion.end or not kept.any() or np.count_nonzero(kept) + 2 > len(motion.times):
        return motion
    times = np.concatenate([motion.times[kept], [time, end]])
    rates = np.concatenate([motion.rates[kept], [rate, 0.0]])
    angle = motion.scale * _sampled_angle(times, rates, period, phase)
    return _motion(motion.axis, times, rates, len(motion.times), angle=angle, scale=motion.scale)


def shaped_rate_change(motion: Motion, shaper: Shaper, time: float, period: float) -> float:
    """Return the change of rate [rad/s] that the shaped torque makes over [time, time + period) [s].

    The difference of the rate at both ends, so that no impulse is lost where a pulse begins between samples.
    """
    ends = motion.rate(np.concatenate([time + shaper.shifts, time + period + shaper.shifts]))
    return motion.scale * float(shaper.weights @ (ends[3:] - ends[:3]))


def _motion(axis: Array, times: Array, rates: Array, knots: int, *, angle: float, scale: float) -> Motion:
    start, end = float(times[0]), float(times[-1])
    keep = np.concatenate([[True], np.diff(times) > 0.0])  # a triangle has no coast
    times, rates = times[keep], rates[keep]
    more = knots - len(times)
    times = np.concatenate([times, times[-1] + 1.0 + np.arange(more)])
    rates = np.concatenate([rates, np.zeros(more)])
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(times))])
    return Motion(axis=axis, angle=angle, times=times, rates=rates, turned=turned, start=start, end=end, scale=scale)


def _sampled_angle(times: Array, rates: Array, period: float, phase: float) -> float:
    """Return the angle under straight lines between samples of the rate, at `phase` plus whole periods."""
    lengths = np.diff(times)
    slopes = np.divide(np.diff(rates), lengths, out=np.zeros(len(lengths)), where=lengths > 0.0)
    change = np.diff(slopes, prepend=0.0, append=0.0)
    part = np.mod((times - phase) / period, 1.0)
    exact = float(np.sum(0.5 * (rates[1:] + rates[:-1]) * lengths))
    return exact + float(0.5 * period**2 * (change @ (part * (1.0 - part))))
