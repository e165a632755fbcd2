"""From what was measured at the plant input to the loop's response, its margins, and how sure they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from flexsat.arrays import Array, Complex
from lockstep.errors import InputError

from ...campaign.statistics.percentiles import CONFIDENCE
from .analysis import body_loops
from .multisine import Multisine
from .response import Margins, loop_margins

COHERENT = 0.999  # coherence from which a line counts: one period then scatters by about 3 %
Replica = tuple[Complex, Complex]  # loops (together, single) with one period left out
TOGETHER = "together"
INTERPOLATION = 0.5  # share of what a curve between the lines changes against a straight one that may be wrong
UNEXPLAINED, ENOUGH = 0.1, 1e-4  # share of the power of what changes that a decay may leave; that is no noise
MOST_FACTORS = 4  # two modes that ring on
SLOWEST = 0.02  # distance of a factor from one: what is slower is drift, and taken out as such
BIAS = 1e-3  # relative: what the plant's step of 1 ms and its products of small quantities add to a linear loop


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredLoop:
    """A loop response measured along directions of injection."""

    frequency: Array  # (f,) [Hz]
    together: Complex  # (f, d, d): all directions opened together
    single: Complex  # (f, d): one direction opened, the rest closed
    together_uncertainty: Array  # (f, d, d): half width of the confidence interval of each entry's modulus
    single_uncertainty: Array  # (f, d)
    coherence: Array  # (f, d): share of each direction's power that repeats from period to period
    coherence_together: Array  # (f,): of all directions' power
    names: tuple[str, ...]  # of the directions
    period: float  # s, for which the plant's input is held
    periods: int  # averaged

    def of(self, which: str) -> tuple[Complex, NDArray[np.bool_]]:
        """Return the response of one direction or of all `together`, and which of its lines are coherent."""
        if which == TOGETHER:
            return self.together, self.coherence_together >= COHERENT
        column = self.names.index(which)
        return self.single[:, column], self.coherence[:, column] >= COHERENT


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredMargins:
    """Margins from the coherent lines, and the half widths of their confidence intervals under the same names."""

    value: Margins
    uncertainty: dict[str, float]


def estimate_loop(
    experiments: Sequence[tuple[Array, Array]], multisine: Multisine, makes: Array, names: Sequence[str]
) -> tuple[MeasuredLoop, list[Replica]]:
    """Estimate the loop from one experiment for each direction.

    Parameters
    ----------
    experiments : before and after the injection, (periods, samples, m) each
    multisine : what was injected
    makes : (d, m): how much of each direction the channels make; makes @ direction = 1
    names : of the directions, (d,)

    Returns
    -------
    measured : with the mean over all periods, and uncertainties from leaving out one period at a time (jackknife)
    replicas : loops (together, single) without the first period, without the second, and so on

    Raises
    ------
    InputError
        With fewer than two periods, or another number of experiments than of directions.
    """
    periods = experiments[0][0].shape[0]
    if periods < 2 or len(experiments) != len(makes):
        raise InputError(
            f"an estimate needs two periods at least and {len(makes)} experiments, got {periods} and {len(experiments)}"
        )
    scale = 2.0 / experiments[0][0].shape[1]
    spectra = [
        [scale * np.fft.rfft(signal, axis=1)[:, multisine.lines] for signal in experiment] for experiment in experiments
    ]
    ringing = [transient(before) for before, _ in spectra]  # the injection is periodic: the same before and after it
    back = -np.stack([before - rest for (before, _), rest in zip(spectra, ringing, strict=True)], axis=-1)
    inputs = np.stack([after - rest for (_, after), rest in zip(spectra, ringing, strict=True)], axis=-1)

    def loops(chosen: NDArray[np.intp]) -> tuple[Complex, Complex]:
        return body_loops(back[chosen].mean(axis=0), makes, inputs[chosen].mean(axis=0))

    everyone = np.arange(periods, dtype=np.intp)
    together, single = loops(everyone)
    replicas = [loops(everyone[everyone != left_out]) for left_out in everyone]
    quantile = float(stdtrit(periods - 1, 0.5 + 0.5 * CONFIDENCE))
    coherence, coherence_together = _coherence(makes @ back, makes @ inputs)
    measured = MeasuredLoop(
        frequency=multisine.frequency,
        together=together,
        single=single,
        together_uncertainty=quantile * jackknife([replica[0] for replica in replicas])
        + BIAS * np.linalg.norm(together, ord=2, axis=(1, 2), keepdims=True),
        single_uncertainty=quantile * jackknife([replica[1] for replica in replicas]) + BIAS * np.abs(single),
        coherence=coherence,
        coherence_together=coherence_together,
        names=tuple(names),
        period=multisine.sample,
        periods=periods,
    )
    return measured, replicas


def transient(spectra: Complex) -> Complex:
    """Return what has not decayed yet in the lines of consecutive periods, (periods, f, m).

    Modes of a nearly unstable loop ring on for many periods. From one period to the next the part of a mode changes by
    the same factor in all lines and channels. The differences of the periods have nothing but such parts and noise: as
    many factors are found as predict them (Prony). Noise is not predicted: then nothing is returned.
    """
    periods, shape = len(spectra), spectra.shape
    change = np.diff(spectra, axis=0).reshape(periods - 1, -1)
    found, least = np.zeros(shape, dtype=complex), UNEXPLAINED
    for order in range(2, min(MOST_FACTORS, periods - 2) + 1, 2):
        past = np.stack([change[k : periods - 1 - order + k].ravel() for k in range(order)], axis=1)
        next_ = change[order:].ravel()
        both = np.vstack([past.real, past.imag]), np.concatenate([next_.real, next_.imag])
        weights = np.linalg.lstsq(*both, rcond=None)[0]  # real: the factors are pairs of conjugates
        left = float(np.sum((both[1] - both[0] @ weights) ** 2) / max(np.sum(both[1] ** 2), np.finfo(float).tiny))
        factor = np.roots(np.concatenate([[1.0], -weights[::-1]]))
        if left >= least or np.any(np.abs(factor) >= 1.0) or np.any(np.abs(factor - 1.0) < SLOWEST):
            continue
        parts = np.linalg.lstsq(np.vander(factor, periods - 1, increasing=True).T, change, rcond=None)[0]
        ringing = np.vander(factor, periods, increasing=True).T @ (parts / (factor - 1.0)[:, None])
        found, least = ringing.reshape(shape), left
        if left < ENOUGH:
            break
    return found


def merged(
    first: tuple[MeasuredLoop, list[Replica]], second: tuple[MeasuredLoop, list[Replica]]
) -> tuple[MeasuredLoop, list[Replica]]:
    """Return two measurements of one loop as one; at a frequency of both the second counts.

    Raises
    ------
    InputError
        If they average different numbers of periods.
    """
    one, two = first[0], second[0]
    if one.periods != two.periods:
        raise InputError(f"measurements of {one.periods} and {two.periods} periods cannot be merged")
    apart = np.min(np.abs(one.frequency[:, None] - two.frequency[None, :]), axis=1) > 1e-9
    order = np.argsort(np.concatenate([one.frequency[apart], two.frequency]))

    def joined(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([a[apart], b])[order]

    loop = replace(
        one,
        frequency=joined(one.frequency, two.frequency),
        together=joined(one.together, two.together),
        single=joined(one.single, two.single),
        together_uncertainty=joined(one.together_uncertainty, two.together_uncertainty),
        single_uncertainty=joined(one.single_uncertainty, two.single_uncertainty),
        coherence=joined(one.coherence, two.coherence),
        coherence_together=joined(one.coherence_together, two.coherence_together),
    )
    replicas = [(joined(a[0], b[0]), joined(a[1], b[1])) for a, b in zip(first[1], second[1], strict=True)]
    return loop, replicas


def jackknife(replicas: Sequence[NDArray[np.generic]]) -> Array:
    """Return the standard deviation of a mean from its values with one sample left out at a time."""
    stacked = np.stack(replicas)
    count = len(stacked)
    scatter = np.sum(np.abs(stacked - stacked.mean(axis=0)) ** 2, axis=0)
    return np.asarray(np.sqrt((count - 1) / count * scatter))


def measured_margins(measured: MeasuredLoop, replicas: Sequence[Replica], which: str) -> MeasuredMargins:
    """Return the margins of one direction, or of all `together`, with their uncertainties.

    These count the scatter of the periods, the interpolation between the lines and a small bias of the linear picture;
    not what lies between lines unseen, nor crossings that are left out.

    Raises
    ------
    InputError
        If fewer than two lines are coherent.
    """
    response, keep = measured.of(which)
    if np.sum(keep) < 2:
        raise InputError(
            f"only {int(np.sum(keep))} of {len(keep)} lines are coherent in {which}: inject more, measure more "
            "periods, or choose another band"
        )
    frequency = measured.frequency[keep]
    value = loop_margins(frequency, response[keep], measured.period)
    column = None if which == TOGETHER else measured.names.index(which)
    picked = [together if column is None else single[:, column] for together, single in replicas]
    others = [loop_margins(frequency, replica[keep], measured.period) for replica in picked]
    quantile = float(stdtrit(measured.periods - 1, 0.5 + 0.5 * CONFIDENCE))
    straight = loop_margins(frequency, response[keep], measured.period, straight=True)
    uncertainty = {}
    for item in fields(Margins):
        if item.name == "unresolved":
            continue
        found = np.array([getattr(other, item.name) for other in others])
        spread = float(jackknife(list(found))) if np.all(np.isfinite(found)) else 0.0
        best, joined = getattr(value, item.name), getattr(straight, item.name)
        between = INTERPOLATION * abs(best - joined) if np.isfinite(best) and np.isfinite(joined) else 0.0
        uncertainty[item.name] = quantile * spread + between + (BIAS * abs(best) if np.isfinite(best) else 0.0)
    return MeasuredMargins(value=value, uncertainty=uncertainty)


def _coherence(back: Complex, inputs: Complex) -> tuple[Array, Array]:
    """Return the coherence of each direction, (f, d), and of all their power, (f,).

    The smaller one of those before and after the injection along the direction. Together, a direction with little
    response counts by its power.
    """
    each, together = np.ones((back.shape[1], back.shape[-1])), np.ones(back.shape[1])
    for signal in (back, inputs):
        own = np.diagonal(signal, axis1=2, axis2=3)  # (periods, f, d)
        power, repeats = np.mean(np.abs(own) ** 2, axis=0), np.abs(own.mean(axis=0)) ** 2
        floor = np.finfo(float).tiny
        each = np.minimum(each, repeats / np.maximum(power, floor))
        together = np.minimum(together, repeats.sum(axis=1) / np.maximum(power.sum(axis=1), floor))
    return each, together
