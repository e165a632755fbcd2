"""Loops opened with the structure that a run simulates: all its modes, with the errors that it was given."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.cli.parser import main
from flexbench.studies.margins.designed_loop import Delays, DesignedLoop
from flexbench.studies.margins.real_plant import Corner, Plants, stability
from flexbench.studies.margins.stability_table import Grid
from flexbench.studies.margins.system_loop import read_loop
from flexsat.parameters import ALL_MODES
from flexsat.spacecraft.variation import ModelErrors
from lockstep import InputError, load_system


def loop_of(delivered, **given):
    system = load_system(delivered / "centralised" / "fine_pointing.ssd")
    return read_loop(system, {f"plant.{name}".replace("__", "."): value for name, value in given.items()})


def test_the_loop_is_opened_with_the_plant_of_the_run(delivered, built):
    loop = loop_of(delivered, **{"modes": 40, "dispersion.damping[40]": 0.5, "dispersion.inertia[3]": 0.1})
    structure = built["centralised"].corrected.structure
    assert loop.real.spacecraft.mode_count == structure.mode_count == ALL_MODES
    plant = loop.designed.plant
    assert plant.index.modes == 40
    assert len(loop.designed.controller.feedback[0]) < 40 + 40  # of 25 modes: the controller does not know
    errors = np.zeros(40)
    errors[39] = 0.5
    assert_allclose(loop.real.spacecraft.damping[:40], structure.damping[:40] * (1.0 + errors), rtol=1e-15)
    assert_allclose(np.diag(loop.real.spacecraft.inertia), np.diag(structure.inertia) * [1.0, 1.0, 1.1], rtol=1e-15)


def test_without_settings_the_loop_is_opened_with_all_modes(delivered):
    assert loop_of(delivered).designed.plant.index.modes == ALL_MODES
    assert loop_of(delivered, as_published=True).designed.plant.index.modes == 25


def test_the_command_finds_the_published_design_unstable_on_30_modes(delivered, built, tmp_path, capsys):
    """PHYSICS section 9: the loop is stable on the 25 modes of its design, and not on a few more."""
    code = main(["margins", str(delivered / "centralised" / "fine_pointing.ssd"), "--out", str(tmp_path / "out"),
                 "--set", "controller.design=published", "--set", "plant.modes=30", "--modes", "25", "30",
                 "--gains", "-40", "0"])  # fmt: skip
    printed = capsys.readouterr()
    assert code == 1
    found = json.loads((tmp_path / "out" / "margins.json").read_text())
    assert found.keys() & {"analysis", "measured", "real"} == set()  # an unstable loop has no margins
    of_grid = {(row["modes"], round(row["gain"], 2)): row["growth"] for row in found["stability"]["grid"]}
    plants = Plants(built["centralised"].published)
    expected = stability(plants, Corner(modes=30))
    assert of_grid[30, 1.0] == pytest.approx(expected.growth, rel=1e-9)
    assert found["stability"]["growth"] == pytest.approx(expected.growth, rel=1e-9)
    assert of_grid[30, 1.0] > 0.1 > 0.0 > of_grid[25, 1.0]
    assert of_grid[30, 0.01] < 0.0
    assert (tmp_path / "out" / "figures" / "stability.png").is_file()
    rows = [line for line in printed.out.splitlines() if line.startswith(("25 ", "30 "))]
    assert [row.count("stable") for row in rows] == [2, 1]
    assert printed.err.splitlines()[-1].startswith("flexsat: The designed loop is UNSTABLE on 30 modes, up to")


def test_a_kept_loop_is_that_of_its_corner_star_tracker_and_controller(built):
    plants = Plants(built["centralised"].corrected)
    corner, late = Corner(modes=25), DesignedLoop(design=plants.design, delays=Delays(samples=2))
    asked = [
        (corner, True, None), (corner, False, None), (corner, True, late), (Corner(modes=26), True, late),
        (Corner(modes=25, errors=ModelErrors(frequency=0.05)), True, late),
    ]  # fmt: skip
    alone = [stability(Plants(plants.design), *one).growth for one in asked]
    assert len(set(alone)) == len(asked)
    assert [stability(plants, *one).growth for one in asked for _ in range(2)] == [x for x in alone for _ in range(2)]
    assert [stability(plants, *one).growth for one in asked] == alone


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"modes": (199,)}, "--modes 199: must be from 1 to 198"),
        ({"gains": (200.0,)}, "--gains 200: must be from -100"),
    ],
)
def test_impossible_grids_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        Grid(**given).counts(ALL_MODES)
