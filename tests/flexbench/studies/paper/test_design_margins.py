"""Margins of the paper's loops: which are analysed, once each, and the numbers and figures that table and page show."""

from __future__ import annotations

import json
from math import log

import numpy as np
import pytest

from flexbench.engine.pools import settings_of
from flexbench.report import paper_pages
from flexbench.report.captions import caption_of
from flexbench.report.study_table import margin_blocks
from flexbench.studies.margins.real_plant import Corner, Stability
from flexbench.studies.margins.stability_table import as_table
from flexbench.studies.margins.study import FILE
from flexbench.studies.paper import design_margins as module
from flexbench.studies.paper.design_margins import (
    HEADER,
    analyse_loop,
    bandwidth,
    find_margins,
    forget,
    last_crossover,
    loop_folder,
    read_margins,
    rows,
    sentences,
)

FREQUENCY = np.geomspace(0.01, 90.0, 200)  # Hz
CROSSED = {"x": 3.0, "y": 5.0, "z": 0.001}  # Hz: where each axis' integrator has gain 1; z has less throughout


def integrator(crossing):
    return crossing / (1j * FREQUENCY)


def curve(values):
    return {"frequency": FREQUENCY.tolist(), "real": values.real.tolist(), "imaginary": values.imag.tolist()}


def content(growth, modes=198):
    """Return what a study leaves of a loop of three integrators, or of one that grows."""
    grid = [Stability(corner=Corner(modes=count, gain=gain), highest=0.4 * count, growth=growth * gain, frequency=6.0)
            for count in (25, modes) for gain in (0.5, 1.0, 2.0)]  # fmt: skip
    found = {
        "seed": 1,
        "stability": {"modes": modes, "highest": 79.6, "growth": growth, "frequency": 6.0, "grid": as_table(grid)},
    }
    if growth < 0.0:
        margins = {"gain_up": 2.0, "gain_up_at": 8.0, "disk": 0.8, "disk_at": 8.0}
        curves = {f"axis {axis}": curve(integrator(crossing)) for axis, crossing in CROSSED.items()}
        found["analysis"] = {
            "exact": {"delay": 0.0125, "gain_up": 2.0, "gain_down": 0.0, "phase": 66.4},
            "margins": {"all wheels": margins},
            "frequency": FREQUENCY.tolist(), "largest_s": [1.2] * 200, "largest_t": [0.9] * 200, "curves": curves,
        }  # fmt: skip
    return found


def leave(folder, name, variant, growth):
    at = loop_folder(folder, name, variant)
    at.mkdir(parents=True)
    (at / FILE).write_text(json.dumps(content(growth)))


def test_the_last_crossover_of_an_integrator_is_where_its_gain_is_one():
    few_ulp = 1e-12  # a straight line over the logarithms, which the interpolation follows
    assert last_crossover(FREQUENCY, integrator(3.0)) == pytest.approx(3.0, rel=few_ulp)
    twice = np.where(FREQUENCY > 20.0, 0.5, 3.0) * np.exp(1j * FREQUENCY)  # down, and no crossing after it
    assert 19.0 < last_crossover(FREQUENCY, twice) < 21.0
    assert last_crossover(FREQUENCY, integrator(0.001)) is None
    assert last_crossover(FREQUENCY, integrator(1e3)) == FREQUENCY[-1]


def test_table_and_sentences_have_margins_bandwidth_and_spillover(tmp_path):
    leave(tmp_path, "centralised", "corrected", -0.01)
    leave(tmp_path, "centralised", "published_design", 1e3 * log(2.0) / 4.0)  # doubles in 4 ms
    flown, lost = read_margins(tmp_path)

    assert (flown.stable, lost.stable) == (True, False)
    assert bandwidth(flown) == pytest.approx(5.0)
    assert bandwidth(lost) is None
    first, second = rows([flown, lost])
    assert first[4:] == ["stable", "to 0, +6.0", "66", "12.5", "0.80", "3, 5, < 0.01"]
    assert second[4] == "unstable: doubles in 4 ms"
    assert len(first) == len(second) == len(HEADER)
    assert sentences([flown, lost]) == [
        "Corrected, robust, on 198 modes, up to 79.6 Hz: centralised stable up to 12.5 ms of delay.",
        "Corrected, published design, on 198 modes, up to 79.6 Hz: centralised unstable (it grows by 173 1/s).",
    ]
    (_, table, _) = margin_blocks(tmp_path)
    assert table.rows == [first, second]
    assert margin_blocks(tmp_path / "none") == []


def test_figures_of_the_loops_are_legible_and_have_captions(tmp_path, designs, crowded):
    leave(tmp_path, "centralised", "as_published", -0.01)
    leave(tmp_path, "centralised", "corrected", -0.01)
    leave(tmp_path, "centralised", "published_design", 50.0)
    drawn = paper_pages.figures_of_loops(read_margins(tmp_path), "centralised", designs["centralised"])

    assert {name.removesuffix("-centralised") for name in drawn} == set(module.FIGURES)
    for name, draw in drawn.items():
        assert crowded(draw()) == [], name
        assert caption_of(name) != name.replace("-", " ")
    assert list(paper_pages.figures_of_loops([], "centralised", designs["centralised"])) == []


@pytest.fixture
def counted(monkeypatch):
    """Replace the analysis; return what was analysed, each with what it was given."""
    found = []

    def study(_, folder, settings, *, analytic_only, grid):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / FILE).write_text(json.dumps(content(-0.01)))
        assert grid.gains == (-6.0, 0.0, 6.0)
        found.append((settings.overrides, analytic_only))

    monkeypatch.setattr(module, "run_study", study)
    monkeypatch.setattr(module, "read_loop", lambda *_: None)
    return found


def test_a_loop_is_analysed_once_and_again_where_something_changed(counted, monkeypatch, tmp_path):
    contents = {"plant.fmu": "first"}  # stands for the bytes of the system's files
    monkeypatch.setattr(module, "load_system", lambda path: path)
    monkeypatch.setattr(module, "of_system", lambda path: [str(path), *contents.values()])
    system, folder = tmp_path / "fine_pointing.ssd", tmp_path / "loop"
    robust, published = {"plant.seed": 1}, {"plant.seed": 1, "controller.design": "published"}
    for overrides in (robust, robust, published, published):
        analyse_loop(system, folder, overrides)
    assert counted == [(robust, True), (published, True)]

    contents["plant.fmu"] = "second"
    analyse_loop(system, folder, published)
    assert len(counted) == 3
    (folder / FILE).write_text("{")  # damaged
    analyse_loop(system, folder, published)
    assert len(counted) == 4


def test_loops_of_other_variants_and_their_figures_do_not_stay(tmp_path):
    leave(tmp_path, "centralised", "corrected", -0.01)
    leave(tmp_path, "centralised", "as_published", -0.01)
    figures = tmp_path / "figures"
    figures.mkdir()
    for name in ("nichols-centralised.png", "slew-seed1.png"):
        (figures / name).touch()
    forget(tmp_path, kept=[loop_folder(tmp_path, "centralised", "corrected")])

    assert [loop.variant for loop in read_margins(tmp_path)] == ["corrected"]
    assert [path.name for path in figures.iterdir()] == ["slew-seed1.png"]
    forget(tmp_path)
    assert read_margins(tmp_path) == []


def test_a_loop_that_cannot_be_analysed_is_named_and_does_not_stop_the_others(tmp_path, monkeypatch):
    limits = []
    monkeypatch.setattr(module, "settings_of", lambda limit: limits.append(limit) or settings_of(limit))
    failed = find_margins(tmp_path / "no-fmus", tmp_path / "study", ["corrected"], 1, processes=1)

    assert sorted(line.partition(": ")[0] for line in failed) == [
        "margins of centralised, corrected, robust",
        "margins of distributed, corrected, robust",
    ]
    assert all("no such file" in line for line in failed)
    assert min(limits) > 600.0  # s: an analysis shows no progress, and a busy machine takes minutes for it
