"""Pointing error indices after ECSS-E-ST-60-10C and ESSB-HB-E-003, of sampled error histories.

A history is (rows, k): k components of the error, one sample every `interval` seconds. A window is a whole number of
samples; the windows of a history follow one another without overlap, and what is left at its end is not used. Every
function returns (values, k), one row for each time or window at which the index can be evaluated, signed:

- APE, absolute performance error: e(t);
- MPE, mean performance error: the mean of e over a window;
- RPE, relative performance error: e(t) less the mean of its window, for each t in the window;
- PDE, performance drift error: the difference of the means of two windows whose starts are `separation` apart;
- PRE, performance reproducibility error: the difference of the means of two windows at the same time in two different
  observations; observations of a given length follow one another, and every pair of them counts.

The size of an index is the absolute value of a component or the norm of some; `at_level` is what a share of its values
does not exceed.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from flexsat.arrays import Array
from lockstep.errors import InputError


def absolute(error: Array) -> Array:
    """Return APE, (rows, k)."""
    return error


def window_means(error: Array, samples: int) -> Array:
    """Return MPE, (windows, k): the means of consecutive windows of `samples` rows."""
    return np.asarray(_windows(error, samples).mean(axis=1))


def window_deviations(error: Array, samples: int) -> Array:
    """Return RPE, (windows * samples, k): every row less the mean of its window."""
    windows = _windows(error, samples)
    return np.asarray((windows - windows.mean(axis=1, keepdims=True)).reshape(-1, error.shape[1]))


def drifts(error: Array, samples: int, separation: int) -> Array:
    """Return PDE, (pairs, k): the mean of a window less that of the one that starts `separation` rows before.

    The first windows of the pairs follow one another. No pair where the history is too short for one.
    """
    if separation < 1:
        raise InputError(f"separation must be 1 sample or more, got {separation}")
    if len(error) < samples + separation:
        return np.empty((0, error.shape[1]))
    later = window_means(error[separation:], samples)
    return np.asarray(later - window_means(error, samples)[: len(later)])


def reproducibility(error: Array, samples: int, observation: int) -> Array:
    """Return PRE, (pairs, k): window means of one observation less those at the same time in an earlier one."""
    if observation < samples:
        raise InputError(f"observation must hold a window of {samples} samples, got {observation}")
    means = [window_means(part, samples) for part in _windows(error, observation)]
    pairs = [later - earlier for earlier, later in combinations(means, 2)]
    return np.concatenate(pairs) if pairs else np.empty((0, error.shape[1]))


def at_level(sizes: Array, level: float) -> float:
    """Return the smallest of the sizes that a share `level` of them does not exceed: an order statistic.

    With fewer than 1 / (1 - level) values it is the largest.
    """
    return float(np.quantile(sizes, level, method="inverted_cdf"))


def _windows(error: Array, samples: int) -> Array:
    """Return consecutive windows, (windows, samples, k)."""
    if samples < 1:
        raise InputError(f"a window must hold 1 sample or more, got {samples}")
    count = len(error) // samples
    return error[: count * samples].reshape(count, samples, error.shape[1])
