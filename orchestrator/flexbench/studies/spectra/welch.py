"""Power spectral densities by Welch's method, with their resolution and confidence bounds.

Densities are one-sided, in units^2/Hz: their integral over the frequencies is the variance. The estimate averages
periodograms of segments that overlap by half, under a Hann window. Its bounds come from chi-square with the degrees
of freedom that overlapping segments of a smooth density leave (Welch 1967, IEEE Trans. Audio Electroacoustics
15(2), 70-73; Percival and Walden 1993, section 6.17): nu = 2 K / (1 + 2 sum (1 - j/K) rho_j), with rho_j the squared
correlation of the window with itself, j segments on.

The cumulative spectrum is taken from one periodogram of the whole history, without a window and with its mean: its
last value is the mean square exactly (Parseval), which an average of windowed segments would only approach.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal, stats

from flexsat.arrays import Array
from lockstep import InputError

WINDOW = "hann"
LEVEL = 0.95
RESOLUTION = 0.05  # Hz: a tenth of the lowest structural frequencies


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """How a density was estimated, and what that says of it."""

    window: str
    interval: float  # s between rows
    samples: int  # of a segment
    segments: int
    degrees_of_freedom: float
    resolution: float  # Hz: equivalent noise bandwidth of the window
    level: float  # confidence of the bounds

    def bounds(self) -> tuple[float, float]:
        """Return the factors on an estimate between which the density lies with the confidence `level`.

        For one component, away from zero and from half the sampling frequency. A sum over components is known better.
        """
        nu, tail = self.degrees_of_freedom, 0.5 * (1.0 - self.level)
        return float(nu / stats.chi2.ppf(1.0 - tail, nu)), float(nu / stats.chi2.ppf(tail, nu))

    def describe(self) -> str:
        """Return the method in a sentence."""
        low, high = self.bounds()
        return (
            f"Welch: {self.segments} segments of {self.samples * self.interval:.4g} s, overlap 50 %, {self.window}"
            f" window, resolution {self.resolution:.3g} Hz, {self.degrees_of_freedom:.0f} degrees of freedom:"
            f" {100.0 * self.level:g} % bounds x{low:.2f} to x{high:.2f} a component."
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Spectrum:
    """Density of each component of a history, and the cumulative spectrum of their sum."""

    frequency: Array  # (f,) [Hz]
    density: Array  # (f, k) [units^2/Hz]
    method: Method
    cumulative_frequency: Array  # (g,) [Hz], from 0
    cumulative: Array  # (g,) [units^2]: what lies at or below; the first value is the square of the mean

    @property
    def total(self) -> Array:
        """Density of the sum over the components, (f,) [units^2/Hz]."""
        return np.asarray(self.density.sum(axis=1))

    @property
    def mean_square(self) -> float:
        """Mean square of the whole history, mean included [units^2]."""
        return float(self.cumulative[-1])


def estimate(
    values: Array, interval: float, resolution: float = RESOLUTION, level: float = LEVEL, window: str = WINDOW
) -> Spectrum:
    """Estimate the spectrum of a history.

    Parameters
    ----------
    values : (rows, k) or (rows,)
    interval : [s] between rows
    resolution : equivalent noise bandwidth asked for [Hz]; the segment becomes as long as that needs
    level : confidence of the bounds
    window : by SciPy's name

    Raises
    ------
    InputError
        If the history is shorter than a segment, or an argument is out of range.
    """
    history = values.reshape(len(values), -1)
    if not (np.isfinite(resolution) and resolution > 0.0):
        raise InputError(f"resolution {resolution!r}: must be a frequency > 0 Hz")
    if not 0.0 < level < 1.0:
        raise InputError(f"level {level!r}: must be between 0 and 1, for example {LEVEL}")
    bins = noise_bandwidth(window)
    samples = round(bins / (resolution * interval))
    if samples < 8:
        raise InputError(f"resolution {resolution:g} Hz: too coarse for rows {interval:g} s apart; take a finer one")
    if samples > len(history):
        least = bins / (len(history) * interval)
        raise InputError(
            f"resolution {resolution:g} Hz: needs {samples * interval:.4g} s, and there are"
            f" {len(history) * interval:.4g} s; take {least:.2g} Hz or coarser, or simulate longer"
        )
    overlap = samples // 2
    centred = history - history.mean(axis=0)
    frequency, density = signal.welch(
        centred, 1.0 / interval, window=window, nperseg=samples, noverlap=overlap, detrend=False, axis=0
    )
    segments = 1 + (len(history) - samples) // (samples - overlap)
    method = Method(
        window=window,
        interval=interval,
        samples=samples,
        segments=segments,
        degrees_of_freedom=degrees_of_freedom(window, samples, overlap, segments),
        resolution=noise_bandwidth(window, samples) / (samples * interval),
        level=level,
    )
    steps, cumulative = cumulative_spectrum(history, interval)
    return Spectrum(
        frequency=np.asarray(frequency),
        density=np.asarray(density),
        method=method,
        cumulative_frequency=steps,
        cumulative=cumulative,
    )


def cumulative_spectrum(history: Array, interval: float) -> tuple[Array, Array]:
    """Return frequencies [Hz] and the mean square at or below each [units^2], summed over components; 0 Hz included."""
    rows = len(history)
    power = np.sum(np.abs(np.fft.rfft(history, axis=0)) ** 2, axis=1) / rows**2
    power[1:] *= 2.0  # one-sided
    if rows % 2 == 0:
        power[-1] *= 0.5  # half the sampling frequency stands alone
    return np.asarray(np.fft.rfftfreq(rows, interval), dtype=float), np.asarray(np.cumsum(power))


def degrees_of_freedom(window: str, samples: int, overlap: int, segments: int) -> float:
    """Return the equivalent degrees of freedom of an average over overlapping segments."""
    taper = signal.get_window(window, samples)
    power = float(np.sum(taper**2))
    stride = samples - overlap
    excess = 0.0
    for j in range(1, segments):
        shift = j * stride
        if shift >= samples:
            break
        correlation = float(np.sum(taper[shift:] * taper[: samples - shift])) / power
        excess += (1.0 - j / segments) * correlation**2
    return 2.0 * segments / (1.0 + 2.0 * excess)


def noise_bandwidth(window: str, samples: int = 4096) -> float:
    """Return the equivalent noise bandwidth of a window, in bins of one over its length."""
    taper = signal.get_window(window, samples)
    return float(samples * np.sum(taper**2) / np.sum(taper) ** 2)
