"""Stability of a design on the full structure: over mode count, model errors, gain, phase and delay."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from flexsat.design.chain import Design
from flexsat.parameters import ConfigurationName
from flexsat.spacecraft.assembly import Spacecraft
from flexsat.spacecraft.linear_model import LinearModel, linearise
from flexsat.spacecraft.variation import ModelErrors, full_spacecraft, keep_modes, with_errors
from lockstep.errors import InputError

from ..margins.designed_loop import DesignedLoop

ALL_MODES = 198  # of the mesh of record below 80 Hz
MODE_COUNTS = (25, 28, 40, 60, 100, 150, ALL_MODES)
GAINS = (0.5, 2.0)  # 6 dB
PHASE = 30.0  # deg
DELAY: dict[ConfigurationName, float] = {"centralised": 0.020, "distributed": 0.010}  # s
ERRORS = ModelErrors(frequency=0.05, damping=0.5, inertia=0.1)


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
        named = {"frequency": errors.frequency, "damping": errors.damping, "inertia": errors.inertia}
        parts = [f"{name} {100 * value:+g} %" for name, value in named.items() if value]
        parts += [f"gain {self.gain:g}"] if self.gain != 1.0 else []
        parts += [f"phase {self.phase:+g} deg"] if self.phase else []
        parts += [f"delay {1e3 * self.delay:g} ms"] if self.delay else []
        return f"{self.modes} modes: {', '.join(parts) or 'nominal'}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Stability:
    """What a corner does to the loop."""

    corner: Corner
    growth: float  # 1/s, of the slowest closed-loop pole: negative if stable
    frequency: float  # Hz, of that pole, folded below half the star tracker's rate

    @property
    def stable(self) -> bool:
        """Whether every pole decays."""
        return self.growth < 0.0


def required_corners(name: ConfigurationName, modes: int = ALL_MODES) -> Iterator[Corner]:
    """Yield the corners at which a robust design must be stable: mode counts, margins, and all errors together."""
    yield from (Corner(modes=count) for count in MODE_COUNTS if count <= modes)
    yield from (Corner(modes=modes, gain=gain) for gain in GAINS)
    yield from (Corner(modes=modes, phase=sign * PHASE) for sign in (-1.0, 1.0))
    yield from (Corner(modes=modes, delay=share * DELAY[name]) for share in (0.25, 0.5, 0.75, 1.0))
    both = (-1.0, 1.0)
    for count in sorted({25, 28, modes}):
        for frequency, damping, inertia in product(both, both, both):
            yield Corner(
                modes=count,
                errors=ModelErrors(
                    frequency=frequency * ERRORS.frequency,
                    damping=damping * ERRORS.damping,
                    inertia=inertia * ERRORS.inertia,
                ),
            )


class Plants:
    """Linear models of the real structure, made once for each mode count and set of errors."""

    def __init__(self, design: Design, modes: int = ALL_MODES) -> None:
        self.design = design
        self.spacecraft: Spacecraft = full_spacecraft(design.config, modes)
        self._models: dict[tuple[int, ModelErrors], LinearModel] = {}

    def model(self, modes: int, errors: ModelErrors) -> LinearModel:
        """Return the linear model with the lowest modes, at the wheel speeds of the design.

        Raises
        ------
        InputError
            For more modes than there are.
        """
        if modes > self.spacecraft.mode_count:
            raise InputError(f"{modes} modes: the structure was built with {self.spacecraft.mode_count}")
        key = (modes, errors)
        if key not in self._models:
            real = with_errors(keep_modes(self.spacecraft, slice(modes)), errors)
            speed, corner = self.design.controller.nominal_speed, self.design.config.noise.filter_frequency
            self._models[key] = linearise(real, speed, corner)
        return self._models[key]


def stability(plants: Plants, corner: Corner, fine: bool = True) -> Stability:
    """Return the growth rate of the loop at a corner, exact over the star tracker's period.

    Parameters
    ----------
    plants : of the design
    corner : the real plant, and the gain, phase and delay of all its inputs together
    fine : with the gains for the fine guidance sensor, else for the coarse star tracker
    """
    loop = DesignedLoop(
        design=plants.design,
        plant=plants.model(corner.modes, corner.errors),
        parameters={"star_tracker.fine": fine},
    )
    opened = loop.at(corner.delay)
    factor = corner.gain * np.exp(1j * np.deg2rad(corner.phase)) if corner.phase else corner.gain
    values = np.linalg.eigvals(opened.monodromy(factor))
    slowest = values[np.argmax(np.abs(values))]
    span = opened.steps * opened.period
    return Stability(
        corner=corner,
        growth=float(np.log(np.abs(slowest)) / span),
        frequency=float(np.abs(np.angle(slowest)) / (2.0 * np.pi * span)),
    )


HEADER = ("plant", "growth [1/s]", "at [Hz]", "")


def table_rows(found: Sequence[Stability]) -> list[tuple[str, ...]]:
    """Return a row for each corner."""
    return [
        (s.corner.title, f"{s.growth:+.4f}", f"{s.frequency:.2f}", "stable" if s.stable else "UNSTABLE") for s in found
    ]
