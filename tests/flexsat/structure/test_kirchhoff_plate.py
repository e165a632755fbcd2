"""The plate element against polynomials, closed-form frequencies and exact integration."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.spatial import Delaunay
from scipy.special import iv, jv

from flexsat.parameters import Plate
from flexsat.structure.kirchhoff_plate import EDGES, LINEAR_QUADRATIC_MASS, QUADRATIC_MASS, PlateMatrices, assemble
from flexsat.structure.mesh import Mesh, triangle_areas
from flexsat.structure.modes import solve_modes

PLATE = Plate(flexural_rigidity=7.0, poisson_ratio=0.3, area_density=2.0)
# rounding: sums of some hundred terms, each good to 1e-16, amplified by the shape of the triangles
ROUNDING = 1e-11


def oriented(nodes: np.ndarray, triangles: np.ndarray) -> Mesh:
    turned = triangle_areas(nodes, triangles) < 0.0
    triangles = np.where(turned[:, None], triangles[:, ::-1], triangles).astype(np.intp)
    return Mesh(nodes=nodes, triangles=triangles, hole=np.array([], dtype=np.intp))


@pytest.fixture(scope="module")
def irregular() -> Mesh:
    """Triangulate a 2 m by 1 m rectangle, off the origin, with interior nodes at random."""
    rng = np.random.default_rng(3)
    side = np.linspace(0.0, 1.0, 5)
    edge = np.concatenate([[(x, 0.0), (x, 1.0), (0.0, x), (1.0, x)] for x in side])
    nodes = np.unique(np.concatenate([edge, rng.uniform(0.08, 0.92, (12, 2))]), axis=0) * [2.0, 1.0] + [0.5, -0.2]
    mesh = oriented(nodes, Delaunay(nodes).simplices)
    assert_allclose(mesh.areas.sum(), 2.0, rtol=1e-12)  # rounding: the patch is covered once
    return mesh


@pytest.fixture(scope="module")
def patch(irregular: Mesh) -> PlateMatrices:
    return assemble(irregular, PLATE)


def interpolate(nodes: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    """Return nodal values of w = c + x w_x + y w_y + xx x^2/2 + yy y^2/2 + xy x y."""
    c, wx, wy, xx, yy, xy = coefficients
    x, y = nodes.T
    w = c + wx * x + wy * y + 0.5 * xx * x**2 + 0.5 * yy * y**2 + xy * x * y
    return np.stack([w, wy + yy * y + xy * x, -(wx + xx * x + xy * y)], axis=1).ravel()


def gauss_rectangle(function: object) -> float:
    """Integrate over the irregular patch's rectangle by a product Gauss rule, exact to degree 11."""
    points, weights = np.polynomial.legendre.leggauss(6)
    x, y = 0.5 + 1.0 + points, -0.2 + 0.5 + 0.5 * points
    return float(0.5 * np.einsum("i,j,ij->", weights, weights, function(*np.meshgrid(x, y, indexing="ij"))))


@pytest.mark.parametrize("rigid", [(1, 0, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0)])
def test_rigid_motion_needs_no_force(irregular, patch, rigid):
    u = interpolate(irregular.nodes, rigid)
    assert_allclose(patch.stiffness @ u, 0.0, atol=ROUNDING * abs(patch.stiffness).max())


def test_only_rigid_motion_is_free_of_energy(patch):
    values = np.linalg.eigvalsh(patch.stiffness.toarray())
    assert_allclose(values[:3], 0.0, atol=1e-13 * values[-1])  # rounding: n ulp of the largest
    assert values[3] > 1e-9 * values[-1]  # far above it: no fourth mechanism


@pytest.mark.parametrize("curvature", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.7, -1.2, 0.4)])
def test_patch_of_constant_curvature(irregular, patch, curvature):
    xx, yy, xy = curvature
    u = interpolate(irregular.nodes, (0.3, -0.1, 0.2, xx, yy, xy))
    nu, rigidity = PLATE.poisson_ratio, PLATE.flexural_rigidity
    density = 0.5 * rigidity * (xx**2 + yy**2 + 2.0 * nu * xx * yy + 2.0 * (1.0 - nu) * xy**2)

    forces = patch.stiffness @ u

    assert_allclose(0.5 * u @ forces, 2.0 * density, rtol=ROUNDING)
    inside = np.all((irregular.nodes > [0.51, -0.19]) & (irregular.nodes < [2.49, 0.79]), axis=1)
    assert inside.sum() == 12
    assert_allclose(forces.reshape(-1, 3)[inside], 0.0, atol=ROUNDING * np.abs(forces).max())


def test_mass_and_coupling_of_a_quadratic_field_are_exact(irregular, patch):
    coefficients = (0.3, -0.1, 0.2, 0.7, -1.2, 0.4)
    c, wx, wy, xx, yy, xy = coefficients
    u = interpolate(irregular.nodes, coefficients)

    def w(x, y):
        return c + wx * x + wy * y + 0.5 * xx * x**2 + 0.5 * yy * y**2 + xy * x * y

    rho = PLATE.area_density
    assert_allclose(u @ (patch.mass @ u), rho * gauss_rectangle(lambda x, y: w(x, y) ** 2), rtol=ROUNDING)
    momentum = [0.0, 0.0, rho * gauss_rectangle(w)]
    spin = [rho * gauss_rectangle(lambda x, y: y * w(x, y)), -rho * gauss_rectangle(lambda x, y: x * w(x, y)), 0.0]
    assert_allclose(patch.translation @ u, momentum, rtol=ROUNDING, atol=1e-14)  # the zeros are exact
    assert_allclose(patch.rotation @ u, spin, rtol=ROUNDING, atol=1e-14)


def test_mass_and_inertia_of_a_rectangle(patch):
    rho = PLATE.area_density
    assert_allclose(patch.total_mass, 2.0 * rho, rtol=ROUNDING)
    xx = rho * gauss_rectangle(lambda x, _y: x**2)
    yy = rho * gauss_rectangle(lambda _x, y: y**2)
    xy = rho * gauss_rectangle(lambda x, y: x * y)
    assert_allclose(patch.inertia, [[yy, -xy, 0.0], [-xy, xx, 0.0], [0.0, 0.0, xx + yy]], rtol=ROUNDING)


def test_rigid_coupling_is_the_mass_matrix_on_rigid_fields(irregular, patch):
    """Moving the plate as a rigid body is a nodal motion too: both ways give the same momenta."""
    lift = interpolate(irregular.nodes, (1, 0, 0, 0, 0, 0))
    roll = interpolate(irregular.nodes, (0, 0, 1, 0, 0, 0))  # w = y: about x
    pitch = interpolate(irregular.nodes, (0, -1, 0, 0, 0, 0))  # w = -x: about y
    scale = ROUNDING * patch.mass.max()
    assert_allclose(patch.translation[2], patch.mass @ lift, atol=scale)
    assert_allclose(patch.rotation[0], patch.mass @ roll, atol=scale)
    assert_allclose(patch.rotation[1], patch.mass @ pitch, atol=scale)


def product_integral(first: dict[tuple[int, int, int], int], second: dict[tuple[int, int, int], int]) -> Fraction:
    """Integrate a product of polynomials in barycentric coordinates over a triangle, as a share of its area."""
    total = Fraction(0)
    for (a1, b1, c1), f in first.items():
        for (a2, b2, c2), s in second.items():
            a, b, c = a1 + a2, b1 + b2, c1 + c2
            total += Fraction(2 * f * s * factorial(a) * factorial(b) * factorial(c), factorial(a + b + c + 2))
    return total


def test_integrals_of_shape_functions_are_the_rational_ones():
    unit = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    linear = [{u: 1} for u in unit]
    quadratic = [{tuple(2 * i for i in u): 2, u: -1} for u in unit]  # L (2 L - 1)
    quadratic += [{tuple(i + j for i, j in zip(unit[a], unit[b], strict=True)): 4} for a, b in EDGES]
    exact = [[float(product_integral(p, q)) for q in quadratic] for p in quadratic]
    assert_allclose(QUADRATIC_MASS, exact, rtol=1e-15, atol=1e-17)  # one rounding each
    exact = [[float(product_integral(p, q)) for q in quadratic] for p in linear]
    assert_allclose(LINEAR_QUADRATIC_MASS, exact, rtol=1e-15, atol=1e-17)


def square(count: int) -> Mesh:
    """Triangulate the unit square, `count` cells a side, diagonals all one way."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, count + 1), np.linspace(0.0, 1.0, count + 1), indexing="ij")
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    right, up = corner + count + 1, corner + 1
    triangles = np.concatenate([np.stack([corner, right, right + 1], 1), np.stack([corner, right + 1, up], 1)])
    return oriented(np.stack([x.ravel(), y.ravel()], axis=1), triangles)


def simply_supported(mesh: Mesh) -> np.ndarray:
    """Return the dofs held on the unit square's edge: w, and the slope along the edge."""
    x, y = mesh.nodes.T
    on_x, on_y = (x < 1e-9) | (x > 1 - 1e-9), (y < 1e-9) | (y > 1 - 1e-9)
    held = [3 * np.flatnonzero(on_x | on_y), 3 * np.flatnonzero(on_x) + 1, 3 * np.flatnonzero(on_y) + 2]
    return np.unique(np.concatenate(held))


def test_simply_supported_square_converges_to_navier():
    exact = np.array([2.0, 5.0, 5.0, 8.0]) * np.pi**2 * np.sqrt(PLATE.flexural_rigidity / PLATE.area_density)
    errors = []
    for count in (5, 10, 20):
        mesh = square(count)
        frequency, _ = solve_modes(assemble(mesh, PLATE), simply_supported(mesh), 4)
        errors.append(np.abs(frequency / exact - 1.0))
    order = np.log2(errors[1] / errors[2])
    # second order (Batoz 1980, figure 9); from 10 to 20 cells 1.92 is seen for one half wave each way, 1.82 for two
    assert_allclose(order, 2.0, atol=0.2)
    assert np.all(errors[2] < (2.0 * np.pi / 20) ** 2 / 16.0)  # 0.62 %; seen 0.44 % for two half waves of 10 cells


def disc(rings: int) -> Mesh:
    """Triangulate the unit disc by rings of 6 k nodes."""
    nodes = [np.zeros((1, 2))]
    for k in range(1, rings + 1):
        angle = 2.0 * np.pi * np.arange(6 * k) / (6 * k)
        nodes.append(k / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    points = np.concatenate(nodes)
    return oriented(points, Delaunay(points).simplices)


def test_clamped_disc_extrapolates_to_bessel():
    roots = [
        brentq(lambda s, n=n: jv(n, s) * iv(n + 1, s) + iv(n, s) * jv(n + 1, s), low, high)
        for n, low, high in ((0, 3.0, 3.5), (1, 4.5, 4.8), (2, 5.8, 6.0))
    ]
    exact = np.array(roots) ** 2 * np.sqrt(PLATE.flexural_rigidity / PLATE.area_density)
    assert_allclose(roots[0] ** 2, 10.2158, rtol=1e-5)  # Leissa (1969), table 2.1, printed to 6 digits
    found = []
    for rings in (8, 16):
        mesh = disc(rings)
        rim = np.flatnonzero(np.linalg.norm(mesh.nodes, axis=1) > 1.0 - 1e-9)
        held = (3 * rim[:, None] + np.arange(3)).ravel()
        frequency, _ = solve_modes(assemble(mesh, PLATE), held, 4)
        found.append(frequency[[0, 1, 3]])
    coarse, fine = found
    # plate and polygon both err by order 2, by .89 % at 8 rings: one extrapolation leaves the next order, .025 % seen
    assert_allclose((4.0 * fine - coarse) / 3.0, exact, rtol=5e-4)
    assert_allclose(fine, exact, rtol=0.004)  # 0.24 % seen at 16 rings, where (pi/16)^2/16 is 0.24 %
