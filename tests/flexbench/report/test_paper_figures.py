"""Each figure of the paper, and each plot of its release, has a place that is there, or a reason why it has none."""

import re

from flexbench.figures.figure_lists import design_figures
from flexbench.figures.fine_pointing import DEFORMATION, ERROR
from flexbench.figures.slew import PANELS
from flexbench.html.document import Table
from flexbench.report.paper_figures import FINE, PAPER_FIGURES, SLEW, paper_figures

# all that the scripts of the release save, at its commit 3a67e6e, without ending
RELEASE = """
AngVel AngVelErr Attitude AttitudeErr CampDiag LQRIntNorm MeasErr MeshActSens MeshActSens2DPlate
ModesOLvsCLposter2 PSDSYSRW PSDSYSRWAll RMSDefDistvsCent RMSDefOLvsCL RWSpeeds RWTIntNorm RWTNorm RWTorques
RWTorquesSpeed TrueMeas VibModesSC WRWAll WRWSep scndbendmode"""
STUDY = ("slew-as-published-seed1", "fine-pointing-as-published-seed1", "slew-seed1", "fine-pointing-seed1")
HISTORIES = {"torque, sum over wheels", "plant.modal.displacement", "plant.rate"}


def test_every_plot_of_the_release_is_in_the_list():
    assert {name for one in PAPER_FIGURES for name in one.release} == set(RELEASE.split())


def test_every_figure_has_a_place_that_exists_or_a_reason(built):
    names = [*design_figures(built), *STUDY]
    panels = {SLEW: {title for title, *_ in PANELS}, FINE: {ERROR, DEFORMATION}}

    for one in PAPER_FIGURES:
        assert [bool(one.figure), bool(one.history), bool(one.reason)].count(True) == 1, one.subject
        if one.figure:
            assert any(re.fullmatch(one.figure, name) for name in names), one.subject
            assert set(one.panels) <= panels.get(one.figure, set()), one.subject
        assert not one.history or one.history in HISTORIES

    _, table = paper_figures(names)
    assert isinstance(table, Table)
    places = {row[0]: row[2] for row in table.rows}
    assert places["Structure, wheels and sensors"] == f"Figure {names.index('structure') + 1}"
    first, second = names.index(STUDY[0]) + 1, names.index(STUDY[2]) + 1
    assert places["Rotation about x"] == f"Figure {first}, {second}, “Rotation about x”"
    assert places["Concepts of missions with large apertures (its Fig. 1)"].startswith("none: ")


def test_a_page_without_a_figure_names_the_command_that_draws_it():
    _, table = paper_figures(STUDY)
    assert isinstance(table, Table)
    assert "flexsat figures" in {row[0]: row[2] for row in table.rows}["Campbell diagram"]
