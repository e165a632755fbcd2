"""Compute the metrics of a run that the paper's table shows, in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.variants import AS_PUBLISHED, CORRECTED, Variant
from lockstep import InputError, Signals

from . import histories
from .flown_design import FlownDesign

SETTLED_FROM = 150.0  # s: steady state, P section 5
PUBLISHED_WINDOW = (75.0, 150.0)  # s: converged according to the authors' code, for two rows of the slew
LAST = 50.0  # s at the end of a run, whose RMS defines the settling limit


@dataclass(frozen=True, slots=True, kw_only=True)
class AfterSlew:
    """How two rows of the slew are defined, rate error and deformation: an RMS over a time, divided by a number."""

    begin: float  # s
    end: float = np.inf  # s
    divisor: float = 1.0


def after_slew(variant: Variant) -> AfterSlew:
    """Return how the two rows are defined for a variant (PHYSICS section 7)."""
    begin, end = PUBLISHED_WINDOW
    of_release = {AS_PUBLISHED: AfterSlew(begin=begin, end=end, divisor=np.sqrt(2.0))}
    return of_release.get(variant, AfterSlew(begin=SETTLED_FROM))


@dataclass(frozen=True, slots=True, kw_only=True)
class Windows:
    """Time windows that the metrics of one run refer to."""

    slew_end: float | None  # s; None for a run without a slew
    variant: Variant = CORRECTED  # whose definition the rows of rate and deformation after a slew have


def root_mean_square(values: Array) -> float:
    """Return the RMS of a history."""
    return float(np.sqrt(np.mean(values**2)))


def settling_time(time: Array, error: Array, since: float) -> float:
    """Return how long after `since` [s] the error last exceeds three times the RMS of the last 50 s [s]."""
    limit = 3.0 * root_mean_square(error[time > time[-1] - LAST])
    above = np.flatnonzero(error > limit)
    return max(0.0, float(time[above[-1]]) - since) if len(above) else 0.0


def check_length(signals: Signals) -> None:
    """Raise InputError if the run begins at a checkpoint or ends before the steady state."""
    time = signals.time
    if time[0] > 0.0:
        raise InputError(f"metrics: the run begins at {time[0]:g} s, from a checkpoint, but they need whole runs")
    if not np.any(time > SETTLED_FROM):
        raise InputError(
            f"metrics: the run ends at {time[-1]:g} s, and they refer to t > {SETTLED_FROM:g} s; simulate longer"
        )


def compute_metrics(signals: Signals, design: FlownDesign, windows: Windows) -> Mapping[str, float]:
    """Return the metrics of a run, in SI.

    Parameters
    ----------
    signals : recorded with the default patterns
    design : of the run's FMUs, for the weights of the cost
    windows : when the slew ends, and the variant

    Raises
    ------
    InputError
        If the run begins at a checkpoint, ends before the steady state, or lacks a signal.
    """
    check_length(signals)
    if windows.slew_end is not None and windows.slew_end > SETTLED_FROM:
        raise InputError(
            f"metrics of the paper: refer to t > {SETTLED_FROM:g} s, and the slew ends at {windows.slew_end:.4g} s"
        )
    time = signals.time
    steady = time > SETTLED_FROM
    error = histories.pointing_error(signals)
    torque = histories.torque_norm(signals)
    metrics = {
        **_costs(signals, design),
        "pointing_error": root_mean_square(error[steady]),
        "torque": root_mean_square(torque[steady]),
    }
    rows = after_slew(CORRECTED if windows.slew_end is None else windows.variant)
    window = (time > rows.begin) & (time < rows.end)
    metrics["rate_error"] = root_mean_square(histories.rate_error(signals)[window]) / rows.divisor
    metrics["deformation"] = root_mean_square(histories.deformation(signals)[window]) / rows.divisor
    if windows.slew_end is not None:
        metrics["settling_time"] = settling_time(time, error, windows.slew_end)
    return metrics


def _costs(signals: Signals, design: FlownDesign) -> dict[str, float]:
    """Return the regulator's cost over the samples of the controller; none for a controller of others."""
    if design.cost is None:
        return {}
    total, control = histories.lqr_cost(signals, design)
    samples = histories.controller_rows(signals, design)
    return {"total_cost": float(total[samples].sum()), "control_cost": float(control[samples].sum())}
