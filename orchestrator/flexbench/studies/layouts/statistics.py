"""Means, differences and ratios of paired samples with their 95 % confidence intervals (Student)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from flexsat.arrays import Array

from ...campaign.statistics.percentiles import CONFIDENCE


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A mean, difference or ratio, and the bounds that hold the true one with 95 %."""

    value: float
    low: float  # NaN for a single sample, which shows no scatter
    high: float
    count: int  # of samples, or pairs

    def excludes(self, value: float) -> bool:
        """Return whether a value lies outside the bounds."""
        return self.low > value or self.high < value


def mean(samples: Sequence[float] | Array) -> Estimate:
    """Return the mean with its interval, for independent samples of a normal distribution of unknown variance.

    Parameters
    ----------
    samples : (k,), one or more
    """
    values = np.asarray(samples, dtype=float)
    count = len(values)
    middle = float(values.mean())
    if count < 2:
        return Estimate(value=middle, low=np.nan, high=np.nan, count=count)
    reach = float(student.ppf(0.5 * (1.0 + CONFIDENCE), count - 1) * values.std(ddof=1) / np.sqrt(count))
    return Estimate(value=middle, low=middle - reach, high=middle + reach, count=count)


def difference(first: Sequence[float] | Array, second: Sequence[float] | Array) -> Estimate:
    """Return the mean of second less first, of pairs."""
    return mean(np.asarray(second, dtype=float) - np.asarray(first, dtype=float))


def ratio(first: Sequence[float] | Array, second: Sequence[float] | Array) -> Estimate:
    """Return the geometric mean of second over first, of pairs of positive numbers; the interval is that of its log."""
    logarithm = mean(np.log(np.asarray(second, dtype=float) / np.asarray(first, dtype=float)))
    value, low, high = (float(np.exp(one)) for one in (logarithm.value, logarithm.low, logarithm.high))
    return Estimate(value=value, low=low, high=high, count=logarithm.count)
