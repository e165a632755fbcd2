"""Find in the rows of a run what a loop does that it should not.

Torque saturation, wheels outside their speed band, limit cycles, divergence. For any controller of the plant: only the
torque that it commands, and what the plant does, are looked at. The rows come block by block; how they are divided
does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.parameters import DEGREE
from flexsat.ports.plant import FASTEST
from lockstep.results.monitor import Found

from .episodes import Details, Episodes, Slices

AT_LIMIT = 1.0 - 1e-9  # share of a limit: a torque that was limited differs from it by rounding
SLICE = 0.25  # s: four slices are the second for which a limit cycle is seen
CYCLE = 0.2  # RMS of a wheel's torque over its limit, about its mean, in each slice: a sine of 28 % of the limit
GROWN = 0.12  # the same of one that grows: twice what the coarse star tracker makes of the published designs
GROWTH = 1.4  # from the first slice of a second to its last
CROSSINGS = 3  # of the mean in a second: slower changes are those of commands
CROSSINGS_GROWING = 6  # what a slew excites grows for a second too, but at the lowest modes
KEPT = 0.8  # of the first slice's level in the last: what a command excites decays
FEWEST_ROWS = 4  # in a slice
LARGEST = 0.025  # m, thickness of the plate: beyond it bending is not linear
LOST = 0.1 * DEGREE  # rad of pointing error, from which on it may not grow
LOSING = 5  # s for which it grows, to twice what it was


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Rows of a run. What is None is not recorded."""

    time: Array  # (k,) [s]
    torque: Array | None = None  # (k, n) commanded to each wheel [N.m]
    guidance: Array | None = None  # (k, n) feed-forward part of it [N.m]
    speed: Array | None = None  # (k, n) of each wheel less its nominal speed [rad/s]
    error: Array | None = None  # (k,) pointing error [rad]
    rate: Array | None = None  # (k, 3) of the body [rad/s]
    deformation: Array | None = None  # (k,) [m]


class LoopEvents:
    """What is found in the rows of one run."""

    def __init__(
        self, *, torque_limit: Array | float, speed_band: Array | float | None, details: Mapping[str, object]
    ) -> None:
        """Prepare for wheels of a torque limit [N.m] and a band [rad/s] about their nominal speeds, None for none.

        Both may be those of each wheel, (n,). A wheel with a torque limit of 0 is not used, and never at its limit.
        """
        fixed = dict(details)
        self._limit, self._band = np.where(np.equal(torque_limit, 0.0), np.inf, torque_limit), speed_band
        self._saturated = Episodes(event="torque-saturation", fixed=fixed | {"limit": _shown(torque_limit)})
        self._left = Episodes(
            event="speed-band-left", fixed=fixed | {"band": _shown(0.0 if speed_band is None else speed_band)}
        )
        self._cycle = Episodes(event="limit-cycle", fixed=fixed)
        self._lost, self._fast, self._bent = (
            Episodes(event="divergence", fixed=fixed | {"quantity": name})
            for name in ("pointing error", "rate", "deformation")
        )
        self._slices = Slices(SLICE, 4)
        self._seconds = Slices(1.0, 1)
        self._errors: list[float] = []  # RMS of the pointing error in the last seconds
        self._peak = 0.0  # of them since it was lost
        self._before: tuple[float, Array] | None = None  # time and speeds of the row before
        self._torque = self._frequency = 0.0  # of the strongest second of a limit cycle
        self._last = 0.0  # s, time of the last row

    def rows(self, rows: Rows) -> Iterator[Found]:
        """Yield what these rows show."""
        if not len(rows.time):
            return
        self._last = float(rows.time[-1])
        if rows.torque is not None:
            wheels = np.abs(rows.torque) >= AT_LIMIT * self._limit
            yield from self._saturated.feed(rows.time, np.atleast_1d(wheels.any(axis=1)), wheels=wheels)
            yield from self._cycles(rows.time, rows.torque, rows.guidance)
        if rows.speed is not None and self._band is not None:
            yield from self._band_left(rows.time, rows.speed, self._band)
        if rows.error is not None:
            yield from self._pointing_lost(rows.time, rows.error)
        for episodes, values, limit in ((self._fast, rows.rate, FASTEST), (self._bent, rows.deformation, LARGEST)):
            if values is not None:
                beyond = np.abs(values.reshape(len(rows.time), -1)).max(axis=1)
                yield from episodes.feed(rows.time, beyond > limit, details=_value(beyond))

    def end(self) -> Iterator[Found]:
        """Yield what is known when no more rows come."""
        for episodes in self._all():
            yield from episodes.end()

    def summary(self) -> list[Details]:
        """Return a table for each kind that was found: how often, when first, how long in all."""
        return [
            {
                "event": one.event,
                **{key: value for key, value in one.fixed.items() if key == "quantity"},
                "count": one.count,
                "first": one.first,
                "seconds": round(one.total(self._last), 6),
                **({"torque": self._torque, "frequency": self._frequency} if one is self._cycle else {}),
                **({} if one.begin is None or one.over is not None else {"until_the_end": True}),
            }
            for one in self._all()
            if one.count
        ]

    def _all(self) -> Sequence[Episodes]:
        return self._saturated, self._left, self._cycle, self._lost, self._fast, self._bent

    def _cycles(self, time: Array, torque: Array, guidance: Array | None) -> Iterator[Found]:
        """Look at each second in steps of a slice; the mean over it is what is commanded, the rest oscillates."""
        own = torque if guidance is None else torque - guidance
        for end, parts in self._slices.feed(time, np.stack([own, torque], axis=1)):
            if len(parts) < 4 or min(map(len, parts)) < FEWEST_ROWS:
                continue
            second = np.concatenate(parts)
            wheels, frequency, torques = np.zeros(second.shape[2], np.bool_), 0.0, 0.0
            if np.any(np.ptp(second[:, 0], axis=0) >= GROWN * self._limit):  # else no RMS about the mean is as large
                ends = np.cumsum([len(part) for part in parts])[:-1]
                parts = np.split(second[:, 0] - second[:, 0].mean(axis=0), ends)
                wheels, frequency = oscillating(parts, self._limit)
                torques = float(np.mean(np.abs(second[:, 1]).sum(axis=1)))
            if wheels.any() and torques > self._torque:
                self._torque, self._frequency = torques, frequency

            def of_this(_: int, torques: float = torques, frequency: float = frequency) -> Details:
                return {"torque": torques, "frequency": frequency}

            yield from self._cycle.feed(
                np.array([end]),
                np.array([wheels.any()]),
                begins=np.array([end - 4 * SLICE]),
                ends=np.array([end - SLICE]),
                wheels=wheels[np.newaxis],
                details=of_this,
            )

    def _band_left(self, time: Array, speed: Array, band: Array | float) -> Iterator[Found]:
        outside = np.abs(speed) > band
        # when a wheel crosses the edge of its band between two rows
        first = self._before if self._before is not None else (float(time[0]), speed[0])
        times, speeds = np.concatenate([[first[0]], time]), np.abs(np.concatenate([first[1][np.newaxis], speed]))
        self._before = float(time[-1]), speed[-1].copy()
        change = np.diff(speeds, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(change != 0.0, (band - speeds[:-1]) / change, 0.0).clip(0.0, 1.0)
        crossing = times[:-1, np.newaxis] + share * np.diff(times)[:, np.newaxis]
        begins = np.where(outside, crossing, np.inf).min(axis=1)
        ends = np.where(speeds[:-1] > band, crossing, -np.inf).max(axis=1)
        yield from self._left.feed(time, np.atleast_1d(outside.any(axis=1)), begins=begins, ends=ends, wheels=outside)

    def _pointing_lost(self, time: Array, error: Array) -> Iterator[Found]:
        for end, (second,) in self._seconds.feed(time, error):
            self._errors = [*self._errors[-LOSING:], float(np.sqrt(np.mean(second**2))) if len(second) else 0.0]
            now = self._errors[-1]
            self._peak = max(self._peak, now) if self._lost.holding else now
            lost = self._lost.holding and now > 0.5 * self._peak
            yield from self._lost.feed(
                np.array([end]),
                np.array([lost or losing(self._errors)]),
                begins=np.array([end - LOSING]),
                ends=np.array([end - 1.0]),
                details=_value(np.array([now])),
            )


def oscillating(parts: Sequence[Array], limit: Array | float) -> tuple[NDArray[np.bool_], float]:
    """Return which wheels' torques oscillate through a second, at a large part of the limit or growing.

    Parameters
    ----------
    parts : four slices of it, (rows, n) each, less the mean over the second [N.m]
    limit : of a wheel's torque [N.m], or of each (n,)

    Returns
    -------
    wheels, frequency : (n,); [Hz] of the strongest of them, 0 for none
    """
    levels = np.array([np.sqrt(np.mean(part**2, axis=0)) for part in parts]) / limit
    at_limit = (levels >= CYCLE).all(axis=0) & (levels[3] >= KEPT * levels[0])
    growing = (np.diff(levels, axis=0) > 0.0).all(axis=0) & (levels[3] >= GROWN) & (levels[3] >= GROWTH * levels[0])
    wheels = at_limit | growing
    second = np.concatenate(parts)
    counts = {k: _crossings(second[:, k]) for k in np.flatnonzero(wheels)}
    for k, count in counts.items():
        wheels[k] = count >= (CROSSINGS if at_limit[k] else CROSSINGS_GROWING)
    strongest = max((k for k in counts if wheels[k]), key=lambda k: float(levels[:, k].sum()), default=None)
    return wheels, 0.0 if strongest is None else 0.5 * counts[strongest]


def losing(errors: Sequence[float]) -> bool:
    """Return whether the pointing error [rad], one number a second, is lost: large, and growing all the time."""
    grows = len(errors) > LOSING and all(b > a for a, b in pairwise(errors))
    return grows and errors[-1] > LOST and errors[-1] >= 2.0 * errors[0]


def _crossings(values: Array) -> int:
    """Count the changes from one side of zero to the other, without those of small values between them."""
    large = values[np.abs(values) > 0.5 * np.sqrt(np.mean(values**2))]
    return int(np.count_nonzero(np.diff(np.sign(large))))


def _shown(limits: Array | float) -> float | list[float]:
    """Return the limit of all wheels, or where they differ that of each."""
    each: list[float] = np.atleast_1d(limits).tolist()
    return each[0] if len(set(each)) == 1 else each


def _value(values: Array) -> Callable[[int], Details]:
    """Return what says how large a value was in a row."""
    return lambda row: {"value": float(values[row])}
