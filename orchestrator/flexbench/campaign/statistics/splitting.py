"""Estimate the probability of a rare event by splitting along time: runs that come near are branched with new noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from lockstep import InputError

from .subset_simulation import Level, RareEvent

_SEEDS = 2**31 - 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Branch:
    """A run: one from the start, or one that follows another run up to a time and then has noise of its own."""

    root: int  # index of the run from the start that it descends from
    parent: int | None  # number of the run that it follows, from 1; None: from the start
    tick: int  # up to which it follows that: all ticks before it
    seed: int  # of the noise from there on


@dataclass(frozen=True, slots=True, kw_only=True)
class Path:
    """The rises of a run's response to values not reached before: all that splitting needs to know of it."""

    ticks: tuple[int, ...]  # of the rows at which the response rose
    values: tuple[float, ...]  # rising

    @property
    def largest(self) -> float:
        """Return the largest response."""
        return self.values[-1] if self.values else -math.inf

    def first_above(self, level: float) -> int:
        """Return the tick of the first row above a level."""
        return self.ticks[int(np.searchsorted(self.values, level, side="right"))]

    def until(self, tick: int) -> Path:
        """Return the path up to a row, that row included."""
        count = int(np.searchsorted(self.ticks, tick, side="right"))
        return Path(ticks=self.ticks[:count], values=self.values[:count])

    def followed_by(self, other: Path) -> Path:
        """Return this path and the rises of a later one above it."""
        rises = [(tick, value) for tick, value in zip(other.ticks, other.values, strict=True) if value > self.largest]
        ticks, values = zip(*rises, strict=True) if rises else ((), ())
        return Path(ticks=self.ticks + ticks, values=self.values + values)


# `simulate(first, branches)` carries out branches, numbered on from `first`, and returns the path of each from its tick
Simulate = Callable[[int, Sequence[Branch]], Sequence[Path]]


def path_of(ticks: NDArray[np.integer[Any]], values: Array) -> Path:
    """Return the path of a response at rising ticks."""
    before = np.concatenate([[-math.inf], np.maximum.accumulate(values)[:-1]])
    rises = values > before
    return Path(ticks=tuple(int(one) for one in ticks[rises]), values=tuple(float(one) for one in values[rises]))


def splitting(
    simulate: Simulate,
    threshold: float,
    last: int,
    *,
    samples: int = 300,
    killed: float = 0.5,
    most_runs: int = 3000,
    seed: int = 1,
) -> RareEvent:
    """Return the probability that the largest response of a run over time exceeds a threshold.

    At each level the runs whose largest response is not above it, at least a share `killed`, are ended. Each is
    replaced by a branch of one of the others: it follows that one to its first row above the level, and has new noise
    from there on. The estimate has no bias, whatever the number of runs, if what follows a tick depends on the state
    after it and on new noise alone.

    Parameters
    ----------
    simulate : carries out runs
    threshold : the event is a larger response
    last : tick at which runs end, and of the last row
    samples : runs at once
    killed : share of runs that a level ends
    most_runs : all levels together
    seed : of the choice of runs and of their noise

    Raises
    ------
    InputError
        If a setting is out of range.

    References
    ----------
    Brehier, Gazeau, Goudenege, Lelievre, Rousset (2016), Annals of Applied Probability 26(6), 3559-3601: generalized
    adaptive multilevel splitting in discrete time, equal responses included. The deviation is that between the
    families of the first runs: Lee and Whiteley (2018), Biometrika 105(3), 609-625.
    """
    if samples < 2 or not 0.0 < killed < 1.0 or samples > most_runs:
        raise InputError(f"splitting: {samples} runs with a share of {killed:g} ended; at least 2, at most {most_runs}")
    rng = np.random.default_rng(seed)
    first = [Branch(root=k, parent=None, tick=0, seed=_drawn(rng)) for k in range(samples)]
    paths = list(simulate(1, first))
    numbers, roots = list(range(1, samples + 1)), list(range(samples))
    order = min(samples - 1, max(1, round(killed * samples))) - 1
    levels: list[Level] = []
    runs, fresh = samples, samples
    while True:
        largest = np.array([path.largest for path in paths])
        limit = min(float(np.partition(largest, order)[order]), threshold)
        above = largest > limit
        share = float(above.mean())
        families = len({roots[k] for k in np.flatnonzero(above)})
        levels.append(Level(threshold=limit, probability=share, deviation=_deviation(share, samples),
                            acceptance=families / samples, runs=fresh))  # fmt: skip
        ended = np.flatnonzero(~above)
        reached = limit >= threshold
        if reached or not share or runs + len(ended) > most_runs:
            break
        parents = rng.choice(np.flatnonzero(above), size=len(ended))
        branches: dict[int, Branch] = {}
        for k, parent in zip(ended.tolist(), parents.tolist(), strict=True):
            tick = paths[parent].first_above(limit)
            paths[k], numbers[k], roots[k] = paths[parent].until(tick), numbers[parent], roots[parent]
            if tick < last:  # else nothing follows
                branches[k] = Branch(root=roots[parent], parent=numbers[parent], tick=tick + 1, seed=_drawn(rng))
        found = simulate(runs + 1, tuple(branches.values()))
        for number, (k, after) in enumerate(zip(branches, found, strict=True), start=runs + 1):
            paths[k], numbers[k] = paths[k].followed_by(after), number
        runs, fresh = runs + len(branches), len(branches)
    deviation, effective = _between_families([roots[k] for k in np.flatnonzero(above)], samples)
    return RareEvent(
        probability=math.prod(level.probability for level in levels),
        deviation=deviation,
        deviation_most=deviation,
        levels=tuple(levels),
        runs=runs,
        reached=reached and share > 0.0,
        points=np.empty((0, 0)),
        responses=largest[above],
        method="branches",
        families=effective,
    )


def _drawn(rng: np.random.Generator) -> int:
    return 1 + int(rng.random() * _SEEDS)


def _deviation(share: float, samples: int) -> float:
    return math.sqrt((1.0 - share) / (share * samples)) if share else 0.0


def _between_families(roots: Sequence[int], samples: int) -> tuple[float, float]:
    """Return the relative standard deviation, from how the runs with the event are spread over the first runs.

    And over how many equal families they would be as unevenly spread. Families are independent, so that pairs of runs
    of different families give the square of the probability without bias (Lee and Whiteley); the square of the
    estimate, which all pairs give, is larger by the variance. With one family that is unknown, infinite.
    """
    if not len(roots):
        return math.inf, 1.0
    sizes = np.unique(np.array(roots), return_counts=True)[1] / len(roots)
    if len(sizes) == 1:
        return math.inf, 1.0
    uneven = float(np.sum(sizes**2))
    return math.sqrt(max(0.0, uneven - 1.0 / samples) / (1.0 - uneven)), 1.0 / uneven
