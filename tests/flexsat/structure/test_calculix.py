"""A spacecraft with two solar arrays, solved by CalculiX as a whole, and from its modes of one array."""

import itertools
import shutil
import subprocess

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh

from flexsat.structure.calculix import read_calculix
from flexsat.structure.combine import Placed, combined, rotation_about, turned
from flexsat.structure.modal_data import structure_from
from flexsat.structure.modal_sources import read_modal_source

LENGTH, WIDTH, THICK, EDGE = 4.0, 1.0, 0.02, 0.5  # m, of an array from EDGE along x
ARRAY, HUB = 300.0, 15000.0  # kg/m3
ALUMINIUM, RIGID = 7e10, 7e14  # Pa
CELLS = 8  # bricks along an array, two across

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="the package calculix-ccx has the solver")


def deck(along, clamped, modes):
    """Return an input file: 20-node bricks over the positions along x; those between -EDGE and EDGE are the hub."""
    fine = [along[0], *itertools.chain.from_iterable(((a + b) / 2.0, b) for a, b in itertools.pairwise(along))]
    across, up = np.linspace(-0.5, 0.5, 5) * WIDTH, np.linspace(-0.5, 0.5, 3) * THICK
    grid = itertools.product(range(len(fine)), range(5), range(3))
    numbers = {place: k for k, place in enumerate((p for p in grid if sum(i % 2 for i in p) < 2), start=1)}
    lines = ["*NODE,NSET=ALL"]
    lines += [f"{n},{fine[i]},{across[j]},{up[k]}" for (i, j, k), n in numbers.items()]
    round_ = [(0, 0), (2, 0), (2, 2), (0, 2)]
    sides = [(1, 0), (2, 1), (1, 2), (0, 1)]
    local = [(*p, k) for k in (0, 2) for p in round_] + [(*p, k) for k in (0, 2) for p in sides]
    local += [(*p, 1) for p in round_]
    cells = [(2 * a, 2 * b) for a in range(len(along) - 1) for b in range(2)]
    for name, stiffness, density in (("HUB", RIGID, HUB), ("ARRAY", ALUMINIUM, ARRAY)):
        own = [(e, c) for e, c in enumerate(cells, start=1) if (abs(fine[c[0] + 1]) < EDGE) == (name == "HUB")]
        if not own:
            continue
        lines.append(f"*ELEMENT,TYPE=C3D20R,ELSET={name}")
        for e, (i, j) in own:
            nodes = [str(numbers[i + di, j + dj, k]) for di, dj, k in local]
            lines += [",".join([str(e), *nodes[:15]]) + ",", ",".join(nodes[15:])]
        lines += [f"*MATERIAL,NAME=M{name}", "*ELASTIC", f"{stiffness},0.3", "*DENSITY", f"{density}"]
        lines.append(f"*SOLID SECTION,ELSET={name},MATERIAL=M{name}")
    if clamped:
        lines += ["*NSET,NSET=ROOT", *(f"{n}," for (i, _, _), n in numbers.items() if i == 0), "*BOUNDARY", "ROOT,1,3"]
    return "\n".join([*lines, "*STEP", "*FREQUENCY", f"{modes}", "*NODE FILE", "U", "*END STEP", ""])


def solve(folder, name, text):
    """Run CalculiX on an input file in a folder."""
    (folder / f"{name}.inp").write_text(text, encoding="utf-8")
    subprocess.run(["ccx", name], cwd=folder, check=True, capture_output=True, env={"OMP_NUM_THREADS": "1"}, timeout=60)


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calculix")
    along = np.linspace(EDGE, EDGE + LENGTH, CELLS + 1).tolist()
    solve(folder, "array", deck(along, clamped=True, modes=8))
    solve(folder, "whole", deck([-x for x in reversed(along)] + along, clamped=False, modes=16))
    return folder


def brick(density, length):
    """Return mass and inertia about its own centre of a brick of the arrays' section."""
    mass = density * length * WIDTH * THICK
    squares = np.array([length, WIDTH, THICK]) ** 2
    return mass, mass / 12.0 * (squares.sum() - squares)


def test_both_ways_give_the_same_frequencies(solved):
    mass, inertia = brick(ARRAY, LENGTH)
    centre = EDGE + 0.5 * LENGTH
    xx, yy, zz = (inertia + mass * centre**2 * np.array([0.0, 1.0, 1.0])).tolist()
    body = f"mass = {mass}\ncentre_of_mass = [{centre}, 0, 0]\ninertia = [{xx}, {yy}, {zz}, 0, 0, 0]\n"
    (solved / "array.toml").write_text(body, encoding="utf-8")
    array = structure_from(read_modal_source(solved / "array.frd"))
    sides = [
        turned(Placed(name=n, structure=array, at=np.zeros(3), body_from_own=rotation_about(np.array([0.0, 0.0, a]))))
        for n, a in (("east", 0.0), ("west", np.pi))
    ]
    both = combined(sides, 16)
    hub, turning = brick(HUB, 2.0 * EDGE)
    matrix = np.eye(6 + both.mode_count)
    matrix[:6, :6] = both.rigid_mass + np.diag([hub] * 3 + turning.tolist())
    matrix[:6, 6:], matrix[6:, :6] = both.participation, both.participation.T
    stiffness = np.diag(np.concatenate([np.zeros(6), both.frequency**2]))
    found = np.sqrt(np.abs(eigh(stiffness, matrix, eigvals_only=True)[6:])) / (2.0 * np.pi)

    whole = read_calculix((solved / "whole.frd").read_text(), (solved / "whole.dat").read_text()).frequency[6:]
    nearest = found[np.abs(found[:, None] - whole).argmin(axis=0)]
    # modes of eight are kept, and the clamped nodes' share of the consistent mass is left out: 7e-4 seen in the eighth
    assert_allclose(nearest, whole, rtol=1e-3)
    assert len(whole) == 10
    alone = array.frequency[0] / (2.0 * np.pi)
    assert abs(whole[0] / alone - 1.0) > 0.03  # the hub takes part


def test_what_a_run_lacks_is_named(solved):
    frd, dat = (solved / "array.frd").read_text(), (solved / "array.dat").read_text()
    with pytest.raises(ValueError, match=r"no displacements; write `\*NODE FILE` and `U`"):
        read_calculix(frd.replace("DISP", "DOSP"), dat)
    with pytest.raises(ValueError, match=r"the \.dat has no participation factors"):
        read_calculix(frd, dat.partition("P A R T")[0])
    with pytest.raises(ValueError, match=r"16 modes, and the \.dat participation of 8; take both of one run"):
        read_calculix((solved / "whole.frd").read_text(), dat)
    (solved / "array.toml").unlink(missing_ok=True)
    with pytest.raises(ValueError, match=r"array\.toml: missing; write mass \[kg\]"):
        read_modal_source(solved / "array.frd")
