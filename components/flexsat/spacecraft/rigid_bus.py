"""Join the rigid bus and the structure that is clamped to it: mass, inertia and centre of mass of the whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..description.placement import Bus
from ..fixed_order import product
from ..runtime.rotations import skew
from ..structure.structure import Structure


@dataclass(frozen=True, slots=True, kw_only=True)
class Whole:
    """Structure and bus as one body at rest."""

    mass: float  # kg
    centre: Array  # (3,) [m]: the centre of mass, from the centre of the aperture
    inertia: Array  # (3, 3) [kg.m2] about the centre of mass
    rotation: Array  # (3, m) [m sqrt(kg)]: coupling of the modes to rotation about it


def join(structure: Structure, bus: Bus) -> Whole:
    """Return structure and bus as one body.

    With c the centre of mass of the whole, the moment of the modes' momentum about it is L_w - c x L_v, and the inertia
    about it follows by Steiner's theorem.
    """
    if bus.mass == 0.0 and not np.any(structure.first_moment):
        return Whole(
            mass=structure.total_mass,
            centre=np.zeros(3),
            inertia=structure.inertia,
            rotation=structure.rotation,
        )
    own, place = bus.inertia_matrix, np.array(bus.centre_of_mass)
    mass = structure.total_mass + bus.mass
    centre = (bus.mass * place + structure.first_moment) / mass
    inertia = structure.inertia + own + bus.mass * _of_point(place) - mass * _of_point(centre)
    return Whole(
        mass=mass,
        centre=centre,
        inertia=inertia,
        rotation=np.asarray(structure.rotation - product(skew(centre.tolist()), structure.translation)),
    )


def _of_point(place: Array) -> Array:
    """Return the inertia about the origin of one kilogram at a place, (3, 3) [m2]."""
    return np.asarray((place @ place) * np.eye(3) - np.outer(place, place))
