"""Kirchhoff plate triangles: discrete Kirchhoff stiffness, consistent mass, coupling to rigid motion.

Three degrees of freedom a node: w, dw/dy, -dw/dx, that is deflection along body z and the two components of the
nodal rotation vector. Every function works on all triangles of a mesh at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import Array
from ..parameters import Plate
from .mesh import Mesh

# Edges of a triangle as (from, to) corners; mid-side node 3 + k lies on edge k
EDGES = ((0, 1), (1, 2), (2, 0))

# Integrals of products of the quadratic shape functions over a triangle, as a share of its area (corners, mid-sides)
QUADRATIC_MASS = (
    np.array(
        [
            [6, -1, -1, 0, -4, 0],
            [-1, 6, -1, 0, 0, -4],
            [-1, -1, 6, -4, 0, 0],
            [0, 0, -4, 32, 16, 16],
            [-4, 0, 0, 16, 32, 16],
            [0, -4, 0, 16, 16, 32],
        ]
    )
    / 180.0
)
# Integrals of linear (row) times quadratic (column) shape functions, as a share of the area
LINEAR_QUADRATIC_MASS = np.array([[2, -1, -1, 8, 4, 8], [-1, 2, -1, 8, 8, 4], [-1, -1, 2, 4, 8, 8]]) / 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateMatrices:
    """Assembled matrices on all nodal degrees of freedom (3 a node), before any support."""

    mass: scipy.sparse.csc_array  # (3n, 3n) [kg, kg.m, kg.m2]
    stiffness: scipy.sparse.csc_array  # (3n, 3n) [N/m, N, N.m]
    translation: Array  # (3, 3n): momentum of the plate for unit nodal velocities [kg, kg.m]
    rotation: Array  # (3, 3n): angular momentum about the origin [kg.m, kg.m2]
    total_mass: float  # kg
    inertia: Array  # (3, 3) about the origin [kg.m2]


def _edges(mesh: Mesh) -> tuple[Array, Array]:
    """Return edge vectors (t, 3, 2) [m] and lengths (t, 3) [m]."""
    corners = mesh.nodes[mesh.triangles]
    vectors = np.stack([corners[:, b] - corners[:, a] for a, b in EDGES], axis=1)
    return vectors, np.linalg.norm(vectors, axis=2)


def _gradient_at_corners(count: int) -> Array:
    """Map nodal degrees of freedom to the gradient of w at the corners, (t, 3, 2, 9)."""
    gradient = np.zeros((count, 3, 2, 9))
    for corner in range(3):
        gradient[:, corner, 0, 3 * corner + 2] = -1.0  # dw/dx
        gradient[:, corner, 1, 3 * corner + 1] = 1.0  # dw/dy
    return gradient


def _gradient_at_six_nodes(mesh: Mesh) -> Array:
    """Map nodal degrees of freedom to the gradient of w at corners and mid-sides, (t, 6, 2, 9).

    At a mid-side the slope along the edge is that of the cubic through the end values and slopes, and the slope
    across it is the mean of those at the ends: the discrete Kirchhoff constraints (Batoz et al. 1980, section 3).
    """
    corners = _gradient_at_corners(len(mesh.triangles))
    vectors, lengths = _edges(mesh)
    middles = np.zeros_like(corners)
    for k, (a, b) in enumerate(EDGES):
        along = vectors[:, k] / lengths[:, k, None]
        mean = 0.5 * (corners[:, a] + corners[:, b])
        mean_along = np.einsum("ti,tij->tj", along, mean)
        slope = -0.5 * mean_along
        slope[:, 3 * a] -= 1.5 / lengths[:, k]
        slope[:, 3 * b] += 1.5 / lengths[:, k]
        middles[:, k] = mean + along[:, :, None] * (slope - mean_along)[:, None, :]
    return np.concatenate([corners, middles], axis=1)


def _quadratic_derivatives(barycentric: Array) -> Array:
    """Return derivatives of the six quadratic shape functions along the three barycentric coordinates, (6, 3)."""
    l1, l2, l3 = barycentric
    return np.array(
        [
            [4 * l1 - 1, 0.0, 0.0],
            [0.0, 4 * l2 - 1, 0.0],
            [0.0, 0.0, 4 * l3 - 1],
            [4 * l2, 4 * l1, 0.0],
            [0.0, 4 * l3, 4 * l2],
            [4 * l3, 0.0, 4 * l1],
        ]
    )


def _barycentric_gradients(mesh: Mesh) -> Array:
    """Return the gradients of the barycentric coordinates, (t, 3, 2) [1/m]."""
    vectors, _ = _edges(mesh)
    opposite = vectors[:, [1, 2, 0]]  # edge opposite to each corner
    inward = np.stack([-opposite[:, :, 1], opposite[:, :, 0]], axis=2)
    return np.asarray(inward / (2.0 * mesh.areas[:, None, None]))


def element_stiffness(mesh: Mesh, plate: Plate) -> Array:
    """Return discrete Kirchhoff stiffness matrices, (t, 9, 9). Source: Batoz, Bathe and Ho (1980), IJNME 15."""
    nu = plate.poisson_ratio
    rigidity = plate.flexural_rigidity * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    six = _gradient_at_six_nodes(mesh)
    barycentric = _barycentric_gradients(mesh)
    stiffness = np.zeros((len(mesh.triangles), 9, 9))
    # the curvature is linear in a triangle, so the three-point rule is exact
    for point in ((0.5, 0.5, 0.0), (0.0, 0.5, 0.5), (0.5, 0.0, 0.5)):
        shape = np.einsum("nl,tld->tnd", _quadratic_derivatives(np.array(point)), barycentric)
        hessian = np.einsum("tnd,tnif->tdif", shape, six)  # d(grad_i w)/dx_d
        curvature = np.stack([hessian[:, 0, 0], hessian[:, 1, 1], hessian[:, 0, 1] + hessian[:, 1, 0]], axis=1)
        stiffness += np.einsum("tcf,cd,tdg->tfg", curvature, rigidity, curvature) * (mesh.areas / 3.0)[:, None, None]
    return stiffness


def deflection_at_six_nodes(mesh: Mesh) -> Array:
    """Map nodal degrees of freedom to w at corners and mid-sides, (t, 6, 9).

    The mid-side value is the mean of the end values plus l/8 times the difference of the end slopes along the edge:
    on the authors' mesh this gives their mass matrix (PHYSICS section 1).
    """
    count = len(mesh.triangles)
    corners = _gradient_at_corners(count)
    vectors, _ = _edges(mesh)
    deflection = np.zeros((count, 6, 9))
    for corner in range(3):
        deflection[:, corner, 3 * corner] = 1.0
    for k, (a, b) in enumerate(EDGES):
        # vectors are l times the unit tangent, so l/8 needs no length
        slope = np.einsum("ti,tif->tf", vectors[:, k], corners[:, a] - corners[:, b])
        deflection[:, 3 + k] = 0.5 * (deflection[:, a] + deflection[:, b]) + 0.125 * slope
    return deflection


def assemble(mesh: Mesh, plate: Plate) -> PlateMatrices:
    """Assemble mass, stiffness and the coupling to rigid motion.

    Returns
    -------
    PlateMatrices
        Exact integrals of the element fields; the rigid coupling takes w as quadratic and x, y as linear.
    """
    count = 3 * len(mesh.nodes)
    dofs = (3 * mesh.triangles[:, :, None] + np.arange(3)).reshape(-1, 9)
    rows, columns = np.repeat(dofs, 9, axis=1).ravel(), np.tile(dofs, (1, 9)).ravel()
    deflection = deflection_at_six_nodes(mesh)
    masses = plate.area_density * mesh.areas  # (t,)
    mass = np.einsum("t,tnf,nm,tmg->tfg", masses, deflection, QUADRATIC_MASS, deflection)
    stiffness = element_stiffness(mesh, plate)

    corners = mesh.nodes[mesh.triangles]  # (t, 3, 2)
    first = np.einsum("t,n,tnf->tf", masses, LINEAR_QUADRATIC_MASS.sum(axis=0), deflection)
    moment = np.einsum("t,tcd,cn,tnf->tdf", masses, corners, LINEAR_QUADRATIC_MASS, deflection)
    translation, rotation = np.zeros((3, count)), np.zeros((3, count))
    np.add.at(translation[2], dofs.ravel(), first.ravel())
    np.add.at(rotation[0], dofs.ravel(), moment[:, 1].ravel())  # (r x w z)_x = y w
    np.add.at(rotation[1], dofs.ravel(), -moment[:, 0].ravel())

    linear = (np.ones((3, 3)) + np.eye(3)) / 12.0
    second = np.einsum("t,tcd,ce,tef->df", masses, corners, linear, corners)
    xx, yy, xy = second[0, 0], second[1, 1], second[0, 1]
    return PlateMatrices(
        mass=scipy.sparse.csc_array(scipy.sparse.coo_array((mass.ravel(), (rows, columns)), shape=(count, count))),
        stiffness=scipy.sparse.csc_array(
            scipy.sparse.coo_array((stiffness.ravel(), (rows, columns)), shape=(count, count))
        ),
        translation=translation,
        rotation=rotation,
        total_mass=float(masses.sum()),
        inertia=np.array([[yy, -xy, 0.0], [-xy, xx, 0.0], [0.0, 0.0, xx + yy]]),
    )
