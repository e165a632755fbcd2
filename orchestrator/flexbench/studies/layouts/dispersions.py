"""Draw the errors of the structure that all layouts of a case are simulated with: one case a seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from lockstep import InputError

from ...loop.scenarios import Value
from ..robustness.model_errors import MOST
from ..spillover.corners import ERRORS

# relative: the robust designs are made for these
LIMITS = {"frequency": ERRORS.frequency, "damping": ERRORS.damping, "inertia": ERRORS.inertia}
_STREAM = 6  # of the draws, apart from those of plant, sensors and the study of robustness


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Relative errors of the structure, which no controller knows."""

    frequency: float = 0.0  # of all modal frequencies
    damping: float = 0.0  # of all modal damping
    inertia: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the principal moments of inertia

    @property
    def participation(self) -> float:
        """The loss of the modes' coupling to rigid motion: with less inertia they carry less of it."""
        return float(np.sqrt(1.0 + min(0.0, *self.inertia)) - 1.0)

    def parameters(self) -> dict[str, Value | tuple[float, ...]]:
        """Return the parameters of the plant; one value for an array is that of all modes."""
        return {
            "dispersion.frequency": self.frequency,
            "dispersion.damping": self.damping,
            "dispersion.inertia": self.inertia,
            "dispersion.participation": self.participation,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Dispersion:
    """How far the structure may be from its model: each error is uniform between minus and plus its limit."""

    frequency: float = field(default=LIMITS["frequency"])
    damping: float = field(default=LIMITS["damping"])
    inertia: float = field(default=LIMITS["inertia"])

    def __post_init__(self) -> None:
        for name in LIMITS:
            most, limit = MOST[name], getattr(self, name)
            if not 0.0 <= limit <= most:
                raise InputError(
                    f"--dispersion {name}={100.0 * limit:g}: must be a percentage from 0 to {100.0 * most:g}"
                )

    def draw(self, seed: int) -> Errors:
        """Return the errors of a seed: of all frequencies alike, of all damping alike, of each moment of inertia."""
        share = np.random.default_rng([seed, _STREAM]).uniform(-1.0, 1.0, 5)
        x, y, z = (self.inertia * share[2:]).tolist()
        return Errors(
            frequency=self.frequency * float(share[0]), damping=self.damping * float(share[1]), inertia=(x, y, z)
        )

    def text(self) -> str:
        """Return the limits in words."""
        percent = {name: 100.0 * float(getattr(self, name)) for name in LIMITS}
        return (
            f"all modal frequencies by up to ±{percent['frequency']:g} %, modal damping by up to"
            f" ±{percent['damping']:g} %, each moment of inertia by up to ±{percent['inertia']:g} %"
        )


def dispersion_of(percent: Mapping[str, float]) -> Dispersion:
    """Return the limits given in percent, the default ones where none is given; InputError for another name."""
    for name in percent:
        if name not in LIMITS:
            raise InputError(f"--dispersion {name}: no such error; there are {', '.join(LIMITS)}")
    return Dispersion(**{name: value / 100.0 for name, value in percent.items()})
