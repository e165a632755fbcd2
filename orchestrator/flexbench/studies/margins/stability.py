"""Exact margins of a periodic loop: the changes of all channels at which its spectral radius reaches one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from lockstep.errors import InputError

from .periodic_loop import PeriodicLoop

LONGEST_DELAY = 0.1  # s, up to which a delay margin is searched
DELAY_STEP = 2.5e-4  # s, between the points of the search, and
DELAY_GROWTH = 1.025  # from one to the next where that is more: a narrower island of instability would be missed
LARGEST_GAIN = 100.0
GAIN_STEP = 1.05
PHASE_STEP = 2.0  # deg
CLOSENESS = 1e-6  # relative, of a margin
LIKENESS = 1e-3  # relative: how near the margin of a large loop is sought to that of a smaller one much like it
SPARSE = 8  # of the points of a search, one in so many is tried on a large loop


@dataclass(frozen=True, slots=True, kw_only=True)
class StabilityMargins:
    """Of all channels together; infinite where nothing was found in the range searched."""

    delay: float  # s, at the plant input, unknown to the controller
    gain_up: float  # factor > 1 at which the loop becomes unstable
    gain_down: float  # factor < 1; 0 if it stays stable down to nothing
    phase: float  # deg, of lag or lead: a factor exp(-+ i phase)
    radius: float  # spectral radius a step, of the loop as it is


def stability_margins(
    loop_at: Callable[[float], PeriodicLoop], scout_at: Callable[[float], PeriodicLoop] | None = None
) -> StabilityMargins:
    """Return the exact margins.

    Parameters
    ----------
    loop_at : the open loop with a further delay [s] at the plant input
    scout_at : the same of a smaller loop with nearly the same margins, if there is one: the margins of the large loop
        are then sought around those, to LIKENESS, and in between at one point in SPARSE. Minutes become seconds.

    Raises
    ------
    InputError
        If the loop is unstable as it is: then it has no margins.
    """
    loop = loop_at(0.0)
    radius = loop.radius()
    if not radius < 1.0:
        raise InputError(f"the closed loop is unstable, spectral radius {radius:.6g}: it has no margins")
    scout = None if scout_at is None else scout_at(0.0)

    def first(turn: Callable[[float], complex], points: list[float]) -> float | None:
        smaller = None if scout is None else (lambda point: scout.radius(turn(point)))
        return _first(lambda point: loop.radius(turn(point)), points, smaller)

    up = first(lambda factor: factor, _factors(GAIN_STEP, LARGEST_GAIN))
    down = first(lambda factor: factor, _factors(1.0 / GAIN_STEP, 1.0 / LARGEST_GAIN))
    phase = first(lambda angle: np.exp(-1j * np.deg2rad(angle)), np.arange(0.0, 181.0, PHASE_STEP).tolist())
    return StabilityMargins(
        delay=delay_margin(loop_at, scout_at=scout_at),
        gain_up=np.inf if up is None else up,
        gain_down=0.0 if down is None else down,
        phase=np.inf if phase is None else phase,
        radius=radius,
    )


def delay_margin(
    loop_at: Callable[[float], PeriodicLoop],
    longest: float = LONGEST_DELAY,
    scout_at: Callable[[float], PeriodicLoop] | None = None,
) -> float:
    """Return the shortest further delay at the plant input that makes the loop unstable [s]; infinite up to `longest`.

    Found by stepping through the delays, and Brent's method within the first step that ends unstable; `scout_at` as in
    `stability_margins`.
    """
    scout = None if scout_at is None else (lambda delay: scout_at(delay).radius())
    found = _first(lambda delay: loop_at(delay).radius(), _delays(longest), scout)
    return np.inf if found is None else found


def _delays(longest: float) -> list[float]:
    points = [0.0]
    while points[-1] < longest:
        points.append(max(points[-1] + DELAY_STEP, points[-1] * DELAY_GROWTH))
    return points


def _factors(step: float, last: float) -> list[float]:
    return [float(step**k) for k in range(int(np.ceil(np.log(last) / np.log(step))) + 1)]


def _first(
    radius: Callable[[float], float], points: list[float], scout: Callable[[float], float] | None = None
) -> float | None:
    """Return where the radius first reaches one: between two points, by Brent's method; None if it does not."""
    if scout is None:
        return _crossing(radius, points, CLOSENESS)
    guess = _crossing(scout, points, CLOSENESS)
    sparse = points[::SPARSE]
    if guess is not None:
        apart = 0.5 * LIKENESS * guess
        sparse = sorted([*sparse, guess - apart, guess + apart], reverse=points[-1] < points[0])
    return _crossing(radius, sparse, LIKENESS)


def _crossing(radius: Callable[[float], float], points: list[float], closeness: float) -> float | None:
    """Return the first crossing, to `closeness`. The radius is smooth there: 5 points find it, bisection takes 15."""
    excess = lru_cache(maxsize=None)(lambda point: radius(point) - 1.0)
    for stable, point in pairwise(points):
        if excess(point) < 0.0:
            continue
        allowed = closeness * max(abs(point), abs(stable))
        if excess(stable) >= 0.0:  # of the first point alone: unstable as it is
            return stable
        if abs(point - stable) <= allowed:
            return 0.5 * (stable + point)
        return float(brentq(excess, stable, point, xtol=0.5 * allowed, rtol=4.0 * np.finfo(float).eps))
    return None
