"""Results of NASTRAN become a modal file: axes of nodes, offsets, units and lumped masses as the model has them.

The .op2 is written by pyNastran from shapes that this file computes of mass matrices of its own.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh

from flexbench.cli.parser import main
from flexsat.structure.modal_checks import modal_checks
from flexsat.structure.modal_data import structure_from
from flexsat.structure.modal_file import read_modal
from flexsat.structure.nastran import nastran_data

HOSTS = Path(__file__).parents[4] / ".venv-hosts"
PYTHON = HOSTS / "bin" / "python"
SINGLE = 1e-5  # results are in single precision: 6e-8 a number, some tens of them in a sum
WTMASS = 0.5
FREQUENCY = np.array([0.4, 0.9, 2.5, 7.0])  # Hz
PLACES = {1: (0.0, 0.0, 0.0), 2: (1.2, 1.6, 0.0), 3: (1.2, 4.6, 0.5)}
OFFSET, OWN = np.array([0.0, 0.3, -0.2]), np.diag([0.5, 0.3, 0.7])  # of the mass at node 2, and in axes turned about x
TURNED = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # rows: axes of system 7
AT_2 = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])  # rows: radial, around, along z at node 2
BEAM = {"area": 2e-3, "inertia": 4e-6, "density": 1e3}
MODEL = """SOL 103
CEND
DISPLACEMENT(PLOT) = ALL
METHOD = 1
SPC = 1
BEGIN BULK
PARAM,WTMASS,0.5
EIGRL,1,,,4
CORD2C,5,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD2R,7,,0.,0.,0.,0.,-1.,0.
,1.,0.,0.
GRID,1,,0.,0.,0.
GRID,2,,1.2,1.6,0.,5
GRID,3,,1.2,4.6,.5
CONM2,11,2,7,3.,0.,-.2,-.3
,.5,,.3,,,.7
CONM2,12,3,,5.
CBEAM,21,31,1,2,0.,0.,1.
CBAR,22,32,2,3,1.,0.,0.
PBEAM,31,41,2.-3,2.-6,2.-6
PBAR,32,41,2.-3,2.-6,2.-6,4.-6
MAT1,41,7.+10,,.3,1000.
SPC1,1,123456,1
ENDDATA
"""

pytestmark = pytest.mark.skipif(
    not any(HOSTS.glob("lib/*/site-packages/pyNastran")), reason="pyNastran needs a Python: make .venv-hosts/installed"
)


@pytest.fixture(scope="module", autouse=True)
def _compiling():
    """Let the other Python keep what it compiles: its packages are installed without compiled files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONDONTWRITEBYTECODE", "")
        yield


def cross(vector):
    """Return the matrix of the product `vector x`."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def block(mass, offset=(0.0, 0.0, 0.0), own=None):
    """Return the 6 by 6 mass matrix about a node of a mass beside it."""
    arm = cross(offset)
    inertia = np.zeros((3, 3)) if own is None else own
    return np.block([[mass * np.eye(3), -mass * arm], [mass * arm, inertia - mass * arm @ arm]])


def masses():
    """Return the mass matrix of nodes 2 and 3, in basic axes."""
    one, two, three = (np.array(place) for place in PLACES.values())
    along = (two - one) / np.linalg.norm(two - one)
    beam = BEAM["density"] * BEAM["area"] * np.linalg.norm(two - one)
    bar = BEAM["density"] * BEAM["area"] * np.linalg.norm(three - two)
    polar = BEAM["density"] * BEAM["inertia"] * np.linalg.norm(two - one)
    at_2 = block(3.0, OFFSET, TURNED.T @ OWN @ TURNED)
    at_2 += block(0.5 * (beam + bar), own=0.5 * polar * np.outer(along, along))
    matrix = np.zeros((12, 12))
    matrix[:6, :6], matrix[6:, 6:] = at_2, block(5.0 + 0.5 * bar)
    return WTMASS * matrix


@pytest.fixture(scope="module")
def shapes():
    """Return four mass-normalised shapes of nodes 2 and 3, (12, 4), of a stiffness drawn by chance."""
    generator = np.random.default_rng(1)
    root = generator.normal(size=(12, 12))
    matrix = masses()
    matrix[9:, 9:] = 1e-3 * np.eye(3)  # node 3 has no inertia, and would have no shape
    found = eigh(root @ root.T, matrix)[1][:, :4]
    found[9:] = 0.0
    return found @ np.linalg.inv(np.linalg.cholesky(found.T @ masses() @ found)).T


@pytest.fixture(scope="module")
def model(shapes, tmp_path_factory):
    """Return the path of results, with the bulk data beside them."""
    folder = tmp_path_factory.mktemp("nastran")
    shape = np.zeros((4, 3, 6))
    shape[:, 1:] = shapes.T.reshape(4, 2, 6)
    for part in (slice(0, 3), slice(3, 6)):
        shape[:, 1, part] = shape[:, 1, part] @ AT_2.T
    np.savez(folder / "shapes.npz", node=list(PLACES), shape=shape, frequency=FREQUENCY)
    script = Path(__file__).with_name("nastran_results.py")
    subprocess.run([PYTHON, "-W", "ignore", script, folder / "shapes.npz", folder / "array.op2"], check=True,
                   capture_output=True)  # fmt: skip
    (folder / "array.bdf").write_text(MODEL, encoding="utf-8")
    return folder / "array.op2"


def test_participation_and_mass_are_those_of_the_models_mass_matrix(model, shapes, tmp_path, capsys):
    """In millimetres and tonnes, as many models are."""
    body = model.with_suffix(".toml")
    body.write_text("length_unit = 1e-3\nmass_unit = 1e3\ndamping_ratio = 0.004\n", encoding="utf-8")
    assert main(["modal", str(model), "--nastran-python", str(PYTHON), "--out", str(tmp_path / "a.npz")]) == 0
    shown = capsys.readouterr().out
    assert "orthogonality of the shapes: largest error" in shown

    found = structure_from(read_modal((tmp_path / "a.npz").read_bytes()))
    rigid = np.vstack([np.block([[np.eye(3), -cross(PLACES[n])], [np.zeros((3, 3)), np.eye(3)]]) for n in (2, 3)])
    kilogram, metre = 1e3, 1e-3
    whole = rigid.T @ masses() @ rigid + held_root()
    assert_allclose(found.frequency, 2.0 * np.pi * FREQUENCY, rtol=SINGLE)
    assert_allclose(found.damping, 0.008 * found.frequency, rtol=SINGLE)
    assert found.total_mass == pytest.approx(kilogram * whole[0, 0], rel=SINGLE)
    assert_allclose(found.inertia, kilogram * metre**2 * whole[3:, 3:], rtol=SINGLE, atol=1e-12)
    moved = rigid.T @ masses() @ shapes
    largest = np.abs(moved).max()
    assert_allclose(found.translation, kilogram**0.5 * moved[:3], atol=kilogram**0.5 * SINGLE * largest)
    assert_allclose(found.rotation, kilogram**0.5 * metre * moved[3:], atol=kilogram**0.5 * metre * SINGLE * largest)
    assert found.names == ("1", "2", "3", "2.11")
    assert_allclose(found.position[3], metre * (np.array(PLACES[2]) + OFFSET))
    assert found.edges.tolist() == [[0, 1], [1, 2]]


def held_root():
    """Return the rigid mass of what is lumped at the clamped node."""
    along = np.array(PLACES[2]) / 2.0
    mass, polar = BEAM["density"] * BEAM["area"] * 2.0, BEAM["density"] * BEAM["inertia"] * 2.0
    return WTMASS * block(0.5 * mass, own=0.5 * polar * np.outer(along, along))


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("array.bdf", "GRID,3,,1.2,4.6,.5", "GRID,3,,1.2,4.6,.5\nGRID,9,,1.,1.,1.",
         "array.op2: no shapes of 1 nodes of array.bdf, the first 9; take both of one run"),
        ("array.bdf", "CONM2,12,3,,5.", "CMASS2,12,5.,3,1",
         "element 12, CMASS2: its mass is not read; write it as CONM"),
        ("array.bdf", "BEGIN BULK\n", "BEGIN BULK\nINCLUDE 'geom.inc'\n", "OSError: No such bdf_filename: "),
        ("array.toml", "", "length = 1\n", "array.toml: length: no such key; there are kind, mass"),
        ("array.toml", "", "length_unit = -1\n", "array.toml: length_unit and mass_unit must be > 0, got -1 and 1"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_named_in_one_line(model, tmp_path, capsys, name, old, new, message):
    (tmp_path / "array.op2").write_bytes(model.read_bytes())
    (tmp_path / "array.bdf").write_text(MODEL, encoding="utf-8")
    path = tmp_path / name
    path.write_text((path.read_text(encoding="utf-8") if path.exists() else "").replace(old, new, 1), encoding="utf-8")
    assert main(["modal", str(tmp_path / "array.op2"), "--nastran-python", str(PYTHON)]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


def test_what_is_missing_is_refused_with_the_remedy(model, tmp_path, capsys):
    other = tmp_path / "other.op2"
    other.write_bytes(model.read_bytes())
    for words, message in (
        ([str(model)], "are read by pyNastran, in a Python of its own: python3 -m venv nastran"),
        ([str(model), "--nastran-python", str(tmp_path / "none")], "none: no such program; python3 -m venv"),
        ([str(model), "--nastran-python", sys.executable], "has no pyNastran; "),
        ([str(other), "--nastran-python", str(PYTHON)], "other.bdf: missing; the model stands beside its results"),
        (["array.npz", "--nastran-python", str(PYTHON)], "--nastran-python: has no effect on array.npz"),
    ):
        assert main(["modal", *words]) == 2
        assert message in capsys.readouterr().err


def test_shapes_have_the_generalised_mass_of_the_table_of_eigenvalues(tmp_path):
    """Of a node of 3 t, at 2000 mm, which the first mode moves along z by 1 mm and the second turns."""
    shape = np.zeros((1, 3, 2))
    shape[0, 2, 0] = 1.0
    turned = np.zeros((1, 3, 2))
    turned[0, 0, 1] = 0.1
    whole = np.diag([3.0] * 3 + [8.0, 12e6, 12e6])
    whole[2, 4] = whole[4, 2] = -6e3
    whole[1, 5] = whole[5, 1] = 6e3
    arrays = {
        "frequency": np.array([1.0, 2.0]),
        "modal_mass": np.array([3.0, 0.08]),
        "edges": np.zeros((0, 2)),
        "node_name": np.array(["tip"]),
        "node_position": np.array([[2e3, 0.0, 0.0]]),
        "node_translation": shape,
        "node_rotation": turned,
        "node_mass": np.array([3.0]),
        "node_inertia": np.diag([8.0, 0.0, 0.0])[None],
        "rigid_mass": whole,
    }
    body = tmp_path / "a.toml"
    body.write_text("length_unit = 1e-3\nmass_unit = 1e3\n", encoding="utf-8")
    data = nastran_data(arrays, body)
    assert all(check.right for check in modal_checks(data))
    found = structure_from(data)
    assert_allclose(found.translation, [[0.0, 0.0], [0.0, 0.0], [3000.0**0.5, 0.0]], rtol=1e-14)
    assert_allclose(found.rotation, [[0.0, 0.008**0.5], [-2.0 * 3000.0**0.5, 0.0], [0.0, 0.0]], rtol=1e-14)
    with pytest.raises(ValueError, match=r"the first 1 of 2 modes move rigidly.* write kind = .free. .* in a\.toml"):
        nastran_data({**arrays, "frequency": np.array([1e-4, 2.0])}, body)
