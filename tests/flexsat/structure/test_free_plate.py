"""A square plate, free and clamped along a side: a published benchmark; the free one held at its centre as modal data.

VPCS, "Guide de validation des progiciels de calcul de structures" (AFNOR, 1990), sheet SDLS01/89, after Barton, J.
Applied Mechanics 18 (1951); printed in the manual of Code_Aster, V2.03.001: omega a^2 sqrt(rho/D) for Poisson's ratio
.3, "semi-analytical": upper bounds by the Ritz method, up to 1 % high in the free plate, as
for another code too (LIRA 10, test case 2.1: .15, .98, .64, .65 %).
"""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh

from flexsat.parameters import Plate
from flexsat.structure.kirchhoff_plate import assemble
from flexsat.structure.mesh import Mesh
from flexsat.structure.modal_data import ModalData, structure_from

FREE = [13.49, 19.79, 24.43, 35.02, 35.02]
CLAMPED = [3.492, 8.525, 21.43, 27.33, 31.11, 54.44]  # along one side
SHIFT = 10.0  # rad2/s2
SIDE = 2.0  # m
PLATE = Plate(flexural_rigidity=50.0, poisson_ratio=0.3, area_density=4.0)


def square(cells):
    """Return a mesh of crossed squares."""
    line = np.linspace(-0.5, 0.5, cells + 1) * SIDE
    corners = np.array([(x, y) for x in line for y in line])
    middle = np.array([(x, y) for x in 0.5 * (line[1:] + line[:-1]) for y in 0.5 * (line[1:] + line[:-1])])
    triangles = []
    for i in range(cells):
        for j in range(cells):
            a, b = i * (cells + 1) + j, (i + 1) * (cells + 1) + j
            centre = len(corners) + i * cells + j
            triangles += [(a, b, centre), (b, b + 1, centre), (b + 1, a + 1, centre), (a + 1, a, centre)]
    nodes = np.concatenate([corners, middle])
    return Mesh(nodes=nodes, triangles=np.array(triangles, dtype=np.intp), hole=np.zeros(0, dtype=np.intp))


def modes(cells, clamped_side, count):
    """Return mesh, matrices, and frequencies [rad/s] and shapes of the lowest modes, those of rigid motion too."""
    mesh = square(cells)
    matrices = assemble(mesh, PLATE)
    nodes = np.flatnonzero(mesh.nodes[:, 0] > -0.5 * SIDE + 1e-9) if clamped_side else np.arange(len(mesh.nodes))
    kept = (3 * nodes[:, None] + np.arange(3)).ravel()
    stiffness, mass = (m.toarray()[np.ix_(kept, kept)] for m in (matrices.stiffness, matrices.mass))
    # shifted and inverted: a rotation of nodes may move no mass, and the free plate's stiffness is singular
    size = len(kept)
    values, vectors = eigh(mass, stiffness + SHIFT * mass, subset_by_index=[size - count, size - 1])
    shapes = np.zeros((3 * len(mesh.nodes), count))
    shapes[kept] = vectors[:, ::-1] / np.sqrt(values[::-1])
    return mesh, matrices, np.sqrt(np.abs(1.0 / values[::-1] - SHIFT)), shapes


@pytest.mark.parametrize(("clamped_side", "rigid", "published"), [(False, 3, FREE), (True, 0, CLAMPED)])
def test_square_plate_has_the_published_frequencies(clamped_side, rigid, published):
    scale = SIDE**2 * np.sqrt(PLATE.area_density / PLATE.flexural_rigidity)
    errors = []
    for cells in (4, 8, 12):
        found = modes(cells, clamped_side, rigid + len(published))[2] * scale
        assert np.all(found[:rigid] < 1e-3)
        errors.append(found[rigid:] / published - 1.0)
    changes = [np.abs(b - a).max() for a, b in itertools.pairwise(errors)]
    assert changes[1] < 0.4 * changes[0]  # the element converges with the square of its size
    assert np.all(errors[2] < 0.0)  # the benchmark's values are upper bounds
    assert np.all(errors[2] > -0.011)  # of that quality: 1.0 % seen free, .8 % clamped


def test_free_plate_held_at_its_centre_keeps_its_free_frequencies():
    mesh, matrices, frequency, shapes = modes(8, clamped_side=False, count=12)
    frequency, shapes = frequency[3:], shapes[:, 3:]  # without the rigid motions
    nodes, count = len(mesh.nodes), len(frequency)
    nodal = shapes.reshape(nodes, 3, count)
    moved, turned = np.zeros((nodes, 3, count)), np.zeros((nodes, 3, count))
    moved[:, 2], turned[:, :2] = nodal[:, 0], nodal[:, 1:]
    data = ModalData(
        kind="free",
        frequency=frequency / (2.0 * np.pi),
        damping_ratio=np.zeros(count),
        node_name=tuple(f"n{i}" for i in range(nodes)),
        node_position=np.column_stack([mesh.nodes, np.zeros(nodes)]),
        node_translation=moved,
        node_rotation=turned,
        mass=matrices.total_mass,
        centre_of_mass=np.zeros(3),
        inertia=matrices.inertia,
        interface=f"n{int(np.argmin(np.linalg.norm(mesh.nodes, axis=1)))}",
    )
    held = structure_from(data)
    assert held.frequency[0] < frequency[0]  # held at a point, it is softer than free modes are
    mass = np.eye(6 + count)
    mass[:6, :6] = held.rigid_mass
    mass[:6, 6:], mass[6:, :6] = held.participation, held.participation.T
    stiffness = np.diag(np.concatenate([np.zeros(6), held.frequency**2]))
    again = np.sqrt(np.abs(eigh(stiffness, mass, eigvals_only=True)[6:]))
    assert_allclose(again, frequency, rtol=1e-8)
