"""The supported plate: its lowest modes and how they take part in rigid motion."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from ..arrays import Array
from ..fixed_order import on_grid, product, symmetric
from ..parameters import ALL_MODES, Aperture, Plate, Support
from .kirchhoff_plate import EDGES, PlateMatrices, assemble
from .mesh import Mesh, MeshNodes, mesh_of, nodes_of
from .refinement import Eigenpairs, refine
from .structure import Structure

FREEDOMS = 3  # of a node
DENSE_LIMIT = 2000  # degrees of freedom up to which the full eigenvalue problem is quicker than the sparse one
TIE = 2e-5  # relative difference below which deflections are those of symmetric nodes; the next is 3.5e-4
PARTNER_GAP = 1e-6  # relative frequency difference below which two modes are one degenerate pair


def clamped_dofs(mesh: Mesh | MeshNodes, support: Support) -> NDArray[np.intp]:
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
        values, vectors = scipy.linalg.eigh(stiffness.toarray(), mass.toarray(), subset_by_index=[0, count - 1])
    else:
        # a fixed start vector: results repeat
        values, vectors = scipy.sparse.linalg.eigsh(stiffness, count, mass, sigma=0.0, v0=np.ones(len(free)))
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    shapes = np.zeros((total, count))
    shapes[free] = vectors
    return np.sqrt(values), shapes


def refined_modes(matrices: PlateMatrices, clamped: NDArray[np.intp], count: int) -> tuple[Array, Array]:
    """Return frequencies and shapes as `solve_modes`, with signs and pairs fixed: the same bits on every processor."""
    total = matrices.mass.shape[0]
    free = np.setdiff1d(np.arange(total), clamped)
    stiffness, mass = (symmetric(m[free][:, free].toarray()) for m in (matrices.stiffness, matrices.mass))
    found = Eigenpairs(*scipy.linalg.eigh(stiffness, mass))
    last = np.sqrt(found.values[count - 1 : count + 1])
    kept = count + (len(last) == 2 and _is_pair(*last))  # a pair is turned as a whole
    shapes = np.zeros((total, kept))
    shapes[free] = found.vectors[:, :kept]
    frequency = np.sqrt(found.values[:kept])
    shapes = fix_signs(frequency, shapes, matrices.rotation)
    pairs = {k: row[free] for k, row in _rows_of_pairs(frequency, shapes, matrices.rotation).items()}
    values, shapes[free] = refine(stiffness, mass, found, shapes[free], pairs)
    return np.sqrt(values[:count]), on_grid(shapes[:, :count])


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
def build_structure(mesh: Mesh, plate: Plate, count: int = ALL_MODES, support: Support = "vertices") -> Structure:
    """Assemble the plate on a mesh, clamp it, and keep the lowest `count` modes with Rayleigh damping."""
    matrices = assemble(mesh, plate)
    clamped = clamped_dofs(mesh, support)
    if matrices.mass.shape[0] - len(clamped) <= DENSE_LIMIT:
        frequency, shapes = refined_modes(matrices, clamped, count)
    else:
        frequency, shapes = solve_modes(matrices, clamped, count)
        shapes = fix_signs(frequency, shapes, matrices.rotation)
    return of_plate(mesh, plate, matrices, frequency, shapes)


def aperture_structure(aperture: Aperture, plate: Plate, count: int) -> Structure:
    """Return the lowest modes of an aperture, all it has if there are fewer than `count`."""
    return build_structure(mesh_of(aperture), plate, min(count, mode_limit(aperture)), aperture.support)


def mode_limit(aperture: Aperture) -> int:
    """Return how many modes an aperture has on its mesh."""
    placed = nodes_of(aperture)
    return FREEDOMS * len(placed.nodes) - len(clamped_dofs(placed, aperture.support))


def of_plate(mesh: Mesh, plate: Plate, matrices: PlateMatrices, frequency: Array, shapes: Array) -> Structure:
    """Return the modal data of a plate in the plane z = 0; its shapes, (3n, m), are mass-normalised.

    By its symmetry the centre of mass is the origin.
    """
    beta_m, beta_k = plate.rayleigh()
    nodes, modes = len(mesh.nodes), len(frequency)
    nodal = shapes.reshape(nodes, FREEDOMS, modes)
    none = np.zeros((nodes, 1, modes))
    pairs = np.sort(np.concatenate([mesh.triangles[:, [a, b]] for a, b in EDGES]), axis=1)
    return Structure(
        frequency=frequency,
        damping=beta_m + beta_k * frequency**2,
        translation=product(matrices.translation, shapes),
        rotation=product(matrices.rotation, shapes),
        total_mass=matrices.total_mass,
        first_moment=np.zeros(3),
        inertia=matrices.inertia,
        position=np.column_stack([mesh.nodes, np.zeros(nodes)]),
        deflection=np.concatenate([none, none, nodal[:, :1]], axis=1),
        slope=np.concatenate([nodal[:, 1:], none], axis=1),
        edges=np.unique(pairs, axis=0),
        mesh=mesh,
    )
