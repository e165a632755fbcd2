"""Tests of a filter's consistency (Bar-Shalom, Li, Kirubarajan: Estimation with Applications, 2001, section 5.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtrc, gammaincinv, ndtri

from flexsat.arrays import Array

from ...campaign.statistics.percentiles import CONFIDENCE


@dataclass(frozen=True, slots=True, kw_only=True)
class Average:
    """An average of normalised squares over its degrees of freedom: 1 for a consistent filter."""

    value: float
    low: float  # of the two-sided 95 % interval
    high: float
    freedom: int  # degrees of freedom of one sample
    samples: int

    @property
    def assessment(self) -> str:
        """Whether the filter's covariance fits its errors, in words."""
        if self.low <= self.value <= self.high:
            return "consistent"
        if self.value > self.high:
            return "optimistic: covariance underestimated"
        return "conservative: covariance overestimated"


def normalised(vectors: Array, covariance: Array) -> Array:
    """Return vectors (k, m) in units of a covariance (m, m): white and of unit variance if it is their covariance."""
    return np.asarray(solve_triangular(np.linalg.cholesky(covariance), vectors.T, lower=True).T)


def average(squares: Array, freedom: int) -> Average:
    """Return the mean of normalised squares, (k,), per degree of freedom, with bounds for independent samples."""
    count = len(squares)
    total = freedom * count
    shares = (0.5 * (1.0 - CONFIDENCE), 0.5 * (1.0 + CONFIDENCE))
    low, high = (2.0 * gammaincinv(0.5 * total, share) / total for share in shares)  # of chi-square
    return Average(value=float(np.mean(squares)) / freedom, low=float(low), high=float(high), freedom=freedom,
                   samples=count)  # fmt: skip


def autocorrelation(series: Array, lags: int) -> Array:
    """Return the autocorrelation of each column of (k, m) at lags 1 to `lags`, (lags, m)."""
    centred = series - series.mean(axis=0)
    power = np.sum(centred**2, axis=0)
    return np.array([np.sum(centred[lag:] * centred[:-lag], axis=0) / power for lag in range(1, lags + 1)])


def whiteness_bound(count: int) -> float:
    """Return what an autocorrelation of `count` white samples exceeds in magnitude at 5 % of the lags."""
    return float(ndtri(0.5 * (1.0 + CONFIDENCE)) / np.sqrt(count))


def portmanteau(correlation: Array, count: int) -> Array:
    """Return the Ljung-Box p-value of each column of autocorrelations (lags, m) of `count` samples, (m,)."""
    lags = np.arange(1, len(correlation) + 1)[:, None]
    statistic = count * (count + 2) * np.sum(correlation**2 / (count - lags), axis=0)
    return np.asarray(chdtrc(len(correlation), statistic))
