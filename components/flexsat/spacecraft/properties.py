"""What a spacecraft is before a controller is designed: modes, how wheels and gyros reach them, and envelopes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import Array
from .assembly import RIGID, Spacecraft

PARALLEL = 1e-9  # sine of the angle below which two axes are one


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeTable:
    """The modes of the structure clamped at the bus, and those of the free spacecraft, both from the lowest."""

    clamped: Array  # (m,) [rad/s]
    effective_mass: Array  # (3, m): along x, y, z, over the mass of the spacecraft
    effective_inertia: Array  # (3, m): about x, y, z, over its moments of inertia
    free: Array  # (m,) [rad/s]
    controllability: Array  # (m,): root of the sum of squares of a free mode's response to each wheel, over the largest
    observability: Array  # (m,): the same of the gyros' response to a free mode


@dataclass(frozen=True, slots=True, kw_only=True)
class Envelope:
    """The resultant of wheels that each give at most their own, in any direction."""

    about: Array  # (3,): most about body x, y, z
    weakest: float  # most about the weakest direction
    direction: Array  # (3,): that direction


def mode_table(spacecraft: Spacecraft) -> ModeTable:
    """Return both sets of modes; those of the free spacecraft are normalised to its mass matrix."""
    size = RIGID + spacecraft.mode_count
    stiffness = np.zeros((size, size))
    stiffness[RIGID:, RIGID:] = np.diag(spacecraft.frequency**2)
    values, shapes = scipy.linalg.eigh(stiffness, spacecraft.mass_matrix)
    flexible = shapes[:, RIGID:]
    gyros = spacecraft.gyros
    sensed = np.hstack([np.zeros((len(gyros.axis), 3)), gyros.axis, gyros.axial_slope]) @ flexible
    driven = spacecraft.torque_influence.T @ flexible
    return ModeTable(
        clamped=spacecraft.frequency,
        effective_mass=spacecraft.translation**2 / spacecraft.mass,
        effective_inertia=spacecraft.rotation**2 / np.diag(spacecraft.inertia)[:, None],
        free=np.sqrt(values[RIGID:]),
        controllability=_over_largest(np.linalg.norm(driven, axis=0)),
        observability=_over_largest(np.linalg.norm(sensed, axis=0)),
    )


def envelope(axes: Array) -> Envelope:
    """Return what wheels along axes, (n, 3), give together: each at most as much as its axis is long.

    Their resultants fill a zonotope. Each of its faces is spanned by two axes, and lies at the sum of the shares of all
    wheels along its normal; the most about a direction is where it leaves the first face.

    Raises
    ------
    ValueError
        If all axes lie in one plane.
    """
    normals, reach = _faces(axes)
    nearest = int(np.argmin(reach))
    return Envelope(about=extent(axes, np.eye(3)), weakest=float(reach[nearest]), direction=normals[nearest])


def extent(axes: Array, directions: Array) -> Array:
    """Return the most along each of some unit vectors, (k, 3) to (k,); axes and errors as of `envelope`."""
    normals, reach = _faces(axes)
    with np.errstate(divide="ignore"):
        return np.asarray(np.min(reach[:, None] / np.abs(normals @ directions.T), axis=0))


def _faces(axes: Array) -> tuple[Array, Array]:
    """Return the unit normals of the faces of an envelope, (f, 3), and their distances, (f,)."""
    longest = float(np.linalg.norm(axes, axis=1).max())
    axes = axes / longest
    first, second = np.triu_indices(len(axes), 1)
    normals = np.cross(axes[first], axes[second])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > PARALLEL] / lengths[lengths > PARALLEL, None]
    reach = np.abs(normals @ axes.T).sum(axis=1)
    if len(reach) == 0 or reach.min() < PARALLEL:
        raise ValueError("envelope: the axes lie in one plane, and give nothing across it")
    return normals, longest * reach


def _over_largest(values: Array) -> Array:
    return np.asarray(values / max(float(values.max(initial=0.0)), np.finfo(np.float64).tiny))
