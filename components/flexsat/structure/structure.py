"""The modal data of a flexible structure: what design, plant, ports and drawings know of any of them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields

import numpy as np

from ..arrays import Array, Index, make_read_only
from .mesh import Mesh

RIGID = 1e-6  # of the rigid mass matrix's diagonal: rounding, and digits of printed data


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Structure:
    """Mass-normalised modes of a structure clamped at its interface, which is the origin of its axes.

    Equal to another one if all its numbers are. Raises ValueError for arrays of different numbers of modes or nodes,
    values that are not finite, and participation that no body of the given mass and inertia has.
    """

    frequency: Array  # (m,) [rad/s], ascending
    damping: Array  # (m,): F of eta'' + F eta' + omega^2 eta [1/s]
    translation: Array  # (3, m): L_v, momentum for unit modal velocities [sqrt(kg)]
    rotation: Array  # (3, m): L_w, angular momentum about the origin [m sqrt(kg)]
    total_mass: float  # kg
    first_moment: Array  # (3,): mass times centre of mass [kg.m]
    inertia: Array  # (3, 3) about the origin [kg.m2]
    position: Array  # (n, 3) of the nodes [m]
    deflection: Array  # (n, 3, m): displacement of the nodes per unit modal displacement [1/sqrt(kg)]
    slope: Array  # (n, 3, m): their rotation vector [1/(m sqrt(kg))]
    names: tuple[str, ...] = ()  # of the nodes; none: they are known by position
    edges: Index  # (e, 2): nodes that drawings join
    mesh: Mesh | None = None  # of an aperture, whose nodes are the first

    def __post_init__(self) -> None:
        self._check_shapes()
        make_read_only(self)
        if not np.all(self.frequency > 0.0) or np.any(np.diff(self.frequency) < -RIGID * self.frequency[1:]):
            raise ValueError("Structure.frequency must be > 0 and ascending; leave out rigid modes, and sort")
        if not np.all(self.damping >= 0.0):
            raise ValueError("Structure.damping must be >= 0")
        left = np.linalg.eigvalsh(self.residual_mass)[0]
        if not left > -RIGID:
            raise ValueError(
                f"Structure.translation, rotation: the modes move {1.0 - left:.6g} times the mass and inertia given"
                " along some direction, and at most 1 is possible; check mass, inertia and the scale of the shapes"
            )

    def _check_shapes(self) -> None:
        modes, nodes = len(self.frequency), len(self.position)
        expected = {
            "damping": (modes,),
            "translation": (3, modes),
            "rotation": (3, modes),
            "first_moment": (3,),
            "inertia": (3, 3),
            "position": (nodes, 3),
            "deflection": (nodes, 3, modes),
            "slope": (nodes, 3, modes),
        }
        for name, shape in expected.items():
            value = getattr(self, name)
            if value.shape != shape:
                raise ValueError(
                    f"Structure.{name} must be {shape} for {modes} modes and {nodes} nodes, got {value.shape}"
                )
            if not np.all(np.isfinite(value)):
                raise ValueError(f"Structure.{name} must be finite numbers")
        if not 0.0 < self.total_mass < np.inf:
            raise ValueError(f"Structure.total_mass must be > 0, got {self.total_mass!r}")
        if self.names and len(self.names) != nodes:
            raise ValueError(f"Structure.names must name all {nodes} nodes, got {len(self.names)} names")

    @property
    def mode_count(self) -> int:
        """Number of modes."""
        return len(self.frequency)

    @property
    def rigid_mass(self) -> Array:
        """Mass matrix of the rigid structure for velocity and rate at the origin, (6, 6)."""
        x, y, z = self.first_moment
        moment = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.block([[self.total_mass * np.eye(3), -moment], [moment, self.inertia]])

    @property
    def participation(self) -> Array:
        """Momentum and angular momentum for unit modal velocities, (6, m)."""
        return np.vstack([self.translation, self.rotation])

    @property
    def residual_mass(self) -> Array:
        """The share of the rigid mass matrix that no mode moves, (6, 6): between 0 and I, 0 with all modes."""
        mass = self.rigid_mass
        diagonal = np.diag(mass)
        scale = np.sqrt(np.where(diagonal > RIGID * np.max(diagonal), diagonal, np.max(diagonal)))
        left = mass - self.participation @ self.participation.T
        return np.asarray(left / np.outer(scale, scale))

    @property
    def digest(self) -> bytes:
        """A hash of all numbers and names."""
        found = hashlib.sha256()
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name != "mesh":
                found.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
        return found.digest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Structure) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def slope_at(self, node: int) -> Array:
        """Return the rotation vector of a node per unit modal displacement, (3, m)."""
        return np.asarray(self.slope[node])

    def deflection_at(self, node: int) -> Array:
        """Return the displacement of a node per unit modal displacement, (3, m)."""
        return np.asarray(self.deflection[node])

    def node_named(self, name: str) -> int:
        """Return a node by its name; raise ValueError if there is none."""
        if name not in self.names:
            shown = ", ".join(self.names[:12]) + (", ..." if len(self.names) > 12 else "")
            raise ValueError(f"node {name!r}: no such node; there are {shown or 'no named nodes'}")
        return self.names.index(name)
