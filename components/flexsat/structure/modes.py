"""The supported structure: its lowest modes and how they take part in rigid motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from ..arrays import Array
from ..parameters import Plate
from .kirchhoff_plate import PlateMatrices, assemble
from .mesh import Mesh

Support = Literal["vertices", "edge"]
DENSE_LIMIT = 2000  # degrees of freedom up to which the full eigenvalue problem is quicker than the sparse one
PARTNER_GAP = 1e-6  # relative frequency difference below which two modes are one degenerate pair


@dataclass(frozen=True, slots=True, kw_only=True)
class Structure:
    """Mass-normalised modes of the plate clamped at the hole, in body axes."""

    mesh: Mesh
    frequency: Array  # (m,) [rad/s]
    shape: Array  # (3n, m): nodal w [1/sqrt(kg)] and rotations x, y [1/(m sqrt(kg))] per unit modal displacement
    translation: Array  # (3, m): L_v [sqrt(kg)]
    rotation: Array  # (3, m): L_w [m sqrt(kg)]
    damping: Array  # (m,): Rayleigh damping F [1/s]
    total_mass: float  # kg
    inertia: Array  # (3, 3) about the origin [kg.m2]

    def slope_at(self, node: int) -> Array:
        """Return the rotation vector of a node per unit modal displacement, (3, m)."""
        return np.vstack([self.shape[3 * node + 1 : 3 * node + 3], np.zeros(self.shape.shape[1])])

    def deflection_at(self, node: int) -> Array:
        """Return the displacement of a node per unit modal displacement, (3, m), along z only."""
        return np.vstack([np.zeros((2, self.shape.shape[1])), self.shape[3 * node]])


def clamped_dofs(mesh: Mesh, support: Support) -> NDArray[np.intp]:
    """Return the clamped degrees of freedom: all three at the hole's six vertices, or at every node of its edge."""
    if support == "edge":
        nodes = mesh.hole
    elif support == "vertices":
        radius = np.linalg.norm(mesh.nodes[mesh.hole], axis=1)
        nodes = mesh.hole[radius > radius.max() - 1e-6]
    else:
        raise ValueError(f"support {support!r}: must be 'vertices' or 'edge'")
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def solve_modes(matrices: PlateMatrices, clamped: NDArray[np.intp], count: int) -> tuple[Array, Array]:
    """Return the lowest `count` frequencies, (m,) [rad/s], and mass-normalised shapes, (3n, m)."""
    total = matrices.mass.shape[0]
    free = np.setdiff1d(np.arange(total), clamped)
    stiffness, mass = matrices.stiffness[free][:, free], matrices.mass[free][:, free]
    if len(free) <= DENSE_LIMIT:
        values, vectors = eigh(stiffness.toarray(), mass.toarray(), subset_by_index=[0, count - 1])
    else:
        # a fixed start vector: results repeat
        values, vectors = eigsh(stiffness, count, mass, sigma=0.0, v0=np.ones(len(free)))
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    shapes = np.zeros((total, count))
    shapes[free] = vectors
    return np.sqrt(values), shapes


def fix_signs(frequency: Array, shapes: Array, rotation: Array) -> Array:
    """Return the shapes with signs, and the mixing within degenerate pairs, made repeatable.

    In a degenerate pair the first mode is turned to carry all the coupling to rotation about x, if the pair has any;
    otherwise its first member is turned to have the pair's largest deflection. Then each mode's largest deflection
    is made positive.
    """
    result = shapes.copy()
    k = 0
    while k < len(frequency):
        if k + 1 < len(frequency) and frequency[k + 1] - frequency[k] < PARTNER_GAP * frequency[k]:
            pair = result[:, k : k + 2]
            lever = (rotation @ pair)[0]
            if np.linalg.norm(lever) < 1e-6 * np.linalg.norm(rotation, ord=2):
                lever = pair[3 * int(np.argmax(np.round(np.linalg.norm(pair[::3], axis=1), 9)))]
            cosine, sine = lever / np.linalg.norm(lever)
            result[:, k : k + 2] = pair @ np.array([[cosine, -sine], [sine, cosine]])
            k += 1
        k += 1
    deflection = result[::3]
    largest = np.argmax(np.round(np.abs(deflection), 9), axis=0)  # rounded: symmetric nodes tie
    result *= np.sign(deflection[largest, np.arange(result.shape[1])])
    return result


def build_structure(mesh: Mesh, plate: Plate, support: Support = "vertices") -> Structure:
    """Assemble the plate on a mesh, clamp it, and keep the lowest modes with Rayleigh damping."""
    matrices = assemble(mesh, plate)
    frequency, shapes = solve_modes(matrices, clamped_dofs(mesh, support), plate.mode_count)
    shapes = fix_signs(frequency, shapes, matrices.rotation)
    beta_m, beta_k = plate.rayleigh()
    return Structure(
        mesh=mesh,
        frequency=frequency,
        shape=shapes,
        translation=matrices.translation @ shapes,
        rotation=matrices.rotation @ shapes,
        damping=beta_m + beta_k * frequency**2,
        total_mass=matrices.total_mass,
        inertia=matrices.inertia,
    )
