"""The planned rotation about one axis as a piecewise linear rate, whatever guidance planned it. numpy alone.

Its number of knots is that of the guidance, so that a saved state always has the same shape.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

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
    before: float  # rad, turned before the first knot by the torque that is held, over the scale
    start: float  # s
    end: float  # s
    scale: float  # of the rate that is flown: a torque held over periods then turns by the angle
    allocation: int  # of the torque to the wheels

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


def from_profile(profile: Profile, knots: int, period: float, phase: float, allocation: int = 0) -> Motion:
    """Return the motion of a trapezium, whose torque will be held over periods that begin at `phase` [s]."""
    corners = profile.start + np.array([0.0, profile.ramp, profile.ramp + profile.coast, profile.end - profile.start])
    rates = np.array([0.0, profile.coast_rate, profile.coast_rate, 0.0])
    return from_knots(profile, corners, rates, knots, period, phase, allocation)


def from_knots(
    profile: Profile, times: Array, rates: Array, knots: int, period: float, phase: float, allocation: int = 0
) -> Motion:
    """Return the motion with these rates, scaled so that held torques turn by exactly the profile's angle.

    A torque held over a period changes the rate as the motion does, and between the samples the rate is a straight
    line: each corner inside a period moves the angle by at most its change of slope times T^2/8.
    """
    turned = _sampled_angle(times, rates, period, phase)
    scale = profile.angle / turned if turned > 0.0 else 1.0
    return _motion(profile.axis, times, rates, knots, angle=profile.angle, scale=scale, allocation=allocation)


def continued(
    motion: Motion,
    time: float,
    since: Array,
    rates: Array,
    angle: float | None,
    period: float,
    phase: float,
    memory: float,
) -> Motion | None:
    """Return the motion with other rates from `time` [s] on; None if its knots do not suffice.

    Parameters
    ----------
    motion : in flight
    time : [s] a sample
    since, rates : (k,) knots after it [s], [rad/s], the first at 0 with the rate that is flown then
    angle : at which held torques will end [rad]; None: wherever that is
    period, phase : of the samples [s]
    memory : knots that end earlier before `time` [s] are not needed any more
    """
    cut = time - memory
    if cut > motion.times[0]:
        earlier = motion.times < cut
        old = np.append(motion.times[earlier], cut), np.append(motion.rates[earlier], motion.rate(np.array([cut])))
        before = motion.before + _sampled_angle(*old, period, phase)
        kept = (motion.times > cut) & (motion.times < time)
        times, past = np.append(cut, motion.times[kept]), np.append(old[1][-1], motion.rates[kept])
    else:
        before, kept = motion.before, motion.times < time
        times, past = motion.times[kept], motion.rates[kept]
    begin, first = len(times), float(motion.rotation(times[:1])[0])
    times, rates = np.concatenate([times, time + since]), np.concatenate([past, rates])
    if not begin or len(times) > len(motion.times):
        return None
    if angle is not None:  # rounding, and what held torques turn more than the rates
        more = np.zeros(len(times))
        more[begin:] = since * (since[-1] - since)
        missing = angle / motion.scale - before - _sampled_angle(times, rates, period, phase)
        rates = rates + more * (missing / _sampled_angle(times, more, period, phase))
    flown = motion.scale * (before + _sampled_angle(times, rates, period, phase))
    made = _motion(
        motion.axis,
        times,
        rates,
        len(motion.times),
        angle=flown if angle is None else angle,
        scale=motion.scale,
        allocation=motion.allocation,
        before=before,
        first=first,
    )
    # what is turned ends where held torques do: the difference is spread over the new knots
    turned, at = made.turned.copy(), float(made.rotation(np.array([time]))[0])
    if turned[-1] > at:
        after = made.times > time
        turned[after] += (made.angle - turned[-1]) * (turned[after] - at) / (turned[-1] - at)
    return replace(made, turned=turned, start=motion.start)


def stopped(
    motion: Motion, time: float, deceleration: float, period: float, phase: float, memory: float = np.inf
) -> Motion:
    """Return the motion braked from `time` [s] on [rad/s2]; unchanged if it would not end earlier."""
    rate = float(motion.rate(np.array([time]))[0])
    since = rate / deceleration
    if time + since >= motion.end:
        return motion
    braked = continued(motion, time, np.array([0.0, since]), np.array([rate, 0.0]), None, period, phase, memory)
    return motion if braked is None else braked


def shaped_rate_change(motion: Motion, shaper: Shaper, time: float, period: float) -> float:
    """Return the change of rate [rad/s] that the shaped torque makes over [time, time + period) [s].

    The difference of the rate at both ends, so that no impulse is lost where a pulse begins between samples.
    """
    ends = motion.rate(np.concatenate([time + shaper.shifts, time + period + shaper.shifts]))
    return motion.scale * float(shaper.weights @ (ends[3:] - ends[:3]))


def _motion(
    axis: Array,
    times: Array,
    rates: Array,
    knots: int,
    *,
    angle: float,
    scale: float,
    allocation: int = 0,
    before: float = 0.0,
    first: float = 0.0,
) -> Motion:
    start, end = float(times[0]), float(times[-1])
    keep = np.concatenate([[True], np.diff(times) > 0.0])  # a triangle has no coast
    times, rates = times[keep], rates[keep]
    more = knots - len(times)
    times = np.concatenate([times, times[-1] + 1.0 + np.arange(more)])
    rates = np.concatenate([rates, np.zeros(more)])
    turned = first + np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(times))])
    return Motion(
        axis=axis,
        angle=angle,
        times=times,
        rates=rates,
        turned=turned,
        before=before,
        start=start,
        end=end,
        scale=scale,
        allocation=allocation,
    )


def _sampled_angle(times: Array, rates: Array, period: float, phase: float) -> float:
    """Return the angle under straight lines between samples of the rate, at `phase` plus whole periods."""
    lengths = np.diff(times)
    slopes = np.divide(np.diff(rates), lengths, out=np.zeros(len(lengths)), where=lengths > 0.0)
    change = np.diff(slopes, prepend=0.0, append=0.0)
    part = np.mod((times - phase) / period, 1.0)
    exact = float(np.sum(0.5 * (rates[1:] + rates[:-1]) * lengths))
    return exact + float(0.5 * period**2 * (change @ (part * (1.0 - part))))
