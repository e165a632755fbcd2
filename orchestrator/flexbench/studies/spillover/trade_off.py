"""Trade-off curves of a design: pointing, torque and deformation against the delay that the loop tolerates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from flexsat.design.chain import build_design
from flexsat.parameters import ARCSECOND, Configuration, Weights
from flexsat.spacecraft.variation import ModelErrors

from ..margins.real_plant import Corner, Plants, stability
from .stationary import Stationary, stationary

DELAYS = (0.0025, 0.005, 0.0075, 0.010, 0.0125, 0.015, 0.020, 0.025, 0.030, 0.040)  # s
LOOP_FACTORS = (0.1, 0.3, 1.0, 3.0, 10.0)  # of the torque weight: below 1 the feedback is stronger
EFFORT_FACTORS = (0.01, 0.1, 1.0, 10.0, 100.0)  # of the weight of torque against harmonic deformation


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One design of a curve."""

    curve: str
    factor: float  # of the varied weight; 1 is the chosen design
    stable: bool
    delay: float  # s: the largest of DELAYS up to which the loop is stable
    settled: Stationary | None  # None if the loop is unstable

    @property
    def row(self) -> tuple[str, ...]:
        """The point as a row of the table."""
        words = (self.curve, f"{self.factor:g}", f"{1e3 * self.delay:g}" if self.stable else "unstable")
        if self.settled is None:
            return (*words, "", "", "")
        found = self.settled
        return (*words, f"{found.pointing / ARCSECOND:.4f}", f"{found.torque:.4f}", f"{1e6 * found.deformation:.4f}")


HEADER = ("varied", "factor", "delay [ms]", "pointing [arcsec]", "torque [N.m]", "deformation [um]")


def variations(weights: Weights) -> Iterator[tuple[str, float, Weights]]:
    """Yield the weights of both curves, each with its name and factor."""
    for factor in LOOP_FACTORS:
        yield "torque weight of the feedback", factor, replace(weights, torque=factor * weights.torque)
    if weights.jitter_cancellation > 0.0:
        for factor in EFFORT_FACTORS:
            effort = factor * weights.jitter_cancellation
            yield "torque weight of the jitter's cancellation", factor, replace(weights, jitter_cancellation=effort)


def trade_off(config: Configuration, modes: int, delays: Sequence[float] = DELAYS) -> Iterator[Point]:
    """Yield the points of both curves, each a whole design.

    Parameters
    ----------
    config : with the chosen weights
    modes : of the real structure
    delays : tried one after the other until one is not tolerated [s]
    """
    for curve, factor, weights in variations(config.weights):
        plants = Plants(build_design(replace(config, weights=weights)), modes)
        stable = stability(plants, Corner(modes=modes)).stable
        tolerated = 0.0
        for delay in delays if stable else ():
            if not stability(plants, Corner(modes=modes, delay=delay)).stable:
                break
            tolerated = delay
        settled = None
        if stable:
            settled = stationary(plants.design, plants.model(modes, ModelErrors()), plants.spacecraft.mass)
        yield Point(curve=curve, factor=factor, stable=stable, delay=tolerated, settled=settled)
