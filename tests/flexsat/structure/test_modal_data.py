"""Modal data of cantilever beams in closed form: clamped, free, on a hub, through a file, against their checks."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from scipy.optimize import brentq

from flexsat.structure.combine import Placed, combined, rotation_about, turned
from flexsat.structure.modal_checks import modal_checks
from flexsat.structure.modal_data import ModalData, structure_from
from flexsat.structure.modal_file import modal_bytes, read_modal

LENGTH, DENSITY, RIGIDITY = 10.0, 1.5, 400.0  # m, kg/m, N.m2: bending in the plane of x and y
HUB_INERTIA, HUB_RADIUS, HUB_MASS = 150.0, 0.5, 300.0  # kg.m2, m, kg
MODES = 40
ROOTS = [1.8751040687119611, 4.694091132974175]  # Blevins (1979), table 8-1, case 3


def roots(count):
    """Return the lowest roots of cos(x) cosh(x) = -1."""
    starts = [(k + 0.5) * np.pi for k in range(count)]
    found = [brentq(lambda x: np.cos(x) + 1.0 / np.cosh(x), s - 0.7, s + 0.7, xtol=1e-15) for s in starts]
    return np.array(found)


def beam(count=MODES, nodes=5):
    """Return a uniform beam clamped at the origin along x, which bends along y: shapes and integrals in closed form."""
    k = roots(count)
    sigma = (np.sinh(k) - np.sin(k)) / (np.cosh(k) + np.cos(k))
    x = np.linspace(0.0, 1.0, nodes)[:, None]
    # cosh - sigma sinh for large k, without cancellation: e^-kx terms, and e^kx (1 - sigma) / 2 with 1 - sigma exact
    gap = (np.exp(-k) + np.cos(k) + np.sin(k)) / (np.cosh(k) + np.cos(k))
    growing, falling = 0.5 * gap * np.exp(k * x), 0.5 * (1.0 + sigma) * np.exp(-k * x)
    shape = growing + falling - np.cos(k * x) + sigma * np.sin(k * x)
    slope = k / LENGTH * (growing - falling + np.sin(k * x) + sigma * np.cos(k * x))
    mass = DENSITY * LENGTH
    moved, turning = np.zeros((nodes, 3, count)), np.zeros((nodes, 3, count))
    moved[:, 1], turning[:, 2] = shape / np.sqrt(mass), slope / np.sqrt(mass)
    # integrals of the shape, and of x times it (Blevins, appendix): 2 sigma/k and 2/k^2
    translation, rotation = np.zeros((3, count)), np.zeros((3, count))
    translation[1], rotation[2] = np.sqrt(mass) * 2.0 * sigma / k, np.sqrt(mass) * LENGTH * 2.0 / k**2
    return ModalData(
        kind="clamped",
        frequency=k**2 * np.sqrt(RIGIDITY / DENSITY) / LENGTH**2 / (2.0 * np.pi),
        damping_ratio=np.full(count, 0.005),
        node_name=tuple(f"n{i}" for i in range(nodes)),
        node_position=np.column_stack([LENGTH * x[:, 0], np.zeros((nodes, 2))]),
        node_translation=moved,
        node_rotation=turning,
        mass=mass,
        centre_of_mass=np.array([0.5 * LENGTH, 0.0, 0.0]),
        inertia=np.diag([0.0, 1.0, 1.0]) * mass * LENGTH**2 / 3.0,
        translation=translation,
        rotation=rotation,
        edges=np.array([[i, i + 1] for i in range(nodes - 1)]),
        source="closed form",
    )


def hub_with_beams(count=MODES):
    """Return two beams on opposite sides of a hub along x, as one structure in body axes."""
    parts = [
        turned(
            Placed(
                name=name,
                structure=structure_from(beam(count)),
                at=np.array([sign * HUB_RADIUS, 0.0, 0.0]),
                body_from_own=rotation_about(np.array([0.0, 0.0, angle])),
            )
        )
        for name, sign, angle in (("east", 1.0, 0.0), ("west", -1.0, np.pi))
    ]
    return combined(parts, 2 * count)


def test_clamped_beam():
    found = structure_from(beam())
    assert_allclose(roots(2), ROOTS, rtol=1e-13)
    # all modes move the mass across, and the moment of inertia: partial sums of 4 sigma^2/k^2 and 12/k^4 (to 1/count)
    share = 1.0 - np.diag(found.residual_mass)
    k = roots(MODES)
    sigma = np.tanh(k / 2.0) ** np.where(np.arange(MODES) % 2, -1.0, 1.0)
    assert_allclose(share[1], np.sum(4.0 * np.abs(found.translation[1] ** 2 / (4.0 * found.total_mass))), rtol=1e-12)
    assert_allclose(share[1], 1.0, atol=0.012)
    assert_allclose(share[5], np.sum(12.0 / k**4), rtol=1e-12)
    assert_allclose(share[5], 1.0, atol=1e-6)
    assert sigma.shape == k.shape


def exact_hub(count):
    """Return the lowest antisymmetric frequencies of hub and beams [rad/s], from the beam equation with a turning hub.

    With b^4 = rho w^2 / EI, the clamped end moves by theta (r + x): the moment and shear there turn the hub.
    """

    def residual(w):
        b = (DENSITY * w**2 / RIGIDITY) ** 0.25
        x = b * LENGTH
        ch, sh, c, s = np.cosh(x), np.sinh(x), np.cos(x), np.sin(x)
        # y = A (cosh - cos) + B (sinh - sin) + r cos + sin/b, per theta; no moment and shear at the free end give A, B,
        # multiplied here by their determinant, which has zeros where the clamped beam vibrates
        known = HUB_RADIUS * c + s / b, c / b - HUB_RADIUS * s
        determinant = 2.0 + 2.0 * ch * c
        first = known[0] * (ch + c) - known[1] * (sh + s)
        second = known[1] * (ch + c) - known[0] * (sh - s)
        bending = b**2 * (2.0 * first - HUB_RADIUS * determinant)  # second derivative at the hub
        shear = b**3 * (2.0 * second - determinant / b)  # third
        # -w^2 J theta = 2 EI (bending - r shear), of two beams
        return (HUB_INERTIA * w**2 * determinant + 2.0 * RIGIDITY * (bending - HUB_RADIUS * shear)) / ch

    grid = np.linspace(0.3, 60.0, 6000)
    values = np.array([residual(w) for w in grid])
    crossings = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    return np.array([brentq(residual, grid[i], grid[i + 1], xtol=1e-13) for i in crossings[:count]])


def coupled(structure, hub):
    """Return the frequencies of the free spacecraft [rad/s], in order."""
    modes = structure.mode_count
    mass = np.eye(6 + modes)
    mass[:6, :6] = structure.rigid_mass + hub
    mass[:6, 6:] = structure.participation
    mass[6:, :6] = structure.participation.T
    stiffness = np.diag(np.concatenate([np.zeros(6), structure.frequency**2]))
    return np.sqrt(np.abs(eigh(stiffness, mass, eigvals_only=True)))[6:]


def test_hub_with_two_beams_has_the_frequencies_of_the_beam_equation():
    hub = np.diag([HUB_MASS] * 3 + [HUB_INERTIA] * 3)
    exact = exact_hub(3)
    errors = []
    for count in (10, 20, 40):
        found = coupled(hub_with_beams(count), hub)
        errors.append([np.abs(found / w - 1.0).min() for w in exact])
    assert len(exact) == 3
    # a truncated modal series: the error of a frequency falls with the fourth power of the number of modes at least
    assert np.all(np.array(errors[-1]) < 1e-6)
    assert np.all(np.array(errors[0]) > 10.0 * np.array(errors[-1]))


def test_a_free_structure_has_its_own_frequencies_again():
    """Free modes of hub and beams, given as data of the whole with the hub as interface, and held there."""
    held = hub_with_beams(12)
    hub = np.diag([HUB_MASS] * 3 + [HUB_INERTIA] * 3)
    size = 6 + held.mode_count
    mass = np.eye(size)
    mass[:6, :6], mass[:6, 6:], mass[6:, :6] = held.rigid_mass + hub, held.participation, held.participation.T
    stiffness = np.diag(np.concatenate([np.zeros(6), held.frequency**2]))
    values, vectors = eigh(stiffness, mass)
    rigid, shapes = vectors[:6, 6:], vectors[6:, 6:]
    lever = np.cross(rigid[3:].T[:, None], held.position[None]).transpose(1, 2, 0)
    moved = np.concatenate([rigid[None, :3], rigid[:3] + lever + held.deflection @ shapes])
    turning = np.concatenate([rigid[None, 3:], rigid[3:] + held.slope @ shapes])
    free = ModalData(
        kind="free",
        frequency=np.concatenate([np.zeros(6), np.sqrt(values[6:])]) / (2.0 * np.pi),
        damping_ratio=np.full(size, 0.01),
        node_name=("bus", *held.names),
        node_position=np.vstack([np.zeros(3), held.position]),
        node_translation=np.concatenate([np.zeros((len(moved), 3, 6)), moved], axis=2),
        node_rotation=np.concatenate([np.zeros((len(moved), 3, 6)), turning], axis=2),
        mass=held.total_mass + HUB_MASS,
        centre_of_mass=np.zeros(3),
        inertia=held.inertia + HUB_INERTIA * np.eye(3),
        interface="bus",
    )
    found = structure_from(free)

    assert_allclose(found.frequency, held.frequency, rtol=1e-9)  # those of the beams, clamped again
    assert_allclose(coupled(found, np.zeros((6, 6))), np.sqrt(values[6:]), rtol=1e-9)
    # pairs of equal beams mix; what they move together does not
    assert_allclose(found.participation @ found.participation.T, held.participation @ held.participation.T, atol=1e-7)
    with pytest.raises(ValueError, match="interface 'hub': no such node; name the node that the bus is"):
        structure_from(replace(free, interface="hub"))


def test_appendages_turn_with_their_angle():
    """Mass, inertia, participation are tensors: turned by 90 deg about x, bending along y becomes bending along z."""
    own = structure_from(beam(4))
    quarter = rotation_about(np.array([0.5 * np.pi, 0.0, 0.0]))
    placed = turned(Placed(name="a", structure=own, at=np.array([0.0, 2.0, 0.0]), body_from_own=quarter))
    assert_allclose(placed.translation[2], own.translation[1], rtol=1e-14)
    assert_allclose(placed.rotation[0], 2.0 * own.translation[1], rtol=1e-14)  # arm of 2 m along y, force along z
    assert_allclose(placed.rotation[1], -own.rotation[2], rtol=1e-14)
    assert_allclose(placed.first_moment, [own.first_moment[0], 2.0 * own.total_mass, 0.0], atol=1e-12)
    # Steiner: about the origin, xx is m 2^2, zz that of the beam and m 2^2
    assert_allclose(placed.inertia[0, 0], 4.0 * own.total_mass, rtol=1e-14)
    assert_allclose(placed.inertia[2, 2], own.inertia[2, 2] + 4.0 * own.total_mass, rtol=1e-14)
    assert_allclose(placed.inertia[0, 1], -2.0 * own.first_moment[0], rtol=1e-14)
    assert_allclose(placed.residual_mass[2, 2], own.residual_mass[1, 1], rtol=1e-12)
    for angle in (0.3, 1.2):  # the free spacecraft's frequencies do not depend on the axes
        turn = rotation_about(np.array([angle, 0.2, -angle]))
        again = turned(Placed(name="a", structure=own, at=np.array([1.0, 2.0, -1.0]), body_from_own=turn))
        hub = np.diag([50.0] * 3 + [1e9] * 3)
        assert_allclose(coupled(again, hub), coupled(own, hub), rtol=1e-6)  # the hub does not turn


def test_a_modal_file_gives_the_same_data_and_bytes():
    data = beam(5)
    content = modal_bytes(data)
    assert structure_from(read_modal(content)) == structure_from(data)
    assert modal_bytes(read_modal(content)) == content
    assert structure_from(data) != structure_from(replace(data, damping_ratio=1.1 * data.damping_ratio))


def lumped(count=3):
    """Return a chain of masses on the beam's axis with the modes of its own stiffness: data whose masses are known."""
    rng = np.random.default_rng(3)
    nodes, mass = 6, np.array([2.0, 1.0, 1.5, 1.0, 0.5, 3.0])
    root = rng.standard_normal((3 * nodes, 3 * nodes))
    values, vectors = eigh(root @ root.T, np.diag(np.repeat(mass, 3)))
    place = rng.standard_normal((nodes, 3))
    return ModalData(
        kind="clamped",
        frequency=np.sqrt(values[:count]),
        damping_ratio=np.full(count, 0.01),
        node_name=tuple("abcdef"),
        node_position=place,
        node_translation=vectors[:, :count].reshape(nodes, 3, count),
        node_rotation=np.zeros((nodes, 3, count)),
        node_mass=mass,
    )


def test_masses_of_the_nodes_give_participation_and_all_modes_move_all_mass():
    every = structure_from(lumped(18))
    assert every.total_mass == 9.0
    assert_allclose(every.residual_mass, 0.0, atol=1e-12)
    checks = modal_checks(lumped(18))
    assert all(check.right for check in checks)
    assert "mass x 100.00 %" in checks[0].text


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"node_translation": lumped().node_translation * 1.05}, "orthogonality of the shapes: largest error 0.1"),
        ({"mass": 9.5, "centre_of_mass": np.zeros(3), "inertia": 40.0 * np.eye(3)}, "mass against that of the nodes"),
    ],
)
def test_what_does_not_fit_together_is_named(change, text):
    wrong = [check.text for check in modal_checks(replace(lumped(), **change)) if not check.right]
    assert any(line.startswith(text) for line in wrong), wrong


def test_what_is_missing_is_named():
    lines = [check.text for check in modal_checks(replace(beam(3), node_rotation=None, damping_ratio=np.zeros(3)))]
    missing = [line.partition(":")[2].strip().partition(":")[0] for line in lines if line.startswith("missing")]
    assert missing == ["node_mass", "node_rotation", "damping"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"translation": 2.0 * beam(3).translation}, r"the modes move [\d.]+ times the mass and inertia given"),
        ({"mass": None}, "mass: missing; give them, or node_mass of all nodes"),
        ({"rotation": None}, "translation, rotation: missing; give the participation"),
        ({"frequency": np.zeros(3)}, "Structure.frequency must be > 0"),
    ],
)
def test_data_of_no_structure_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        structure_from(replace(beam(3), **change))


def spoilt(**arrays):
    """Return the content of a modal file with other arrays; None leaves one out."""
    import io

    with np.load(io.BytesIO(modal_bytes(beam(3)))) as file:
        content = {**{name: file[name] for name in file.files}, **arrays}
    memory = io.BytesIO()
    np.savez(memory, **{name: value for name, value in content.items() if value is not None})
    return memory.getvalue()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"text", "not a modal file, an .npz with arrays as in docs/modal_files.md"),
        (spoilt(format=np.array("other")), 'its array format must be "flexsat modal 1"'),
        (spoilt(frequencies=np.ones(3)), "frequencies: no such array; there are kind, frequency"),
        (spoilt(node_position=None), "node_position: missing"),
        (spoilt(kind=np.array("held")), "kind must be clamped or free, got 'held'"),
        (spoilt(damping_ratio=np.array(1.5)), "damping_ratio must be >= 0 and < 1"),
        (spoilt(mass=np.array("heavy")), "mass must be numbers"),
        (spoilt(inertia=np.array([1.0, np.nan, 2.0])), "inertia must be finite numbers"),
        (spoilt(translation=np.ones((3, 4))), r"translation must be \(3, 3\) for 3 modes and 5 nodes, got \(3, 4\)"),
        (spoilt(node_name=np.array(["a"] * 5)), "node_name: two nodes have the same name"),
        (spoilt(edges=np.array([[0, 9]])), "edges must be pairs of nodes from 0 to 4"),
    ],
)
def test_a_wrong_modal_file_is_refused(content, message):
    with pytest.raises(ValueError, match=message):
        read_modal(content)
