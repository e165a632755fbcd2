"""Triangle meshes of the segmented aperture: hexagonal tiles of one side, in rings round a hexagonal hole."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from ..arrays import Array, Index
from ..parameters import Aperture

# Interior nodes of the mesh of record, radius [m] at angle [deg], each repeated every 60 deg (PHYSICS section 1)
RECORD_INTERIOR = (
    (3.4641, 0.0),
    (4.66, 30.0),
    (6.27, 0.0),
    (7.66, 30.0),
    (9.29, -9.4),
    (9.29, 9.4),
    (10.65, 22.7),
    (10.65, 37.3),
    (11.763, 0.0),
    (12.24, 30.0),
    (12.24, -13.3),
    (12.24, 13.3),
    (14.176, 0.0),
)
SLIVER_AREA = 1e-4  # m2; Delaunay leaves such triangles along straight edges (PHYSICS section 1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshNodes:
    """Nodes of a plane mesh in body axes x, y, without its triangles. Equal to themselves only."""

    nodes: Array  # (n, 2) [m]
    hole: Index  # nodes on the edge of the hole

    def node_at(self, radius: float, angle_deg: float) -> int:
        """Return the node at a polar position; raise ValueError if there is none within 1 mm."""
        return node_at(self.nodes, radius, angle_deg)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """Nodes and triangles of a plane mesh in body axes x, y. Equal to itself only."""

    nodes: Array  # (n, 2) [m]
    triangles: Index  # (t, 3), counter-clockwise
    hole: Index  # nodes on the edge of the hole

    def __post_init__(self) -> None:
        if not np.all(self.areas > 0.0):
            raise ValueError(f"Mesh.triangles: triangle {int(np.argmin(self.areas))} is not counter-clockwise")

    @property
    def areas(self) -> Array:
        """Areas, (t,) [m2]."""
        return triangle_areas(self.nodes, self.triangles)

    def node_at(self, radius: float, angle_deg: float) -> int:
        """Return the node at a polar position; raise ValueError if the mesh has none within 1 mm."""
        return node_at(self.nodes, radius, angle_deg)


def node_at(nodes: Array, radius: float, angle_deg: float) -> int:
    """Return which of the nodes, (n, 2) [m], is at a polar position; raise ValueError if none is within 1 mm."""
    distance = np.linalg.norm(nodes - polar(radius, angle_deg), axis=1)
    nearest = int(np.argmin(distance))
    if distance[nearest] > 1e-3:
        raise ValueError(f"site {radius} m @ {angle_deg} deg: no mesh node; nearest is {distance[nearest]:.3f} m off")
    return nearest


def polar(radius: float, angle_deg: float) -> Array:
    """Return the point (x, y) [m] at a radius [m] and an angle [deg] from body x."""
    # in extended precision: the last digit of a double's sine and cosine depends on the processor
    angle = np.longdouble(angle_deg) * (np.arctan2(np.longdouble(0.0), np.longdouble(-1.0)) / 180.0)
    return np.array([radius * np.cos(angle), radius * np.sin(angle)], dtype=np.float64)


def triangle_areas(nodes: Array, triangles: Index) -> Array:
    """Return signed areas, (t,) [m2], positive when counter-clockwise."""
    a, b, c = (nodes[triangles[:, i]] for i in range(3))
    return np.asarray(0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def tile_centres(aperture: Aperture) -> Array:
    """Return the centres of the tiles, (k, 2) [m], 60 in four rings; the tile over the hole is left out."""
    pitch = np.sqrt(3.0) * aperture.tile_side
    first, second = polar(pitch, 0.0), polar(pitch, 60.0)
    rings = range(-aperture.rings, aperture.rings + 1)
    return np.array(
        [i * first + j * second for i in rings for j in rings if 0 < max(abs(i), abs(j), abs(i + j)) <= aperture.rings]
    )


def tile_vertices(centre: Array, side: float) -> Array:
    """Return the six corners of a tile, (6, 2) [m], counter-clockwise from 30 deg."""
    return np.asarray(centre + np.array([polar(side, 30.0 + 60.0 * k) for k in range(6)]))


def _unique(points: Array) -> tuple[Array, Index]:
    """Merge points closer than a micrometre; return the points and where each given one went."""
    _, keep, where = np.unique(np.round(points, 6), axis=0, return_index=True, return_inverse=True)
    return points[keep], where.ravel()


@lru_cache
def record_nodes(aperture: Aperture) -> MeshNodes:
    """Place the 138 nodes of the mesh of record, six-fold symmetric.

    Raises
    ------
    ValueError
        If the aperture is not the one the interior nodes were placed for (tiles of 2 m side, four rings).
    """
    if (aperture.tile_side, aperture.rings) != (2.0, 4):
        raise ValueError(
            f"record_mesh: made for tiles of 2.0 m in 4 rings, got {aperture.tile_side} m in {aperture.rings};"
            " use refinable_mesh"
        )
    centres = tile_centres(aperture)
    corners = np.concatenate([tile_vertices(centre, aperture.tile_side) for centre in centres])
    points, where = _unique(corners)
    shared = np.bincount(where)
    radius = np.linalg.norm(points, axis=1)
    outline = points[(shared < 3) & (radius > 2.0 * aperture.tile_side)]
    hole = np.array([polar(aperture.tile_side, 30.0 + 60.0 * k) for k in range(6)])
    interior = np.array([polar(r, angle + 60.0 * k) for r, angle in RECORD_INTERIOR for k in range(6)])
    return MeshNodes(nodes=np.concatenate([hole, outline, interior]), hole=np.arange(6))


@lru_cache
def record_mesh(aperture: Aperture) -> Mesh:
    """Build the mesh of record: 138 nodes and 216 triangles, six-fold symmetric.

    Raises
    ------
    ValueError
        As `record_nodes` does.
    """
    placed = record_nodes(aperture)
    nodes, centres = placed.nodes, tile_centres(aperture)
    triangles = np.asarray(scipy.spatial.Delaunay(nodes).simplices, dtype=np.intp)
    centroids = nodes[triangles].mean(axis=1)
    inside = _in_some_tile(centroids, centres, aperture.tile_side)
    triangles = _counter_clockwise(nodes, triangles[inside])
    triangles = triangles[triangle_areas(nodes, triangles) > SLIVER_AREA]
    return Mesh(nodes=nodes, triangles=triangles, hole=placed.hole)


@lru_cache
def mesh_of(aperture: Aperture) -> Mesh:
    """Return the mesh that an aperture asks for."""
    return record_mesh(aperture) if aperture.mesh == "record" else refinable_mesh(aperture, aperture.refinements)


@lru_cache
def nodes_of(aperture: Aperture) -> MeshNodes:
    """Return the nodes of the mesh that an aperture asks for: those of the mesh of record without a triangulation."""
    if aperture.mesh == "record":
        return record_nodes(aperture)  # the library that makes triangles takes longer to load than a short run takes
    mesh = mesh_of(aperture)
    return MeshNodes(nodes=mesh.nodes, hole=mesh.hole)


def refinable_mesh(aperture: Aperture, refinements: int = 0) -> Mesh:
    """Build each tile as six triangles round its centre, then split every triangle in four, `refinements` times."""
    if refinements < 0:
        raise ValueError(f"refinable_mesh: refinements must be >= 0, got {refinements}")
    fans = []
    for centre in tile_centres(aperture):
        corners = tile_vertices(centre, aperture.tile_side)
        fans += [np.stack([centre, corners[k], corners[(k + 1) % 6]]) for k in range(6)]
    soup = np.array(fans)  # (t, 3, 2)
    for _ in range(refinements):
        a, b, c = soup[:, 0], soup[:, 1], soup[:, 2]
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = ([a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca])
        soup = np.concatenate([np.stack(part, axis=1) for part in parts])
    nodes, where = _unique(soup.reshape(-1, 2))
    hole = np.flatnonzero(_in_some_tile(nodes, np.zeros((1, 2)), aperture.tile_side))  # the edge of the missing tile
    return Mesh(nodes=nodes, triangles=_counter_clockwise(nodes, where.reshape(-1, 3)), hole=hole)


def _counter_clockwise(nodes: Array, triangles: Index) -> Index:
    turned = triangle_areas(nodes, triangles) < 0.0
    result = triangles.copy()
    result[turned] = result[turned][:, ::-1]
    return result


def _in_some_tile(points: Array, centres: Array, side: float) -> NDArray[np.bool_]:
    """Return which points lie in a tile: within the apothem along the three normals of its edges."""
    apothem = 0.5 * np.sqrt(3.0) * side
    normals = np.array([polar(1.0, 60.0 * k) for k in range(3)])
    reach = np.abs((points[:, None, :] - centres[None, :, :]) @ normals.T).max(axis=2)
    return np.asarray((reach <= apothem + 1e-9).any(axis=1))
