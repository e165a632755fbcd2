"""The spacecraft: wheels, gyros and accelerometers placed on the structure, and the matrices of their coupling.

Velocities are ordered (v, w, eta'): body velocity, body rate, modal velocities. Jitter of the wheels is ordered
(force a, force b, torque a, torque b), each over all wheels, along the wheel's two lateral axes. What the wheels of a
mount do together is its wrench: (force x, y, z, torque x, y, z), each over all mounts, in body axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..fixed_order import product
from ..parameters import SITES, SITES_OF_MODE_ROWS_AS_PUBLISHED, Configuration, ConfigurationName, Wheel
from ..runtime.rotations import skew
from ..structure.mesh import polar, record_mesh
from ..structure.modes import Structure, build_structure


@dataclass(frozen=True, slots=True, kw_only=True)
class Points:
    """Devices on the structure: where they sit, where they point, and how the modes move them."""

    position: Array  # (n, 3) [m], body axes
    axis: Array  # (n, 3), unit vectors in body axes
    slope: Array  # (n, 3, m): rotation of the mount per unit modal displacement [rad/(m sqrt(kg))]
    deflection: Array  # (n, 3, m): displacement of the mount per unit modal displacement [1/sqrt(kg)]

    @property
    def axial_slope(self) -> Array:
        """Rotation about each device's own axis per unit modal displacement, (n, m)."""
        return np.asarray(np.einsum("ni,nim->nm", self.axis, self.slope))


@dataclass(frozen=True, slots=True, kw_only=True)
class Spacecraft:
    """Geometry, modes and devices of one configuration, in body axes."""

    name: ConfigurationName
    mass: float  # kg
    inertia: Array  # (3, 3) [kg.m2]
    frequency: Array  # (m,) [rad/s]
    damping: Array  # (m,) [1/s]
    translation: Array  # (3, m): L_v [sqrt(kg)]
    rotation: Array  # (3, m): L_w [m sqrt(kg)]
    wheel: Wheel
    wheels: Points
    mounts: Points  # where wheels sit: the bus first, then the sites that carry wheels; axes unused
    mount_of_wheel: NDArray[np.intp]  # (n,)
    lateral_a: Array  # (n, 3): first lateral axis of each wheel
    lateral_b: Array  # (n, 3): second
    gyros: Points
    accelerometers: Points

    @property
    def mode_count(self) -> int:
        """Number of modes."""
        return len(self.frequency)

    @property
    def wheel_count(self) -> int:
        """Number of wheels."""
        return len(self.wheels.axis)

    @property
    def mass_matrix(self) -> Array:
        """Generalised mass of (v, w, eta'), (6 + m, 6 + m) (P, equations of motion)."""
        size = 6 + self.mode_count
        matrix = np.eye(size)
        matrix[:3, :3] *= self.mass
        matrix[3:6, 3:6] = self.inertia
        matrix[:3, 6:], matrix[6:, :3] = self.translation, self.translation.T
        matrix[3:6, 6:], matrix[6:, 3:6] = self.rotation, self.rotation.T
        return matrix

    @property
    def torque_influence(self) -> Array:
        """Generalised force of unit wheel torques, (6 + m, n): the reaction on body and modes."""
        wheels = self.wheels
        return np.vstack([np.zeros((3, self.wheel_count)), -wheels.axis.T, -wheels.axial_slope.T])

    @property
    def wrench_influence(self) -> Array:
        """Generalised force of unit wrenches on the mounts, (6 + m, 6 s).

        A force acts on v, on w through its arm and on the modes through the displacement of the mount; a torque acts
        on w and on the modes through the slope.
        """
        count = len(self.mounts.position)
        columns = []
        for axis in np.eye(3):
            along = np.tile(axis, (count, 1))
            modal = np.einsum("i,sim->ms", axis, self.mounts.deflection)
            columns.append(np.vstack([along.T, np.cross(self.mounts.position, along).T, modal]))
        for axis in np.eye(3):
            along = np.tile(axis, (count, 1))
            modal = np.einsum("i,sim->ms", axis, self.mounts.slope)
            columns.append(np.vstack([np.zeros((3, count)), along.T, modal]))
        return np.hstack(columns)

    @property
    def wrench_of_jitter(self) -> Array:
        """Map the jitter of the wheels to the wrenches on their mounts, (6 s, 4 n)."""
        count, wheels = len(self.mounts.position), self.wheel_count
        matrix = np.zeros((2, 3, count, 2, 2, wheels))  # force or torque, x y z, mount; the same, a or b, wheel
        each = np.arange(wheels)
        for kind in range(2):
            for k, lateral in enumerate((self.lateral_a, self.lateral_b)):
                for component in range(3):
                    matrix[kind, component, self.mount_of_wheel, kind, k, each] = lateral[:, component]
        return matrix.reshape(6 * count, 4 * wheels)

    @property
    def jitter_influence(self) -> Array:
        """Generalised force of unit jitter inputs, (6 + m, 4 n)."""
        return product(self.wrench_influence, self.wrench_of_jitter)

    def gyroscopic_matrix(self, momentum: Array) -> Array:
        """Return the matrix g of the gyroscopic force g (v, w, eta') for wheel momenta (n,) [N.m.s], (6+m, 6+m).

        The force sum_i [I N_i]^T ((w + N_i eta') x h_i), on the left-hand side of the equations of motion. It is
        skew-symmetric: gyroscopic forces do no work.
        """
        size = 6 + self.mode_count
        matrix = np.zeros((size, size))
        for i, axis in enumerate(self.wheels.axis):
            lever = np.hstack([np.zeros((3, 3)), np.eye(3), self.wheels.slope[i]])
            matrix -= product(product(lever.T, skew(momentum[i] * axis)), lever)
        return matrix


def lateral_axes(axis: Array) -> tuple[Array, Array]:
    """Return the lateral axes a, b of wheels along +-x, +-y or +-z, (n, 3) each: the next body axes in turn.

    The same for both signs of the axis, as an orthonormal complement has no sense of rotation.
    """
    main = np.argmax(np.abs(axis), axis=1)
    others = np.sort(np.array([(main + 1) % 3, (main + 2) % 3]), axis=0)
    return np.eye(3)[others[0]], np.eye(3)[others[1]]


def _points(structure: Structure, placed: list[tuple[int, Array]], as_published: bool) -> Points:
    """Place devices, each given as a site (-1 the bus, which has no modal motion) and an axis."""
    modes = np.zeros((3, len(structure.frequency)))
    mode_rows = SITES_OF_MODE_ROWS_AS_PUBLISHED if as_published else SITES
    nodes = [structure.mesh.node_at(*site) for site in mode_rows]
    return Points(
        position=np.array([np.zeros(3) if s < 0 else np.append(polar(*SITES[s]), 0.0) for s, _ in placed]),
        axis=np.array([axis for _, axis in placed]),
        slope=np.array([modes if s < 0 else structure.slope_at(nodes[s]) for s, _ in placed]),
        deflection=np.array([modes if s < 0 else structure.deflection_at(nodes[s]) for s, _ in placed]),
    )


def build_spacecraft(config: Configuration, as_published: bool = False) -> Spacecraft:
    """Place the devices of a configuration on the structure with the mesh of record.

    Parameters
    ----------
    config : the configuration
    as_published : take the mode rows of the sites in the order of the authors' release (PHYSICS section 7)
    """
    structure = build_structure(record_mesh(config.aperture), config.plate)
    x, y, z = np.eye(3)
    sites = range(len(SITES))
    if config.wheels_at_sites:
        signed = [(s, 1.0 if s % 2 == 0 else -1.0) for s in sites]  # P: +x +y +z at the first site, then in turn
        wheels = [(-1, axis) for axis in (x, y, z)] + [(s, sign * axis) for s, sign in signed for axis in (x, y, z)]
    else:
        wheels = [(-1, sign * axis) for sign in (1.0, -1.0) for axis in (x, y, z)]
    gyros = [(-1, axis) for axis in (x, y, z)] + [(s, axis) for s in sites for axis in (x, y)]
    accelerometers = [(-1, axis) for axis in (x, y, z)] + [(s, z) for s in sites]
    placed_wheels = _points(structure, wheels, as_published)
    occupied = sorted({site for site, _ in wheels})
    lateral_a, lateral_b = lateral_axes(placed_wheels.axis)
    return Spacecraft(
        name=config.name,
        mass=structure.total_mass,
        inertia=structure.inertia,
        frequency=structure.frequency,
        damping=structure.damping,
        translation=structure.translation,
        rotation=structure.rotation,
        wheel=config.wheel,
        wheels=placed_wheels,
        mounts=_points(structure, [(site, z) for site in occupied], as_published),
        mount_of_wheel=np.array([occupied.index(site) for site, _ in wheels]),
        lateral_a=lateral_a,
        lateral_b=lateral_b,
        gyros=_points(structure, gyros, as_published),
        accelerometers=_points(structure, accelerometers, as_published),
    )
