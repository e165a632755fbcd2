"""Probability that a requirement is met: Clopper-Pearson bounds, and the number of runs that would show it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scipy.stats import beta, binomtest

from .percentiles import CONFIDENCE

Verdict = Literal["shown", "not met", "open"]
_MOST_RUNS = 100_000_000  # beyond these no number is given


@dataclass(frozen=True, slots=True, kw_only=True)
class Proportion:
    """A share of runs, and the bounds that hold the probability with the stated confidence, or more."""

    met: int
    count: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The share of runs."""
        return self.met / self.count

    def verdict(self, required: float) -> Verdict:
        """Return whether a probability of at least `required` is shown, excluded, or neither by so many runs."""
        return "shown" if self.low >= required else "not met" if self.high < required else "open"


def proportion(met: int, count: int, confidence: float = CONFIDENCE) -> Proportion:
    """Return a proportion with its bounds.

    Parameters
    ----------
    met, count : runs that meet the requirement, and all runs, at least one
    confidence : of both bounds together; the true one is higher, as the number of runs is whole

    References
    ----------
    Clopper and Pearson (1934), Biometrika 26(4), 404-413.
    """
    bounds = binomtest(met, count).proportion_ci(confidence_level=confidence, method="exact")
    return Proportion(met=met, count=count, low=float(bounds.low), high=float(bounds.high))


def runs_to_show(failed: int, count: int, required: float, confidence: float = CONFIDENCE) -> int | None:
    """Return how many runs show a probability of at least `required`, if as large a share fails as so far.

    Parameters
    ----------
    failed, count : runs that do not meet the requirement, and all runs so far
    required : probability, 0 to 1, exclusive
    confidence : of both bounds together

    Returns
    -------
    int | None
        Total number of runs, at least `count`. None if so many fail that no number would show it.
    """
    share = failed / count

    def shown(runs: int) -> bool:
        failures = max(failed, -(-failed * runs // count))
        return bool(beta.ppf(0.5 * (1.0 - confidence), runs - failures, failures + 1) >= required)

    if share >= 1.0 - required:
        return None
    least, most = count, count
    while not shown(most):
        least, most = most, 2 * most
        if most > _MOST_RUNS:
            return None
    while most - least > 1:
        middle = (least + most) // 2
        least, most = (least, middle) if shown(middle) else (middle, most)
    return least if shown(least) else most
