"""The supported structure: its lowest modes and how they take part in rigid motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from ..arrays import Array
from ..fixed_order import on_grid, product
from ..parameters import Plate
from .kirchhoff_plate import PlateMatrices, assemble
from .mesh import Mesh
from .refinement import Eigenpairs, refine

Support = Literal["vertices", "edge"]
DENSE_LIMIT = 2000  # degrees of freedom up to which the full eigenvalue problem is quicker than the sparse one
TIE = 2e-5  # relative difference below which deflections are those of symmetric nodes; the next is 3.5e-4
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


def refined_modes(matrices: PlateMatrices, clamped: NDArray[np.intp], count: int) -> tuple[Array, Array]:
    """Return frequencies and shapes as `solve_modes`, with signs and pairs fixed: the same bits on every processor."""
    total = matrices.mass.shape[0]
    free = np.setdiff1d(np.arange(total), clamped)
    stiffness, mass = (_symmetric(m[free][:, free].toarray()) for m in (matrices.stiffness, matrices.mass))
    found = Eigenpairs(*eigh(stiffness, mass))
    last = np.sqrt(found.values[count - 1 : count + 1])
    kept = count + (len(last) == 2 and _is_pair(*last))  # a pair is turned as a whole
    shapes = np.zeros((total, kept))
    shapes[free] = found.vectors[:, :kept]
    frequency = np.sqrt(found.values[:kept])
    shapes = fix_signs(frequency, shapes, matrices.rotation)
    pairs = {k: row[free] for k, row in _rows_of_pairs(frequency, shapes, matrices.rotation).items()}
    values, shapes[free] = refine(stiffness, mass, found, shapes[free], pairs)
    return np.sqrt(values[:count]), on_grid(shapes[:, :count])


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))


def _is_pair(lower: float, upper: float) -> bool:
    return bool(upper - lower < PARTNER_GAP * lower)


def degenerate_pairs(frequency: Array) -> list[int]:
    """Return the first mode of each degenerate pair; frequencies ascend."""
    found: list[int] = []
    for k in range(len(frequency) - 1):
        if k - 1 not in found and _is_pair(*frequency[k : k + 2]):
            found.append(k)
    return found


def turn_pair(shapes: Array, first: int, row: Array) -> None:
    """Turn a degenerate pair in place, so that the product of the row, (n,), with its second member is zero."""
    pair = shapes[:, first : first + 2]
    lever = row @ pair
    cosine, sine = lever / np.linalg.norm(lever)
    shapes[:, first : first + 2] = pair @ np.array([[cosine, -sine], [sine, cosine]])


def _first_largest(values: Array) -> int:
    """Return the first of the largest values: symmetric nodes tie, but for rounding."""
    return int(np.argmax(values >= (1.0 - TIE) * np.max(values)))


def _rows_of_pairs(frequency: Array, shapes: Array, rotation: Array) -> dict[int, Array]:
    """Return the first mode of each degenerate pair, with the row (3n,) whose product with the second shall be zero.

    That of the coupling to rotation about x, if the pair has any; otherwise that of the deflection at the node where
    the pair's is largest.
    """
    rows = {}
    for k in degenerate_pairs(frequency):
        pair = shapes[:, k : k + 2]
        rows[k] = rotation[0]
        if np.linalg.norm(rotation[0] @ pair) < 1e-6 * np.linalg.norm(rotation, ord=2):
            rows[k] = np.zeros(len(shapes))
            rows[k][3 * _first_largest(np.linalg.norm(pair[::3], axis=1))] = 1.0
    return rows


def fix_signs(frequency: Array, shapes: Array, rotation: Array) -> Array:
    """Return the shapes with signs, and the mixing within degenerate pairs, made repeatable.

    In a degenerate pair the first mode is turned to carry all the coupling to rotation about x, if the pair has any;
    otherwise its first member is turned to have the pair's largest deflection. Then each mode's largest deflection
    is made positive.
    """
    result = shapes.copy()
    for k, row in _rows_of_pairs(frequency, shapes, rotation).items():
        turn_pair(result, k, row)
    for k, deflection in enumerate(result[::3].T):
        result[:, k] *= np.sign(deflection[_first_largest(np.abs(deflection))])
    return result


@lru_cache(maxsize=8)  # both variants of a design and both configurations have the same
def build_structure(mesh: Mesh, plate: Plate, support: Support = "vertices") -> Structure:
    """Assemble the plate on a mesh, clamp it, and keep the lowest modes with Rayleigh damping."""
    matrices = assemble(mesh, plate)
    clamped = clamped_dofs(mesh, support)
    if matrices.mass.shape[0] - len(clamped) <= DENSE_LIMIT:
        frequency, shapes = refined_modes(matrices, clamped, plate.plant_modes)
    else:
        frequency, shapes = solve_modes(matrices, clamped, plate.plant_modes)
        shapes = fix_signs(frequency, shapes, matrices.rotation)
    beta_m, beta_k = plate.rayleigh()
    return Structure(
        mesh=mesh,
        frequency=frequency,
        shape=shapes,
        translation=product(matrices.translation, shapes),
        rotation=product(matrices.rotation, shapes),
        damping=beta_m + beta_k * frequency**2,
        total_mass=matrices.total_mass,
        inertia=matrices.inertia,
    )
