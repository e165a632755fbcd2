"""Vary a spacecraft: fewer of its modes, and errors of frequencies, damping and inertia that no controller knows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..description.configuration import Configuration
from ..parameters import Modes
from .assembly import Points, Spacecraft, build_spacecraft


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelErrors:
    """Relative errors of the real structure against the model."""

    frequency: float = 0.0  # of all modal frequencies
    damping: float = 0.0  # of all modal damping
    inertia: float = 0.0  # of all moments of inertia
    participation: float = 0.0  # of the coupling between every mode and the rigid body's motion

    def __post_init__(self) -> None:
        for name, value in (("frequency", self.frequency), ("inertia", self.inertia)):
            if not value > -1.0:
                raise ValueError(f"ModelErrors.{name} must be > -1, got {value!r}")
        for name, value in (("damping", self.damping), ("participation", self.participation)):
            if not value >= -1.0:
                raise ValueError(f"ModelErrors.{name} must be >= -1, got {value!r}")


def with_modes(config: Configuration, count: int) -> Configuration:
    """Return the configuration with a plant of the lowest `count` modes, and a controller that knows no more."""
    known = min(count, config.modes.design)
    return replace(config, modes=replace(config.modes, plant=count, design=known))


def with_angles(config: Configuration, angles: Sequence[float]) -> Configuration:
    """Return the configuration with the appendages that turn at angles [rad], in the order of the file."""
    left = iter(angles)
    turned = (replace(one, angle=next(left)) if one.turns else one for one in config.appendages)
    return replace(config, appendages=tuple(turned))


def modes_of_design(spacecraft: Spacecraft, modes: Modes) -> slice | list[int]:
    """Return the modes that the controller is designed with: the lowest, or those most coupled to rigid motion.

    The coupling of a mode is the share of the spacecraft's mass and moments of inertia that moves with it: what it
    adds to a force or torque that accelerates the whole spacecraft.
    """
    if modes.design_by == "frequency":
        return slice(modes.design)
    share = np.sum(spacecraft.translation**2, axis=0) / spacecraft.mass
    share = share + np.sum(spacecraft.rotation**2 / np.diag(spacecraft.inertia)[:, None], axis=0)
    strongest = np.argsort(-share, kind="stable")[: modes.design]
    return sorted(strongest.tolist())


def full_spacecraft(config: Configuration, count: int) -> Spacecraft:
    """Build the spacecraft with the lowest `count` modes, whatever the plant of the configuration has."""
    return build_spacecraft(with_modes(config, count))


def keep_modes(spacecraft: Spacecraft, kept: Sequence[int] | slice) -> Spacecraft:
    """Return the spacecraft with some of its modes; the others are rigid."""

    def cut(points: Points) -> Points:
        return replace(points, slope=points.slope[:, :, kept], deflection=points.deflection[:, :, kept])

    return replace(
        spacecraft,
        frequency=spacecraft.frequency[kept],
        damping=spacecraft.damping[kept],
        translation=spacecraft.translation[:, kept],
        rotation=spacecraft.rotation[:, kept],
        wheels=cut(spacecraft.wheels),
        mounts=cut(spacecraft.mounts),
        gyros=cut(spacecraft.gyros),
        accelerometers=cut(spacecraft.accelerometers),
        turning=replace(spacecraft.turning, mode_part=spacecraft.turning.mode_part[kept]),
    )


def with_errors(spacecraft: Spacecraft, errors: ModelErrors) -> Spacecraft:
    """Return the spacecraft as it really is.

    More inertia is a rigid body on the bus. Less inertia lightens the structure: its coupling to rotation shrinks by
    the root of the factor, as the modes alone carry nearly all of the inertia and the rest must not become negative.
    """
    factor, coupling = 1.0 + errors.inertia, 1.0 + errors.participation
    rotation: Array = spacecraft.rotation * (coupling * np.sqrt(min(1.0, factor)))
    return replace(
        spacecraft,
        frequency=spacecraft.frequency * (1.0 + errors.frequency),
        damping=spacecraft.damping * (1.0 + errors.damping),
        inertia=spacecraft.inertia * factor,
        translation=spacecraft.translation * coupling,
        rotation=rotation,
    )


def dispersed(
    spacecraft: Spacecraft, frequency: Array, damping: Array, inertia: Array, participation: Array
) -> Spacecraft:
    """Return the spacecraft of a run: relative errors of each mode, (m,), and of the principal inertias, (3,)."""
    return replace(
        spacecraft,
        frequency=spacecraft.frequency * (1.0 + frequency),
        damping=spacecraft.damping * (1.0 + damping),
        inertia=spacecraft.inertia + np.diag(np.diag(spacecraft.inertia) * inertia),
        translation=spacecraft.translation * (1.0 + participation),
        rotation=spacecraft.rotation * (1.0 + participation),
    )
