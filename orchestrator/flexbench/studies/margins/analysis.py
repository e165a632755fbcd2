"""Margins of the designed loop: exact ones, and its response over frequency on a grid that follows its resonances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array, Complex

from .designed_loop import DesignedLoop
from .periodic_loop import PeriodicLoop, loop_of_sensitivity
from .response import Margins, largest_singular_values, loop_margins, refine
from .stability import StabilityMargins, stability_margins

LOWEST = 0.01  # Hz
COARSE = 120  # lines to begin with
ROUNDS = 9  # of halving where the loop turns fast
AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """Everything the analysis found; loops by name: all wheels together, the body axes together, each axis alone."""

    exact: StabilityMargins
    frequency: Array  # (f,) [Hz]
    all_wheels: Complex  # (f, n, n)
    body: Complex  # (f, 3, 3)
    axes: Complex  # (f, 3): one axis opened, all else closed
    margins: Mapping[str, Margins]
    sensitivity: Array  # (f,) largest singular value of S, all wheels
    complementary: Array  # (f,) of T
    period: float  # s


def analyse(loop: DesignedLoop, scout: DesignedLoop | None = None) -> Analysis:
    """Return the margins of the designed loop, exact and over frequency.

    `scout` is a smaller loop with nearly the same margins, if there is one: see `stability_margins`.

    The exact ones are those of the periodic loop. The others are those of its time-invariant equivalent: the response
    at the frequency of the injection, which is what a measurement finds (see `complementary_sensitivity`).
    """
    exact = stability_margins(loop.at, None if scout is None else scout.at)
    opened = loop.at()
    frequency, t = _followed(opened)
    share, makes = loop.body_axes
    body, axes = body_loops(t @ share, makes)
    everything = loop_of_sensitivity(t)
    s_max, t_max = largest_singular_values(everything)
    margins = {"all wheels": loop_margins(frequency, everything, opened.period)}
    margins["body axes"] = loop_margins(frequency, body, opened.period)
    for k, axis in enumerate(AXES):
        margins[axis] = loop_margins(frequency, axes[:, k], opened.period)
    return Analysis(
        exact=exact,
        frequency=frequency,
        all_wheels=everything,
        body=body,
        axes=axes,
        margins=margins,
        sensitivity=s_max,
        complementary=t_max,
        period=opened.period,
    )


def body_loops(back: Complex, makes: Array, inputs: Complex | None = None) -> tuple[Complex, Complex]:
    """Return the loops along directions of injection, (f, d, d) together and (f, d) one at a time.

    Parameters
    ----------
    back : (f, m, d) response to an injection along each direction: T w
    makes : (d, m) how much of each direction the channels make, makes @ w = 1
    inputs : (f, m, d) what then acts on the plant, S w; None for w - T w

    Only the part along the directions is opened; the rest of the channels stays closed.
    """
    t = makes @ back
    s = np.eye(len(makes)) - t if inputs is None else makes @ inputs
    single_t, single_s = np.diagonal(t, axis1=1, axis2=2), np.diagonal(s, axis1=1, axis2=2)
    return loop_of_sensitivity(t, s), np.asarray(single_t / single_s)


def _followed(loop: PeriodicLoop) -> tuple[Array, Complex]:
    """Return T on a grid from LOWEST to almost half the sampling rate, denser where the loop turns near gain one."""
    frequency = np.geomspace(LOWEST, 0.495 / loop.period, COARSE)
    respond = loop.response()
    t = respond(frequency)
    for _ in range(ROUNDS):
        more = refine(frequency, loop_of_sensitivity(t))
        if not len(more):
            break
        frequency = np.concatenate([frequency, more])
        t = np.concatenate([t, respond(more)])
        order = np.argsort(frequency)
        frequency, t = frequency[order], t[order]
    return frequency, t
