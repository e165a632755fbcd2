"""Margins of loops known at frequencies: of one channel, and of several together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array, Complex

from .interpolation import SPLIT, densified

RESOLVED = (0.7, 1.1)  # from line to line: a factor of two in gain, 63 deg in phase; else a crossing is not trusted
NEAR = 1.5  # logarithm of the factor from one within which the turns of a locus matter
FOLLOWED = 40  # steps by which a crossover is followed; near half the sampling rate each leaves a third of the error


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """The nearest of each kind, with the frequency [Hz] where it stands; infinite (or 0 downwards) without a crossing.

    The disk margin is the balanced one (Seiler, Packard, Gahinet 2020): the loop stays stable for every factor within
    the disk of diameter from (1 - d/2) / (1 + d/2) to (1 + d/2) / (1 - d/2), d = 2 / max |S - T|.
    """

    gain_up: float
    gain_up_at: float
    gain_down: float
    gain_down_at: float
    phase: float  # deg
    phase_at: float
    delay: float  # s
    delay_at: float
    disk: float
    disk_at: float
    unresolved: tuple[
        float, ...
    ] = ()  # Hz: crossings left out, because the response changes too fast between two lines


def loop_margins(frequency: Array, loops: Complex, period: float | None = None, straight: bool = False) -> Margins:
    """Return the margins of one loop, or of the characteristic loci of several channels that change together.

    Parameters
    ----------
    frequency : (f,) [Hz], ascending
    loops : (f,) one loop's response; or (f, m, m), whose eigenvalues are the loci
    period : [s] for which the plant's input is held, where there is a zero-order hold; None for a continuous input
    straight : join the lines straight, to see what interpolation matters

    Between two lines gain and phase are interpolated; a resonance narrower than the spacing of the lines is not seen.
    A crossing between two lines that differ by more than RESOLVED is not used but listed as unresolved. The disk margin
    of several channels is that for one factor matrix of any structure, from the largest singular value of S - T.
    """
    matrices = loops[:, None, None] if loops.ndim == 1 else loops
    loci = characteristic_loci(matrices)
    gains = np.log(np.abs(loci) + np.finfo(float).tiny)
    angle = np.unwrap(np.angle(loci), axis=0)
    smooth = (np.abs(np.diff(gains, axis=0)) < RESOLVED[0]) & (np.abs(np.diff(angle, axis=0)) < RESOLVED[1])
    lines = frequency
    curved = smooth & (not straight)
    frequency, gains = densified(lines, gains, curved)
    _, angle = densified(lines, angle, curved)
    smooth = np.repeat(smooth, SPLIT, axis=0)
    up, down, phase, delay = (np.inf, np.nan), (0.0, np.nan), (np.inf, np.nan), (np.inf, np.nan)
    unresolved = set()
    for k in range(loci.shape[1]):
        for share, i in _crossings(gains[:, k], 0.0):
            if not smooth[i, k]:
                unresolved.add(float(lines[i // SPLIT]))
                continue
            here, lag = _between(frequency, share, i), (_step(angle[:, k], share, i) + np.pi) % (2.0 * np.pi)
            phase = min(phase, (float(np.degrees(min(lag, 2.0 * np.pi - lag))), here))
            delay = min(delay, _delay_to_instability(frequency, gains[:, k], angle[:, k], share + i, period))
        turns = np.arange(np.floor(angle[:, k].min() / (2 * np.pi)) - 1, np.ceil(angle[:, k].max() / (2 * np.pi)) + 1)
        for turn in turns:
            for share, i in _crossings(angle[:, k], (2.0 * turn + 1.0) * np.pi):
                if not smooth[i, k]:
                    if min(abs(gains[i, k]), abs(gains[i + 1, k])) < NEAR:
                        unresolved.add(float(lines[i // SPLIT]))
                    continue
                factor = float(np.exp(-_step(gains[:, k], share, i)))
                if factor > 1.0:
                    up = min(up, (factor, _between(frequency, share, i)))
                else:
                    down = max(down, (factor, _between(frequency, share, i)))
    disk = disk_margins(matrices)
    worst = int(np.argmin(disk))
    return Margins(
        gain_up=up[0],
        gain_up_at=up[1],
        gain_down=down[0],
        gain_down_at=down[1],
        phase=phase[0],
        phase_at=phase[1],
        delay=delay[0],
        delay_at=delay[1],
        disk=float(disk[worst]),
        disk_at=float(lines[worst]),
        unresolved=tuple(sorted(unresolved)),
    )


def refine(frequency: Array, loops: Complex) -> Array:
    """Return the middles [Hz] of the intervals in which a locus near gain one turns too fast to be interpolated."""
    loci = characteristic_loci(loops)
    turn = np.abs(np.log((loci[1:] + 1e-300) / (loci[:-1] + 1e-300)))
    gains = np.abs(np.log(np.abs(loci) + 1e-300))
    fast = np.any((np.minimum(gains[1:], gains[:-1]) < NEAR) & (turn > 0.3 * min(RESOLVED)), axis=1)
    return np.asarray(np.sqrt(frequency[1:] * frequency[:-1])[fast])


def characteristic_loci(loops: Complex) -> Complex:
    """Return the eigenvalues of L, (f, m), each column one locus, followed from frequency to frequency."""
    values = np.linalg.eigvals(loops)
    for k in range(1, len(values)):
        left = list(range(values.shape[1]))
        order = []
        for value in values[k - 1]:
            nearest = min(left, key=lambda j: abs(np.log((values[k, j] + 1e-300) / (value + 1e-300))))
            left.remove(nearest)
            order.append(nearest)
        values[k] = values[k, order]
    return np.asarray(values)


def disk_margins(loops: Complex) -> Array:
    """Return 2 / sigma_max(S - T) at each frequency, (f,)."""
    one = np.eye(loops.shape[-1])
    difference = np.linalg.solve((one + loops).swapaxes(-1, -2), (one - loops).swapaxes(-1, -2))
    return np.asarray(2.0 / np.linalg.norm(difference, ord=2, axis=(-2, -1)))


def largest_singular_values(loops: Complex) -> tuple[Array, Array]:
    """Return the largest singular values of S and T at each frequency, (f,) each."""
    one = np.eye(loops.shape[-1])
    s = np.linalg.inv(one + loops)
    return np.linalg.norm(s, ord=2, axis=(-2, -1)), np.linalg.norm(one - s, ord=2, axis=(-2, -1))


def delayed_hold(angle: Array | float, delay: float, period: float) -> Complex:
    """Return what a delay makes of a loop whose plant integrates a held input, at omega * period = `angle` [rad].

    A part m of a period of delay lets the old value act for m and the new one for 1 - m: on an integrator that is
    exactly (1 - m) + m / z; exp(-i omega delay) would leave out the images of the frequency in the sampled signal.
    """
    whole, part = divmod(delay / period, 1.0)
    back = np.exp(-1j * np.asarray(angle))
    return np.asarray(back**whole * ((1.0 - part) + part * back))


def _delay_to_instability(
    frequency: Array, gains: Array, angle: Array, start: float, period: float | None
) -> tuple[float, float]:
    """Return the delay that takes a locus through -1 near a gain crossover, and the frequency [Hz] where it does.

    `start` is the crossover as a position among the lines. A held input loses gain with the delay, so that the
    crossover moves: it is followed from delay to delay.
    """
    position, rows, log_f = start, np.arange(len(frequency)), np.log(frequency)
    for _ in range(FOLLOWED):
        here = float(np.exp(np.interp(position, rows, log_f)))
        lag = float(np.interp(position, rows, angle) + np.pi) % (2.0 * np.pi)
        delay = lag / (2.0 * np.pi * here)
        if period is None:
            break
        turned = 2.0 * np.pi * here * period
        for _ in range(FOLLOWED):  # the hold turns nearly as a pure delay does
            short = float(np.angle(delayed_hold(turned, delay, period) * np.exp(1j * lag)))
            delay = max(0.0, delay + short / (2.0 * np.pi * here))
        less = np.log(np.abs(delayed_hold(2.0 * np.pi * frequency * period, delay, period)) + 1e-300)
        near = _crossings(gains + less, 0.0)
        if not near:
            return np.inf, here
        position = min((share + i for share, i in near), key=lambda other: abs(other - position))
    return delay, here


def _between(frequency: Array, share: float, i: int) -> float:
    return float(frequency[i] ** (1.0 - share) * frequency[i + 1] ** share)


def _step(values: Array, share: float, i: int) -> float:
    return float(values[i] + share * (values[i + 1] - values[i]))


def _crossings(values: Array, level: float) -> list[tuple[float, int]]:
    """Return where a sampled function crosses a level: the share of an interval, and the interval."""
    above = values > level
    where = np.nonzero(above[1:] != above[:-1])[0]
    return [(float((level - values[i]) / (values[i + 1] - values[i])), int(i)) for i in where]
