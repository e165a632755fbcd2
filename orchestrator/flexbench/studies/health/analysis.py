"""NIS, NEES and whiteness from replays of several seeds, by group of measurements and of states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.slow_errors import TORQUES
from lockstep import InputError

from .covariance import FilterCovariance, filter_covariance
from .replay import Replay
from .slow_errors import SETTLED as SLOW_SETTLED
from .slow_errors import block_means, groups, slow_covariance
from .statistics import Average, autocorrelation, average, normalised, portmanteau, whiteness_bound

SETTLED = 20.0  # s: the filter starts at zero, not in its steady state
LONGER = 2.0  # s, shortest time that is judged: four times the longest lag
MEANS = 1.0  # s: several periods of the slowest wheel, and short against the errors of torque and biases
LAGS = 100  # of the autocorrelation: half a second
SIGNIFICANT = 0.01  # p-value below which a channel is not white


@dataclass(frozen=True, slots=True, kw_only=True)
class Whiteness:
    """Whiteness of the normalised innovations of gyros, accelerometers and encoders of one run."""

    correlation: Array  # (lags, channels)
    bound: float  # that white noise exceeds at 5 % of the lags
    outside: float  # share of lags beyond it, over all channels
    coloured: float  # share of channels that the portmanteau test rejects at 1 %


@dataclass(frozen=True, slots=True, kw_only=True)
class Health:
    """Consistency of one controller's estimator over several runs. Averages are per degree of freedom."""

    configuration: str
    seeds: tuple[int, ...]
    settled_from: float  # s
    innovation: Mapping[str, Average]  # NIS by group of measurements
    error: Mapping[str, Average]  # NEES by group of states, bounds for one independent sample a seed
    history: Array  # (rows, 2): time [s] and NEES of all states, the mean over the seeds
    whiteness: Whiteness  # of the first seed
    needs: float | None = None  # s: of a run that judges the estimated torque and biases, where these do not


def measurement_groups(design: Design) -> dict[str, slice]:
    """Return the rows of each sensor in the innovation."""
    index = design.model.index
    first, second = design.model.gyro_count, design.model.gyro_count + index.accelerometers
    third = second + index.wheels
    return {
        "gyros": slice(0, first),
        "accelerometers": slice(first, second),
        "encoders": slice(second, third),
        "star tracker": slice(third, third + 3),
    }


def state_groups(design: Design) -> dict[str, slice]:
    """Return the rows of each quantity in the state without the anti-aliasing filter."""
    m, n = design.spacecraft.mode_count, design.model.index.wheels
    return {
        "attitude": slice(0, 3),
        "modal displacement": slice(3, 3 + m),
        "rate": slice(3 + m, 6 + m),
        "modal velocity": slice(6 + m, 6 + 2 * m),
        "wheel speed": slice(6 + 2 * m, 6 + 2 * m + n),
        "all": slice(0, 6 + 2 * m + n),
    }


def analyse(replays: Mapping[int, Replay], design: Design, settled_from: float = SETTLED) -> Health:
    """Judge the estimator over the runs of several seeds that differ in nothing else.

    Parameters
    ----------
    replays : by seed
    design : of the controller
    settled_from : judge from this time on [s]

    Raises
    ------
    InputError
        If a run ends before the filter has settled.
    """
    shortest = min(float(run.time[-1]) for run in replays.values())
    if not shortest > settled_from + LONGER:
        raise InputError(
            f"the run ends at {shortest:g} s, and the filter is judged from {settled_from:g} s on;"
            f" simulate more than {settled_from + LONGER:g} s"
        )
    covariances = filter_covariance(design, next(iter(replays.values())).fine)
    settled = {seed: _from(run, settled_from) for seed, run in replays.items()}
    first = next(iter(settled.values()))
    slow, needs = _slow_errors(list(replays.values()), design)
    return Health(
        configuration=design.config.name,
        seeds=tuple(settled),
        settled_from=settled_from,
        innovation=_innovations(list(settled.values()), covariances, design),
        error={name: _errors(list(settled.values()), covariances, part) for name, part in state_groups(design).items()}
        | slow,
        needs=needs,
        history=_history(list(settled.values()), covariances),
        whiteness=_whiteness(first, covariances),
    )


def _slow_errors(runs: Sequence[Replay], design: Design) -> tuple[dict[str, Average], float | None]:
    """Average over time and seeds, from where the filter of torque and biases has settled; each seed is one sample.

    The filter takes gyros for those of a rigid body, so that its estimates follow the vibration at the wheels'
    harmonics: where wheels have jitter its covariance has that of the vibration added. Means of the errors over a
    second, in which little of it is left, are judged by the filter's covariance alone. With it, for runs that end
    before, the time [s] that is needed.
    """
    given = [run.slow for run in runs if run.slow is not None]
    if not given:
        return {}, None
    known = slow_covariance(design, runs[0].fine, given[0].choice)
    start, end = SLOW_SETTLED * known.time_constant, min(float(run.time[-1]) for run in runs)
    if not end > start + LONGER:
        return {}, start + LONGER
    found = {}
    for name, part in groups(given[0].choice, given[0].error.shape[1] - TORQUES).items():
        inside = known.covariance[part, part]
        shaken = inside + known.vibration[part, part] if given[0].shaken else inside
        judged = [slow.error[run.time >= start, part] for run, slow in zip(runs, given, strict=True)]
        rows = round(MEANS / design.config.rates.controller)
        means = [block_means(one, rows) for one in judged]
        for label, errors, covariance in ((name, judged, shaken), (f"{name}, 1 s", means, inside)):
            squares = [np.sum(normalised(one, covariance) ** 2, axis=1) for one in errors]
            found[label] = average(np.array([np.mean(one) for one in squares]), part.stop - part.start)
    return found, None


def _from(run: Replay, start: float) -> Replay:
    keep = run.time >= start
    cut = {name: getattr(run, name)[keep] for name in ("time", "phase", "innovation", "error")}
    return replace(run, **cut)


def _squares(vectors: Array, phase: NDArray[np.intp], covariances: Array, part: slice) -> Array:
    """Return the normalised square of each row's part, with the covariance of its phase."""
    squares = np.zeros(len(vectors))
    for number, covariance in enumerate(covariances):
        rows = phase == number
        if rows.any():
            squares[rows] = np.sum(normalised(vectors[rows, part], covariance[part, part]) ** 2, axis=1)
    return squares


def _innovations(runs: Sequence[Replay], covariances: FilterCovariance, design: Design) -> dict[str, Average]:
    groups = measurement_groups(design)
    found = {}
    for name, part in groups.items():
        squares = []
        for run in runs:
            rows = run.phase == 0 if name == "star tracker" else np.ones(len(run.phase), bool)
            squares.append(_squares(run.innovation[rows], run.phase[rows], covariances.innovation, part))
        found[name] = average(np.concatenate(squares), part.stop - part.start)
    return found


def _errors(runs: Sequence[Replay], covariances: FilterCovariance, part: slice) -> Average:
    """Average over time and seeds; errors are correlated in time, so each seed counts as one sample."""
    means = np.array([np.mean(_squares(run.error, run.phase, covariances.corrected, part)) for run in runs])
    return average(means, part.stop - part.start)


def _history(runs: Sequence[Replay], covariances: FilterCovariance) -> Array:
    part = slice(0, covariances.controlled)
    squares = [_squares(run.error, run.phase, covariances.corrected, part) for run in runs]
    return np.column_stack([runs[0].time, np.mean(squares, axis=0) / covariances.controlled])


def _whiteness(run: Replay, covariances: FilterCovariance) -> Whiteness:
    fast = slice(0, run.innovation.shape[1] - 3)
    white = np.zeros((len(run.time), fast.stop))
    for number, covariance in enumerate(covariances.innovation):
        rows = run.phase == number
        if rows.any():
            white[rows] = normalised(run.innovation[rows, fast], covariance[fast, fast])
    correlation = autocorrelation(white, LAGS)
    bound = whiteness_bound(len(white))
    return Whiteness(
        correlation=correlation,
        bound=bound,
        outside=float(np.mean(np.abs(correlation) > bound)),
        coloured=float(np.mean(portmanteau(correlation, len(white)) < SIGNIFICANT)),
    )
