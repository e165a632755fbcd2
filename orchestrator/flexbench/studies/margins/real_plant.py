"""The loop with the real structure: more modes than the controller knows, errors of its model, gain, phase, delay."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from flexsat.arrays import Array, Complex
from flexsat.design.chain import Design
from flexsat.parameters import ALL_MODES
from flexsat.spacecraft.assembly import Spacecraft
from flexsat.spacecraft.linear_model import LinearModel, linearise
from flexsat.spacecraft.variation import ModelErrors, keep_modes, with_errors
from lockstep.errors import InputError

from .designed_loop import DesignedLoop
from .periodic_loop import PeriodicLoop, largest_eigenvalues

NEAR, ITERATIONS = 1e-9, 3  # of inverse iteration: relative distance to the eigenvalue
KEPT = 4  # loops
MODE_COUNTS = (25, 28, 40, 60, 100, 150, ALL_MODES)


@dataclass(frozen=True, slots=True, kw_only=True)
class Corner:
    """One real plant, and a change of all its inputs that the controller does not know."""

    modes: int
    errors: ModelErrors = field(default_factory=ModelErrors)
    gain: float = 1.0
    phase: float = 0.0  # deg, of lead
    delay: float = 0.0  # s

    @property
    def title(self) -> str:
        """What differs from the model, in words."""
        errors = self.errors
        parts = [f"{name} {100 * value:+g} %" for name, value in asdict(errors).items() if value]
        parts += [f"gain {self.gain:g}"] if self.gain != 1.0 else []
        parts += [f"phase {self.phase:+g} deg"] if self.phase else []
        parts += [f"delay {1e3 * self.delay:g} ms"] if self.delay else []
        return f"{self.modes} modes: {', '.join(parts) or 'nominal'}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stability:
    """What a corner does to the loop."""

    corner: Corner
    highest: float  # Hz, frequency of the highest mode that the plant has
    growth: float  # 1/s, of the slowest closed-loop pole: negative if stable
    frequency: float  # Hz, at which that pole moves the torques most

    @property
    def stable(self) -> bool:
        """Whether every pole decays."""
        return self.growth < 0.0


class Plants:
    """Linear models of the real structure, made once for each mode count and set of errors."""

    def __init__(
        self, design: Design, modes: int = ALL_MODES, real: Spacecraft | None = None, gyroscopic: bool = True
    ) -> None:
        """Take the real spacecraft, or the design's structure with so many of its modes."""
        self.design = design
        self.gyroscopic = gyroscopic
        self.spacecraft: Spacecraft = real or keep_modes(design.structure, slice(modes))
        self._models: dict[tuple[int, ModelErrors], LinearModel] = {}
        self._loops: dict[tuple[int, ModelErrors, bool], tuple[DesignedLoop | None, DesignedLoop]] = {}

    def model(self, modes: int, errors: ModelErrors) -> LinearModel:
        """Return the linear model with the lowest modes, at the wheel speeds of the design.

        Raises
        ------
        InputError
            For more modes than there are.
        """
        if modes > self.spacecraft.mode_count:
            raise InputError(f"{modes} modes: the structure has {self.spacecraft.mode_count}")
        key = (modes, errors)
        if key not in self._models:
            real = with_errors(keep_modes(self.spacecraft, slice(modes)), errors)
            speed, corner = self.design.controller.nominal_speed, self.design.config.noise.filter_frequency
            self._models[key] = linearise(real, speed, corner, self.gyroscopic)
        return self._models[key]

    def loop(self, modes: int, errors: ModelErrors, fine: bool, given: DesignedLoop | None) -> DesignedLoop:
        """Return the loop on one of these plants; the last are kept, as several gains and delays are tried on each.

        The arguments are those of `stability`.
        """
        key = (modes, errors, fine)
        kept = self._loops.pop(key, None)
        if kept is None or kept[0] is not given:
            loop = given or DesignedLoop(design=self.design, parameters={"star_tracker.fine": fine})
            kept = given, replace(loop, plant=self.model(modes, errors))
        self._loops[key] = kept
        if len(self._loops) > KEPT:
            del self._loops[next(iter(self._loops))]
        return kept[1]

    def highest(self, modes: int) -> float:
        """Return the frequency of the highest of so many modes [Hz]."""
        return float(self.spacecraft.frequency[modes - 1] / (2.0 * np.pi))


def stability(plants: Plants, corner: Corner, fine: bool = True, loop: DesignedLoop | None = None) -> Stability:
    """Return the growth rate of the loop at a corner, exact over the star tracker's period.

    Parameters
    ----------
    plants : of the design
    corner : the real plant, and the gain, phase and delay of all its inputs together
    fine : with the gains for the fine guidance sensor, else for the coarse star tracker
    loop : with delays and parameters of a run; None for no delays and the controller's own parameters
    """
    opened = plants.loop(corner.modes, corner.errors, fine, loop).at(corner.delay)
    factor = corner.gain * np.exp(1j * np.deg2rad(corner.phase)) if corner.phase else corner.gain
    growth, frequency = growth_of_loop(opened, factor)
    return Stability(corner=corner, highest=plants.highest(corner.modes), growth=growth, frequency=frequency)


def growth_of_loop(opened: PeriodicLoop, factor: complex = 1.0) -> tuple[float, float]:
    """Return growth [1/s] and frequency [Hz] of the slowest pole of a loop closed with a factor on what comes back.

    A pole over the star tracker's period has its frequency folded below half the tracker's rate. Its motion within the
    period gives the frequency: that of the strongest line of what comes back.
    """
    monodromy = opened.monodromy(factor)
    values = largest_eigenvalues(monodromy)
    slowest = values[np.argmax(np.abs(values))]
    span = opened.steps * opened.period
    folded = float(np.angle(slowest)) / (2.0 * np.pi * span)
    first, rest = opened.closed(factor)
    states = [_eigenvector(monodromy, slowest)]
    for step in range(opened.steps - 1):
        states.append((rest if step else first) @ states[-1])
    back = np.array([opened.first.c @ states[0], *(opened.rest.c @ state for state in states[1:])])
    turns = np.exp(-2j * np.pi * folded * opened.period * np.arange(opened.steps))
    power = np.sum(np.abs(np.fft.fft(back * turns[:, None], axis=0)) ** 2, axis=1)
    lines = folded + np.fft.fftfreq(opened.steps, opened.period)
    return float(np.log(np.abs(slowest)) / span), float(np.abs(lines[np.argmax(power)]))


def _eigenvector(matrix: Array | Complex, value: complex) -> Complex:
    """Return the eigenvector of a known eigenvalue, by inverse iteration."""
    factors = lu_factor(matrix - value * (1.0 + NEAR) * np.eye(len(matrix)), overwrite_a=True, check_finite=False)
    vector = np.ones(len(matrix), dtype=complex)
    for _ in range(ITERATIONS):
        vector = lu_solve(factors, vector, check_finite=False)
        vector /= np.linalg.norm(vector)
    return np.asarray(vector)


HEADER = ("plant", "growth [1/s]", "at [Hz]", "")


def table_rows(found: Iterable[Stability]) -> list[tuple[str, ...]]:
    """Return a row for each corner."""
    return [
        (s.corner.title, f"{s.growth:+.4f}", f"{s.frequency:.2f}", "stable" if s.stable else "UNSTABLE") for s in found
    ]
