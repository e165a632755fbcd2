"""The diagram of the software: its folders exist, and its arrows follow the way from parameters to a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import flexbench
import flexsat
import lockstep
from flexbench.figures.figure_lists import design_figures
from flexbench.figures.software import ARROWS, BOXES, PACKAGES


def test_software_diagram_shows_folders_that_exist():
    roots = {package.__name__: Path(str(package.__file__)).parent for package in (flexsat, lockstep, flexbench)}
    assert list(roots) == list(PACKAGES)
    for folder in BOXES:
        package, _, name = folder.partition("/")
        assert (roots[package] / name).is_dir() or (roots[package] / f"{name}.py").is_file(), folder
    assert {end for arrow in ARROWS for end in arrow} == set(BOXES)


def test_software_diagram_is_legible_and_saved(built: Any, check_saved: Any):
    figure = design_figures(built)["software"]()
    (axes,) = figure.axes
    drawn = [patch.get_label() for patch in axes.patches]
    assert set(drawn) == {*PACKAGES, *BOXES}
    assert len([text for text in axes.texts if text.get_text() == ""]) == len(ARROWS)
    svg = check_saved(figure, "software")
    assert "<!-- spacecraft -->" in svg
