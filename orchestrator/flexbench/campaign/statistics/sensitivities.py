"""Which inputs a metric depends on: rank correlations of any sample, Sobol indices of a Saltelli sample."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import norm, qmc, rankdata, sobol_indices

from flexsat.arrays import Array
from lockstep import InputError

from .percentiles import CONFIDENCE

LEAST_RUNS = 10  # of a rank correlation with bounds
_RESAMPLES = 1000  # of the bootstrap


@dataclass(frozen=True, slots=True, kw_only=True)
class RankCorrelation:
    """How far a metric rises (1) or falls (-1) with an input, whatever the shape of the rise."""

    input: str
    value: float
    low: float
    high: float

    @property
    def visible(self) -> bool:
        """Whether the bounds exclude zero."""
        return self.low > 0.0 or self.high < 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SobolIndex:
    """Shares of a metric's variance: of an input alone, and with all its interactions."""

    input: str
    first: float
    first_low: float
    first_high: float
    total: float
    total_low: float
    total_high: float


def rank_correlations(
    inputs: Mapping[str, Array], values: Array, confidence: float = CONFIDENCE
) -> list[RankCorrelation]:
    """Return Spearman's rank correlation of a metric with each input, the largest first.

    Parameters
    ----------
    inputs : (runs,) each; one that does not vary has none
    values : (runs,), of the metric; lost runs (not finite) are left out
    confidence : of each pair of bounds, from Fisher's transform

    References
    ----------
    Bonett and Wright (2000), Psychometrika 65(1), 23-28, for the variance of the transform.
    """
    finite = np.isfinite(values)
    count = int(finite.sum())
    if count < LEAST_RUNS or np.ptp(values[finite]) == 0.0:
        return []
    reach = float(norm.ppf(0.5 * (1.0 + confidence)))
    ranks = rankdata(values[finite])
    found = []
    for name, column in inputs.items():
        chosen = column[finite]
        if not np.all(np.isfinite(chosen)) or np.ptp(chosen) == 0.0:
            continue
        value = float(np.corrcoef(rankdata(chosen), ranks)[0, 1])
        half = reach * math.sqrt((1.0 + 0.5 * value**2) / (count - 3))
        middle = math.atanh(min(max(value, -1.0 + 1e-12), 1.0 - 1e-12))
        low, high = math.tanh(middle - half), math.tanh(middle + half)
        found.append(RankCorrelation(input=name, value=value, low=low, high=high))
    return sorted(found, key=lambda one: -abs(one.value))


def saltelli_points(dimensions: int, base: int, seed: int) -> Array:
    """Return the points of a Saltelli design in the unit cube, base * (dimensions + 2) of them.

    Parameters
    ----------
    dimensions : number of inputs
    base : a power of two
    seed : of the scrambled Sobol sequence

    Returns
    -------
    (runs, dimensions)
        Blocks of `base` points: A, B, then A with column i of B for each input.

    References
    ----------
    Saltelli et al. (2010), Computer Physics Communications 181(2), 259-270.
    """
    if base < 2 or base & (base - 1):
        raise InputError(
            f"Sobol indices: base {base}; must be a power of two, for example {1 << (base.bit_length() or 1)}"
        )
    # 0 and 1 have no finite value of an unbounded distribution
    both = np.clip(qmc.Sobol(2 * dimensions, seed=seed).random(base), 1e-9, 1.0 - 1e-9)
    first, second = both[:, :dimensions], both[:, dimensions:]
    blocks = [first, second]
    for i in range(dimensions):
        mixed = first.copy()
        mixed[:, i] = second[:, i]
        blocks.append(mixed)
    return np.vstack(blocks)


def sobol(names: list[str], values: Array, seed: int = 0, confidence: float = CONFIDENCE) -> list[SobolIndex]:
    """Return the Sobol indices of a metric over the runs of a Saltelli design, with bootstrap bounds.

    Parameters
    ----------
    names : of the inputs, in the order of the design
    values : (base * (inputs + 2),), in the order of `saltelli_points`
    seed : of the bootstrap
    confidence : of each pair of bounds

    Raises
    ------
    InputError
        If a run is lost, or the number of runs is not that of a design: an index has no meaning then.
    """
    count = len(names)
    base, rest = divmod(len(values), count + 2)
    if rest or base < 2 or base & (base - 1):
        raise InputError(f"Sobol indices: {len(values)} runs of {count} inputs are no Saltelli design; it has"
                         f" {count + 2} times a power of two")  # fmt: skip
    if lost := int(np.count_nonzero(~np.isfinite(values))):
        raise InputError(f"Sobol indices: {lost} of {len(values)} runs have no value; the design needs all of them")
    if np.ptp(values) == 0.0:
        return []
    blocks = values.reshape(count + 2, base)
    rng = np.random.default_rng(seed)
    found = _indices(blocks)
    resampled = np.array([_indices(blocks[:, rng.integers(base, size=base)]) for _ in range(_RESAMPLES)])
    tail = 0.5 * (1.0 - confidence)
    low, high = np.quantile(resampled, (tail, 1.0 - tail), axis=0)
    return [
        SobolIndex(
            input=name,
            first=float(found[0, i]),
            first_low=float(low[0, i]),
            first_high=float(high[0, i]),
            total=float(found[1, i]),
            total_low=float(low[1, i]),
            total_high=float(high[1, i]),
        )
        for i, name in enumerate(names)
    ]


def _indices(blocks: Array) -> Array:
    """Return first-order and total indices of each input, (2, inputs), of the metric in the blocks of a design."""
    func: dict[Literal["f_A", "f_B", "f_AB"], Array] = {
        "f_A": blocks[None, 0],
        "f_B": blocks[None, 1],
        "f_AB": blocks[2:, None, :],
    }
    found = sobol_indices(func=func, n=blocks.shape[1])
    return np.array([np.atleast_1d(found.first_order), np.atleast_1d(found.total_order)])
