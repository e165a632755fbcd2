"""A flexible appendage given by its modal data, and where and at which angle it is clamped to the bus."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from ..arrays import Array
from ..quantities import TURN, Range, check_ranges
from ..structure.combine import Placed, rotation_about, turned
from ..structure.structure import Structure
from .placement import UNIT, Vector

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # before the dot of a node's name


@dataclass(frozen=True, slots=True, kw_only=True)
class Appendage:
    """Modal data of a structure, clamped to the bus at a point.

    Its own axes, from its interface, are turned by `orientation` against the body axes, and before that by `angle`
    about `axis` of its own axes: the angle of a drive, at which it stands still. With `turns` the FMU of the plant has
    this angle as a parameter, and axes of devices on the appendage are those at angle 0, in body axes.
    """

    name: str
    structure: Structure
    at: Annotated[Vector, "m", Range(minimum=-1e3, maximum=1e3)] = (0.0, 0.0, 0.0)  # of the interface, from the origin
    orientation: Annotated[Vector, "rad", TURN] = (0.0, 0.0, 0.0)  # rotation vector: angle times axis
    axis: Vector = (1.0, 0.0, 0.0)  # of the drive: unit vector in the appendage's own axes
    angle: Annotated[float, "rad", TURN] = 0.0  # of the drive
    turns: bool = False  # whether the angle is a parameter of the FMUs; devices on the appendage turn with it
    modes: Annotated[int, "1", Range(minimum=1)] = 1_000_000  # the lowest of the data, or all if there are fewer

    def __post_init__(self) -> None:
        check_ranges(self)
        if not NAME.fullmatch(self.name):
            raise ValueError(
                f"Appendage.name must be letters, digits and _, beginning with a letter, got {self.name!r}"
            )
        if not abs(math.hypot(*self.axis) - 1.0) <= UNIT:
            raise ValueError(f"Appendage.axis must be a unit vector, got {self.axis!r}")

    @property
    def drive_axis(self) -> Array:
        """The axis of the drive, (3,), in body axes."""
        return np.asarray(rotation_about(np.array(self.orientation)) @ np.array(self.axis))

    @property
    def body_from_own(self) -> Array:
        """The rotation from its own axes to body axes, (3, 3)."""
        turn = rotation_about(self.angle * np.array(self.axis))
        return np.asarray(rotation_about(np.array(self.orientation)) @ turn)

    @property
    def turn(self) -> Array:
        """The rotation of what it carries from where that is at angle 0, (3, 3), both in body axes."""
        return rotation_about(self.angle * self.drive_axis)

    def in_body(self) -> Structure:
        """Return its modal data in body axes from the body's origin."""
        kept = slice(self.modes)
        own = self.structure
        own = replace(
            own,
            frequency=own.frequency[kept],
            damping=own.damping[kept],
            translation=own.translation[:, kept],
            rotation=own.rotation[:, kept],
            deflection=own.deflection[:, :, kept],
            slope=own.slope[:, :, kept],
        )
        place = Placed(name=self.name, structure=own, at=np.array(self.at), body_from_own=self.body_from_own)
        return turned(place)
