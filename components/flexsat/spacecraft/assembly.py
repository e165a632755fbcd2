"""The spacecraft: wheels, gyros and accelerometers placed on the structure, and the matrices of their coupling.

Velocities are ordered (v, w, eta'): body velocity, body rate, modal velocities. Jitter of the wheels is ordered
(force a, force b, torque a, torque b), each over all wheels, along the wheel's two lateral axes. What the wheels of a
mount do together is its wrench: (force x, y, z, torque x, y, z), each over all mounts, in body axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..description.configuration import Configuration, Release
from ..description.placement import ALONG, Device, Site
from ..description.wheel_set import WheelSet
from ..fixed_order import product
from ..parameters import ConfigurationName
from ..runtime.rotations import skew
from ..structure.mesh import polar
from ..structure.structure import Structure
from .flexible import node_of, structure_of
from .rigid_bus import join
from .turning import Turning, turned_axes, turning_of, turns_of

RIGID = 6  # coordinates of the rigid body, and modes of the free spacecraft without stiffness


@dataclass(frozen=True, slots=True, kw_only=True)
class Points:
    """Devices on the structure: where they sit, where they point, and how the modes move them."""

    position: Array  # (n, 3) [m] from the spacecraft's centre of mass at rest, body axes
    axis: Array  # (n, 3), unit vectors in body axes
    slope: Array  # (n, 3, m): rotation of the mount per unit modal displacement [rad/(m sqrt(kg))]
    deflection: Array  # (n, 3, m): displacement of the mount per unit modal displacement [1/sqrt(kg)]

    @property
    def axial_slope(self) -> Array:
        """Rotation about each device's own axis per unit modal displacement, (n, m)."""
        return np.asarray(np.einsum("ni,nim->nm", self.axis, self.slope))


@dataclass(frozen=True, slots=True, kw_only=True)
class Spacecraft:
    """Geometry, modes and devices of one configuration, in body axes from the centre of mass at rest."""

    name: ConfigurationName
    mass: float  # kg
    centre: Array  # (3,) of mass at rest, from the origin [m]
    inertia: Array  # (3, 3) [kg.m2] about the centre of mass
    frequency: Array  # (m,) [rad/s]
    damping: Array  # (m,) [1/s]
    translation: Array  # (3, m): L_v [sqrt(kg)]
    rotation: Array  # (3, m): L_w [m sqrt(kg)]
    wheel_set: WheelSet
    wheels: Points
    mounts: Points  # where wheels sit: the bus first, then the sites that carry wheels; axes unused
    mount_of_wheel: NDArray[np.intp]  # (n,)
    lateral_a: Array  # (n, 3): first lateral axis of each wheel
    lateral_b: Array  # (n, 3): second
    gyros: Points
    accelerometers: Points
    turning: Turning  # the appendages that turn

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
        """Map the jitter of the wheels to the wrenches on their mounts, (6 s, 4 n), in body axes."""
        count, wheels = len(self.mounts.position), self.wheel_count
        matrix = np.zeros((2, 3, count, 2, 2, wheels))  # force or torque, x y z, mount; the same, a or b, wheel
        each = np.arange(wheels)
        for kind in range(2):
            for k, lateral in enumerate((self.lateral_a, self.lateral_b)):
                for component in range(3):
                    matrix[kind, component, self.mount_of_wheel, kind, k, each] = lateral[:, component]
        return matrix.reshape(6 * count, 4 * wheels)

    @property
    def wrench_in_mount_axes(self) -> Array:
        """The same, (6 s, 4 n), in axes that turn with each mount's appendage: those of the FMUs' jitter ports."""
        back = self.turning.mount_turn.transpose(0, 2, 1)
        if np.array_equal(back, np.broadcast_to(np.eye(3), back.shape)):
            return self.wrench_of_jitter
        by_mount = self.wrench_of_jitter.reshape(2, 3, len(back), -1)
        return np.asarray(np.einsum("sij,kjsc->kisc", back, by_mount).reshape(6 * len(back), -1))

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
    """Return the lateral axes a, b of wheels along any axes, (n, 3) each: right angles with the axis and each other.

    They are the next two body axes after the one nearest to the wheel's, in turn, made perpendicular. The same for
    both signs of the axis, as an orthonormal complement has no sense of rotation.
    """
    nearest = np.argmax(np.abs(axis), axis=1)
    others = np.sort(np.array([(nearest + 1) % 3, (nearest + 2) % 3]), axis=0)
    first = _perpendicular(np.eye(3)[others[0]], axis)
    return first, _perpendicular(np.eye(3)[others[1]], axis, first)


def _perpendicular(vectors: Array, *axes: Array) -> Array:
    """Return the unit vectors along what is left of vectors, (n, 3), without their parts along orthonormal axes."""
    left = vectors
    for axis in axes:
        left = left - np.sum(vectors * axis, axis=1, keepdims=True) * axis
    return np.asarray(left / np.linalg.norm(left, axis=1, keepdims=True))


def _points(structure: Structure, config: Configuration, placed: Sequence[Device], release: Release) -> Points:
    """Place devices; those on the bus have no modal motion. Positions are from the centre of the aperture."""
    modes = np.zeros((3, len(structure.frequency)))
    moved = {site.name: config.site(row) for site, row in zip(config.structure_sites, release.mode_rows, strict=True)}
    used = {device.site for device in placed}
    nodes = {name: node_of(structure, site) for name, site in moved.items() if name in used}
    sites = [config.site(device.site) for device in placed]
    return Points(
        position=np.array([position_of(structure, site) for site in sites]),
        axis=turned_axes(config, placed),
        slope=np.array([structure.slope_at(nodes[s.name]) if s.name in nodes else modes for s in sites]),
        deflection=np.array([structure.deflection_at(nodes[s.name]) if s.name in nodes else modes for s in sites]),
    )


def position_of(structure: Structure, site: Site) -> Array:
    """Return the position of a site from the centre of the aperture, (3,) [m], body axes."""
    if site.on_bus is not None:
        return np.array(site.on_bus)
    if site.node:
        return np.array(structure.position[node_of(structure, site)])
    return np.append(polar(site.radius, site.angle), 0.0)


def build_spacecraft(config: Configuration, release: Release | None = None) -> Spacecraft:
    """Place the devices of a configuration on its structure, and add the bus.

    Parameters
    ----------
    config : the configuration
    release : whose mode rows the sites have (PHYSICS section 7); None: each its own

    Raises
    ------
    ValueError
        For a site without a node of the structure.
    """
    structure = structure_of(config)
    release = release or config.as_described
    whole = join(structure, config.bus)
    wheels, gyros, accelerometers = (
        _points(structure, config, placed, release) for placed in (config.wheels, config.gyros, config.accelerometers)
    )
    carrying = {device.site for device in config.wheels}
    occupied = [site.name for site in config.all_sites if site.name in carrying]
    mounts = [Device(site=name, axis=ALONG["+z"]) for name in occupied]
    lateral_a, lateral_b = _lateral_axes(config)
    turning = turning_of(config, structure, [config.site(name) for name in occupied], whole.centre)
    return Spacecraft(
        name=config.name,
        mass=whole.mass,
        centre=whole.centre,
        inertia=whole.inertia,
        frequency=structure.frequency,
        damping=structure.damping,
        translation=structure.translation,
        rotation=whole.rotation,
        wheel_set=config.wheel_set,
        wheels=_from(whole.centre, wheels),
        mounts=_from(whole.centre, _points(structure, config, mounts, release)),
        mount_of_wheel=np.array([occupied.index(device.site) for device in config.wheels]),
        lateral_a=lateral_a,
        lateral_b=lateral_b,
        gyros=_from(whole.centre, gyros),
        accelerometers=_from(whole.centre, accelerometers),
        turning=turning,
    )


def _lateral_axes(config: Configuration) -> tuple[Array, Array]:
    """Return the lateral axes of the wheels; on an appendage that turns they turn with it."""
    stated = np.array([device.axis for device in config.wheels])
    first, second = lateral_axes(stated)
    turns = turns_of(config, [config.site(device.site) for device in config.wheels])
    if turns is None:
        return first, second
    return np.einsum("nij,nj->ni", turns, first), np.einsum("nij,nj->ni", turns, second)


def _from(centre: Array, points: Points) -> Points:
    """Return devices with their positions from the centre of mass."""
    return replace(points, position=points.position - centre) if np.any(centre) else points
