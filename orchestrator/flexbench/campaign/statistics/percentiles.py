"""Estimate percentiles with bounds from order statistics, which hold for any continuous distribution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array

CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class Percentile:
    """A percentile of a sample, and the bounds that hold that of the distribution with the stated confidence."""

    share: float  # 0 to 1
    value: float
    low: float  # -inf if the sample is too small for a bound
    high: float  # inf if the sample is too small, or if lost runs count as infinite
    count: int

    @property
    def half_width(self) -> float:
        """Half of the distance between the bounds, as a share of the value; inf if there is no bound."""
        if not (math.isfinite(self.low) and math.isfinite(self.high)):
            return math.inf
        if self.low == self.high:
            return 0.0
        return 0.5 * (self.high - self.low) / abs(self.value) if self.value else math.inf


def ranks(count: int, share: float, confidence: float = CONFIDENCE) -> tuple[int | None, int | None]:
    """Return the ranks, from 1, of the order statistics that bound a percentile; None where the sample is too small.

    The number of samples below the percentile is binomial, whatever the distribution. Each bound fails with a
    probability of at most (1 - confidence) / 2, so that the interval is conservative.

    Parameters
    ----------
    count : number of samples
    share : of the percentile, 0 to 1, exclusive
    confidence : of both bounds together

    References
    ----------
    Conover (1999), Practical Nonparametric Statistics, 3rd ed., section 3.2. `scipy.stats.quantile_test` has the same
    interval, but sorts the sample for each percentile.
    """
    from scipy.stats import binom  # here, as margins and health need CONFIDENCE alone and start without it

    tail = 0.5 * (1.0 - confidence)
    low, high = int(binom.ppf(tail, count, share)), int(binom.isf(tail, count, share)) + 1
    return (low if low >= 1 else None), (high if high <= count else None)


def percentile(ordered: Array, share: float, confidence: float = CONFIDENCE) -> Percentile:
    """Return a percentile of samples in ascending order, which may end or begin with infinite ones.

    Parameters
    ----------
    ordered : (n,), one or more
    share : 0 to 1, exclusive
    confidence : of both bounds together

    Returns
    -------
    Percentile
        The value is the median-unbiased estimate of Hyndman and Fan (1996), number 8.
    """
    count = len(ordered)
    low, high = ranks(count, share, confidence)
    return Percentile(
        share=share,
        value=_median_unbiased(ordered, share),
        low=-math.inf if low is None else float(ordered[low - 1]),
        high=math.inf if high is None else float(ordered[high - 1]),
        count=count,
    )


def runs_for_bound(share: float, confidence: float = CONFIDENCE) -> int:
    """Return the least number of runs whose percentile has both bounds; Wilks (1941) for the upper one alone."""
    tail = 0.5 * (1.0 - confidence)
    return math.ceil(math.log(tail) / math.log(max(share, 1.0 - share)))


def runs_for_width(found: Percentile, within: float) -> int | None:
    """Return about how many runs bring the half-width of a percentile's bounds to a share of its value.

    The width falls with the root of the number of runs. None if the sample is too small to say.
    """
    half_width = found.half_width
    if half_width <= within:
        return found.count
    if not math.isfinite(half_width):
        return None
    return math.ceil(found.count * (half_width / within) ** 2)


def _median_unbiased(ordered: Array, share: float) -> float:
    """Return the estimate between two order statistics; without arithmetic on infinite ones where none is needed."""
    position = (len(ordered) + 1.0 / 3.0) * share + 1.0 / 3.0 - 1.0
    position = min(max(position, 0.0), len(ordered) - 1.0)
    below = int(position)
    part = position - below
    if part == 0.0 or ordered[below] == ordered[min(below + 1, len(ordered) - 1)]:
        return float(ordered[below])
    return float((1.0 - part) * np.float64(ordered[below]) + part * np.float64(ordered[below + 1]))
