"""Describe the values of one metric over the runs of a campaign: mean, deviation, percentiles, distribution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import t as student

from flexsat.arrays import Array

from .percentiles import CONFIDENCE, Percentile, percentile

SHARES = (0.05, 0.5, 0.95, 0.99, 0.9973)
Worse = Literal["high", "low"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """One metric over all runs. A lost run has the worst value there is: it counts in percentiles, not in the mean."""

    name: str
    unit: str
    count: int  # of all runs
    lost: int  # runs without a value
    mean: float  # of runs with a value, with its bounds; NaN without any
    mean_low: float
    mean_high: float
    deviation: float  # standard deviation; NaN for one run
    least: float
    most: float
    percentiles: tuple[Percentile, ...]

    @property
    def mean_error(self) -> float:
        """Half of the distance between the bounds of the mean, as a share of the mean; inf without bounds."""
        reach = 0.5 * (self.mean_high - self.mean_low)
        if not math.isfinite(reach):
            return math.inf
        return reach / abs(self.mean) if self.mean else math.inf if reach else 0.0


def ordered(values: Array, worse: Worse = "high") -> Array:
    """Return values in ascending order, those that are not finite as the worst there is."""
    return np.sort(np.where(np.isfinite(values), values, math.inf if worse == "high" else -math.inf))


def describe(
    name: str,
    values: Array,
    *,
    unit: str = "",
    worse: Worse = "high",
    shares: Sequence[float] = SHARES,
    confidence: float = CONFIDENCE,
) -> Description:
    """Return the description of one metric.

    Parameters
    ----------
    name, unit : of the metric
    values : (runs,), NaN for a lost run; one or more
    worse : which end of the scale a lost run counts at
    shares : of the percentiles
    confidence : of each pair of bounds

    Returns
    -------
    Description
        The bounds of the mean are Student's, exact for a normal distribution and by the central limit theorem else;
        those of the percentiles hold for any distribution.
    """
    finite = values[np.isfinite(values)]
    count = len(finite)
    mean = float(finite.mean()) if count else math.nan
    deviation = float(finite.std(ddof=1)) if count > 1 else math.nan
    quantile = float(student.ppf(0.5 * (1.0 + confidence), count - 1)) if count > 1 else math.nan
    reach = quantile * deviation / math.sqrt(max(count, 1))
    rising = ordered(values, worse)
    return Description(
        name=name,
        unit=unit,
        count=len(values),
        lost=len(values) - count,
        mean=mean,
        mean_low=mean - reach,
        mean_high=mean + reach,
        deviation=deviation,
        least=float(finite.min()) if count else math.nan,
        most=float(finite.max()) if count else math.nan,
        percentiles=tuple(percentile(rising, share, confidence) for share in shares),
    )


def distribution(values: Array, worse: Worse = "high") -> tuple[Array, Array]:
    """Return the empirical distribution function: values in ascending order, and the share of runs up to each."""
    rising = ordered(values, worse)
    return rising, np.arange(1, len(rising) + 1) / len(rising)


def distribution_band(count: int, confidence: float = CONFIDENCE) -> float:
    """Return the half-width of a band round the empirical distribution that holds all of the true one.

    References
    ----------
    Dvoretzky, Kiefer and Wolfowitz (1956); the constant is that of Massart (1990), Annals of Probability 18(3).
    """
    return math.sqrt(math.log(2.0 / (1.0 - confidence)) / (2.0 * count))


def worst(values: Array, most: int, worse: Worse = "high") -> list[int]:
    """Return the indices of the worst runs, the worst first; lost runs before all, equal ones in their order."""
    rank = np.where(np.isfinite(values), values if worse == "high" else -values, math.inf)
    return [int(i) for i in np.argsort(-rank, kind="stable")[:most]]
