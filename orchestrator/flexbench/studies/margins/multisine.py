"""Periodic sums of sines whose lines are not aliased onto each other by a slow sensor in the loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array, Index
from lockstep.errors import InputError

REACH = 0.1  # relative: greatest distance of a line from the frequency asked for
FILLED = 0.6  # share of the lines free of aliasing that are used by default


@dataclass(frozen=True, slots=True, kw_only=True)
class Multisine:
    """Equal sines at whole multiples of 1 / length, with a peak of one."""

    lines: Index  # (f,) multiples of the fundamental, ascending
    values: Array  # (k,) one period
    sample: float  # s

    @property
    def length(self) -> float:
        """Length of one period [s]."""
        return len(self.values) * self.sample

    @property
    def frequency(self) -> Array:
        """Frequencies of the lines, (f,) [Hz]."""
        return self.lines / self.length


def design_multisine(
    sample: float,
    length: float,
    band: tuple[float, float],
    lines: int | None = None,
    slow_period: float | None = None,
) -> Multisine:
    """Choose lines spread evenly over the logarithm of frequency, with phases that keep the peak low.

    Parameters
    ----------
    sample : time between two values [s]: the loop's controller period
    length : of one period [s], a whole number of samples
    band : lowest and highest frequency [Hz], below half the sampling rate
    lines : how many at most; None for as many as fit. Fewer are found where the lowest ones would coincide.
    slow_period : period of the slowest sampler in the loop [s]. A line at f has aliases at |f + k / slow_period|;
        no line is put on an alias of another one.

    Raises
    ------
    InputError
        If periods are not whole multiples, or the band does not fit.
    """
    _multiple("length", length, sample)
    low, high = band
    if not 1.0 / length <= low * (1.0 + 1e-9) or not low < high or not high < 0.5 / sample:
        raise InputError(
            f"band {low:g} to {high:g} Hz: must rise, from 1 / length = {1.0 / length:g} Hz "
            f"to below half the sampling rate, {0.5 / sample:g} Hz"
        )
    if lines is None:
        lines = room(sample, length, slow_period)
    if lines < 1:
        raise InputError(f"lines must be >= 1, got {lines}")
    return multisine_at(sample, length, np.geomspace(low, high, lines), slow_period)


def multisine_at(sample: float, length: float, wanted: Array, slow_period: float | None = None) -> Multisine:
    """Put lines as near as possible to the frequencies asked for [Hz]; the rest as in `design_multisine`."""
    samples = _multiple("length", length, sample)
    fold = None if slow_period is None else _multiple("length", length, slow_period)
    band = (float(np.min(wanted)) * length, float(np.max(wanted)) * length)
    taken: set[int] = set()
    chosen: list[int] = []
    for target in wanted * length:
        line = _nearest(float(target), chosen, taken, fold, samples, band)
        if line is not None:
            chosen.append(line)
            taken.add(_folded(line, fold))
    found = np.array(sorted(chosen), dtype=np.intp)
    # Schroeder (1970): phases that grow with the square of the number keep the peak low
    phases = -np.pi * np.arange(len(found)) * (np.arange(len(found)) - 1.0) / len(found)
    turns = 2.0 * np.pi * np.outer(np.arange(samples), found) / samples
    values = np.cos(turns + phases).sum(axis=1)
    return Multisine(lines=found, values=values / np.abs(values).max(), sample=sample)


def room(sample: float, length: float, slow_period: float | None = None) -> int:
    """Return how many lines fit without aliasing, with a reserve."""
    apart = length / sample if slow_period is None else length / slow_period
    return int(FILLED * round(apart) / 2.0)


def _multiple(name: str, long: float, short: float) -> int:
    count = round(long / short)
    if count < 1 or abs(count * short - long) > 1e-9 * long:
        raise InputError(f"{name} {long:g} s must be a whole multiple of {short:g} s")
    return count


def _folded(line: int, fold: int | None) -> int:
    """Return the alias below half the rate of the slow sampler; `fold` is that rate in lines."""
    if fold is None:
        return line
    rest = line % fold
    return min(rest, fold - rest)


def _nearest(
    target: float, chosen: list[int], taken: set[int], fold: int | None, samples: int, band: tuple[float, float]
) -> int | None:
    """Return the free line nearest to the frequency asked for, within REACH of it; None if there is none."""
    reach = max(1, int(REACH * target))
    for offset in sorted(range(-reach, reach + 1), key=lambda other: abs(round(target) + other - target)):
        line = round(target) + offset
        if line in chosen or not band[0] - 0.5 <= line <= band[1] + 0.5 or not 0 < line < samples / 2:
            continue
        folded = _folded(line, fold)
        if folded not in taken and (fold is None or 0 < 2 * folded < fold):
            return line
    return None
