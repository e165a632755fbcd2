"""Compare which modes a controller is designed with: the lowest, or those most coupled to rigid motion.

Each design is judged on the full structure: growth of the linear loop, then its settled pointing, torque and
deformation where it is stable.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import build_design
from flexsat.parameters import (
    ALL_MODES,
    ARCSECOND,
    CONTROLLER_DESIGNS,
    MODE_CHOICES,
    ConfigurationName,
    ControllerDesign,
    ModeChoice,
)
from flexsat.spacecraft.variation import ModelErrors

from ..margins.real_plant import Corner, Plants, Stability, stability
from .stationary import Stationary, stationary

GAINS = (0.5, 1.0, 2.0)  # of the plant's inputs


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """One controller, with modes chosen in one way, on the structure."""

    configuration: ConfigurationName
    controller_design: ControllerDesign
    modes_by: ModeChoice
    highest: float  # Hz, of the modes that the controller knows
    found: Stability  # as it is
    stable_gains: tuple[float, ...]  # of GAINS
    settled: Stationary | None  # None if the loop is unstable

    @property
    def row(self) -> tuple[str, ...]:
        """The choice as a row of the table."""
        words = (
            self.configuration,
            self.controller_design,
            self.modes_by,
            f"{self.highest:.1f}",
            f"{self.found.growth:+.4f}",
            ", ".join(f"{gain:g}" for gain in self.stable_gains) or "none",
        )
        if self.settled is None:
            return (*words, "", "", "")
        found = self.settled
        return (*words, f"{found.pointing / ARCSECOND:.4f}", f"{found.torque:.4f}", f"{1e6 * found.deformation:.4f}")


HEADER = (
    *("layout", "design", "modes by", "up to [Hz]", "growth [1/s]", "stable at gain"),
    *("pointing [arcsec]", "torque [N.m]", "deformation [µm]"),
)


def compare_mode_choices(
    names: Sequence[ConfigurationName] = CONFIGURATIONS,
    designs: Sequence[ControllerDesign] = CONTROLLER_DESIGNS,
    modes: int = ALL_MODES,
) -> Iterator[Choice]:
    """Yield both choices of modes for each layout and controller design, with the weights of the design.

    They are judged on the lowest `modes` of the structure.
    """
    for name in names:
        for controller_design in designs:
            for modes_by in MODE_CHOICES:
                yield _judge(name, controller_design, modes_by, modes)


def _judge(name: ConfigurationName, controller_design: ControllerDesign, modes_by: ModeChoice, modes: int) -> Choice:
    config = configuration(name, controller_design)
    design = build_design(replace(config, modes=replace(config.modes, design_by=modes_by)))
    plants = Plants(design, modes)
    found = {gain: stability(plants, Corner(modes=modes, gain=gain)) for gain in GAINS}
    settled = None
    if found[1.0].stable:
        settled = stationary(design, plants.model(modes, ModelErrors()), plants.spacecraft.mass)
    return Choice(
        configuration=name,
        controller_design=controller_design,
        modes_by=modes_by,
        highest=float(design.spacecraft.frequency.max() / (2.0 * np.pi)),
        found=found[1.0],
        stable_gains=tuple(gain for gain, each in found.items() if each.stable),
        settled=settled,
    )
