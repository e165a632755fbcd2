"""A response between its lines: gain and phase as smooth functions of the logarithm of frequency."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array

Flags = NDArray[np.bool_]
SPLIT = 8  # pieces of an interval between two lines


def densified(frequency: Array, values: Array, smooth: Flags) -> tuple[Array, Array]:
    """Return a finer grid and the values on it, by cubic Hermite polynomials with the slopes of three lines.

    Parameters
    ----------
    frequency : (f,) [Hz], ascending
    values : (f, k) logarithm of gain, or phase [rad]
    smooth : (f - 1, k) intervals that may be interpolated; elsewhere, and next to those, lines are joined straight

    Returns
    -------
    frequency, values : ((f - 1) SPLIT + 1,) and (.., k)
        Error order: 3 in the spacing on the logarithm of frequency, 1 next to intervals that are not smooth.
    """
    position = np.log(frequency)
    width = np.diff(position)[:, None]
    secant = np.diff(values, axis=0) / width
    start, end = secant.copy(), secant.copy()  # slopes at both ends of each interval
    if len(frequency) > 2:
        parabola = (width[:-1] * secant[1:] + width[1:] * secant[:-1]) / (width[:-1] + width[1:])
        both = smooth[:-1] & smooth[1:]
        start[1:] = np.where(both, parabola, secant[1:])
        end[:-1] = np.where(both, parabola, secant[:-1])
    share = (np.arange(SPLIT) / SPLIT)[None, :, None]
    low, high = values[:-1, None, :], values[1:, None, :]
    inside = (
        (2.0 * share**3 - 3.0 * share**2 + 1.0) * low
        + (share**3 - 2.0 * share**2 + share) * (width * start)[:, None, :]
        + (3.0 * share**2 - 2.0 * share**3) * high
        + (share**3 - share**2) * (width * end)[:, None, :]
    )
    fine = np.vstack([inside.reshape(-1, values.shape[1]), values[-1:]])
    grid = np.append((position[:-1, None] + share[0, :, 0] * width).ravel(), position[-1])
    return np.exp(grid), fine
