"""Where wheels and sensors are mounted: named sites on the structure or on the bus, and axes in body axes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..arrays import Array
from ..parameters import DEGREE, Wheel
from ..quantities import NOT_NEGATIVE, Range, check_ranges

Vector = tuple[float, float, float]

BUS = "bus"  # the site at the origin of the structure, where it is clamped; it has no modal motion
ALONG: dict[str, Vector] = {
    "+x": (1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-x": (-1.0, -0.0, -0.0),  # the negatives of the others, zeros too: results keep their bits
    "-y": (-0.0, -1.0, -0.0),
    "-z": (-0.0, -0.0, -1.0),
}
ROUNDED = 1e-15  # of a unit vector's length: rounding of its components
UNIT = 1e-9  # of a unit vector's length: more than its rounding
TRIANGLE = 1e-9  # of the largest moment of inertia: rounding of a plane or slender body's


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """A place for devices: a node of the aperture at a polar position, one of an appendage, or a point of the bus.

    Positions are from the centre of the aperture, in body axes.
    """

    name: str
    radius: Annotated[float, "m", NOT_NEGATIVE] = 0.0
    angle: Annotated[float, "deg", Range(minimum=-360.0, maximum=360.0)] = 0.0  # from body x
    on_bus: Annotated[Vector, "m"] | None = None  # position of a point of the bus; without the other keys
    node: str = ""  # node of an appendage, written appendage.node

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.node and (self.radius or self.angle or self.on_bus is not None):
            raise ValueError("Site.node is a node of an appendage: leave out radius, angle and on_bus, or leave it out")
        if self.on_bus is not None and (self.radius or self.angle):
            raise ValueError("Site.on_bus is a position on the bus: leave out radius and angle, or leave out on_bus")

    @property
    def on_plate(self) -> bool:
        """Whether it is a node of the aperture."""
        return self.on_bus is None and not self.node


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A wheel or a sensor: the site that it is mounted on, its axis, and what kind of wheel it is.

    A gyro may have a noise of its own, and stand off its axis by a small rotation vector that no filter knows of.
    """

    site: str
    axis: Vector  # unit vector in body axes
    wheel: Wheel | None = None  # of a wheel that is not the spacecraft's usual one; sensors have none
    noise: float | None = None  # rad/s, of a sample of a gyro; None: that of all
    mounting_error: Vector = (0.0, 0.0, 0.0)  # rad, of a gyro

    def __post_init__(self) -> None:
        if not abs(math.hypot(*self.axis) - 1.0) <= UNIT:
            raise ValueError(f"Device.axis must be a unit vector, got {self.axis!r}")
        if self.noise is not None and not 0.0 <= self.noise <= DEGREE:
            raise ValueError(f"Device.noise must be >= 0 and <= {DEGREE:.6g} rad/s, got {self.noise!r}")
        if not all(abs(part) <= DEGREE for part in self.mounting_error):
            raise ValueError(
                f"Device.mounting_error must be at most {DEGREE:.6g} rad about each axis, got {self.mounting_error!r}"
            )

    @property
    def of_its_own(self) -> bool:
        """Whether it has the noise or the mounting error of a single gyro."""
        return self.noise is not None or any(self.mounting_error)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bus:
    """The rigid bus to which the structure is clamped; the spin inertia of the wheels is not part of it."""

    mass: Annotated[float, "kg", Range(minimum=0.0, maximum=1e9)] = 0.0  # P: all mass is in the structure
    inertia: Annotated[tuple[float, ...], "kg.m2", Range(minimum=-1e12, maximum=1e12)] = (
        0.0,
    ) * 6  # about its centre of mass: xx, yy, zz; or these, then xy, xz, yz as in the matrix
    centre_of_mass: Annotated[Vector, "m", Range(minimum=-1e3, maximum=1e3)] = (0.0, 0.0, 0.0)  # from the origin

    def __post_init__(self) -> None:
        check_ranges(self)
        if len(self.inertia) != 6:
            raise ValueError(
                f"Bus.inertia must be 3 moments, or 3 moments and 3 products of inertia, got {len(self.inertia)} values"
            )
        if self.mass == 0.0 and any((*self.inertia, *self.centre_of_mass)):
            raise ValueError("Bus.mass must be > 0 for a bus with inertia or centre of mass, got 0.0")
        low, middle, high = np.linalg.eigvalsh(self.inertia_matrix).tolist()
        if low < -TRIANGLE * high or high > (low + middle) * (1.0 + TRIANGLE):
            raise ValueError(
                f"Bus.inertia is that of no rigid body: its principal moments are {low:.6g}, {middle:.6g} and"
                f" {high:.6g} kg.m2; each must be at least 0 and at most the sum of the others"
            )

    @property
    def inertia_matrix(self) -> Array:
        """The inertia about the bus's own centre of mass, (3, 3) [kg.m2]."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def direction(vector: Vector) -> Vector:
    """Return the unit vector along a vector; raise ValueError for one without length."""
    length = math.hypot(*vector)
    if not 0.0 < length < math.inf:
        raise ValueError(f"an axis has a direction, and {vector!r} has none")
    if abs(length - 1.0) < ROUNDED:
        return vector  # a unit vector that was written to a file and read keeps its bits
    x, y, z = (component / length for component in vector)
    return x, y, z
