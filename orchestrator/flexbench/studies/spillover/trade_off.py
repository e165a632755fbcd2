"""Trade-off curves of a design: pointing, torque and deformation against the delay that the loop tolerates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from flexsat.description.built_in import configuration
from flexsat.description.configuration import Configuration
from flexsat.design.chain import build_design
from flexsat.parameters import ALL_MODES, ARCSECOND, ConfigurationName, Weights
from flexsat.spacecraft.variation import ModelErrors

from ..margins.real_plant import Corner, Plants, stability
from .stationary import Stationary, stationary

DELAYS = (0.0025, 0.005, 0.0075, 0.010, 0.0125, 0.015, 0.020, 0.025, 0.030, 0.040, 0.050, 0.060, 0.080)  # s
HALVINGS = 4  # between the last delay that is tolerated and the first that is not
LOOP_FACTORS = (0.1, 0.3, 1.0, 3.0, 10.0)  # of the torque weight: below 1 the feedback is stronger
EFFORT_FACTORS = (0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0)  # of the weight of torque against deformation
FEEDBACK, CANCELLATION = "torque weight of the feedback", "torque weight of the jitter's cancellation"


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One design of a curve."""

    curve: str
    factor: float  # of the varied weight; 1 is the chosen design
    stable: bool
    delay: float  # s: up to which the loop is stable, as far as it was tried
    settled: Stationary | None  # None if the loop is unstable

    @property
    def row(self) -> tuple[str, ...]:
        """The point as a row of the table."""
        words = (self.curve, f"{self.factor:g}", f"{1e3 * self.delay:.1f}" if self.stable else "unstable")
        if self.settled is None:
            return (*words, "", "", "")
        found = self.settled
        return (*words, f"{found.pointing / ARCSECOND:.4f}", f"{found.torque:.4f}", f"{1e6 * found.deformation:.4f}")


HEADER = ("varied", "factor", "delay [ms]", "pointing [arcsec]", "torque [N.m]", "deformation [µm]")


def variations(weights: Weights) -> Iterator[tuple[str, float, Weights]]:
    """Yield the weights of both curves, each with its name and factor."""
    for factor in LOOP_FACTORS:
        yield FEEDBACK, factor, replace(weights, torque=factor * weights.torque)
    if weights.jitter_cancellation > 0.0:
        for factor in EFFORT_FACTORS:
            effort = factor * weights.jitter_cancellation
            yield CANCELLATION, factor, replace(weights, jitter_cancellation=effort)


def robust_trade_off(name: ConfigurationName) -> list[Point]:
    """Return the points of both curves of a layout's robust design."""
    return list(trade_off(configuration(name, "robust"), ALL_MODES))


def trade_off(config: Configuration, modes: int, delays: Sequence[float] = DELAYS) -> Iterator[Point]:
    """Yield the points of both curves, each a whole design.

    Parameters
    ----------
    config : with the chosen weights
    modes : of the real structure
    delays : tried one after the other until one is not tolerated [s]
    """
    feedback: dict[Weights, tuple[bool, float]] = {}  # the cancellation of jitter moves no pole
    for curve, factor, weights in variations(config.weights):
        plants = Plants(build_design(replace(config, weights=weights)), modes)
        of_loop = replace(weights, jitter_cancellation=0.0)
        if of_loop not in feedback:
            stable = stability(plants, Corner(modes=modes)).stable
            feedback[of_loop] = stable, _tolerated(plants, modes, delays) if stable else 0.0
        stable, tolerated = feedback[of_loop]
        settled = None
        if stable:
            settled = stationary(plants.design, plants.model(modes, ModelErrors()), plants.spacecraft.mass)
        yield Point(curve=curve, factor=factor, stable=stable, delay=tolerated, settled=settled)


def _tolerated(plants: Plants, modes: int, delays: Sequence[float]) -> float:
    """Return the delay up to which a loop is stable: one of those tried, or bisected before the first that is not."""
    tolerated = 0.0
    for delay in delays:
        if stability(plants, Corner(modes=modes, delay=delay)).stable:
            tolerated = delay
            continue
        for _ in range(HALVINGS):
            middle = 0.5 * (tolerated + delay)
            if stability(plants, Corner(modes=modes, delay=middle)).stable:
                tolerated = middle
            else:
                delay = middle
        break
    return tolerated
