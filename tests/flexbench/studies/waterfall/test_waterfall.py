"""Crossings of harmonic and modes, against closed forms and the real design; the figure of the waterfall."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.cli.parser import main
from flexbench.figures.waterfall import allowed_bands, waterfall_figure
from flexbench.report.sections.waterfall import waterfall_blocks
from flexbench.studies.waterfall import Waterfall, find_crossings
from flexbench.studies.waterfall.sweep import crossing_deformation, predict, write_waterfall
from flexbench.studies.waterfall.tables import flagged_rows
from flexsat.design.chain import Design, build_designs
from flexsat.parameters import RPM
from flexsat.spacecraft.campbell_crossings import modal_frequencies
from flexsat.variants import AS_PUBLISHED
from lockstep import read_signals


@pytest.fixture(scope="module")
def design() -> Design:
    return build_designs("centralised").corrected


def made(design: Design, crossings: list) -> Waterfall:
    """Make a sweep of four speeds whose density has a ridge on the harmonic."""
    speed = np.array([100.0, 200.0, 300.0, 400.0]) * RPM
    frequency = np.linspace(0.0, 10.0, 101)
    density = np.full((101, 4), 1e-20)
    for k, w in enumerate(speed):
        density[np.argmin(np.abs(frequency - w / (2.0 * np.pi))), k] = 1e-14
    return Waterfall(
        configuration="centralised", seed=4, stop=5.0, fmus="native", speed=speed, frequency=frequency, density=density,
        rms=np.full(4, 2e-7), predicted=predict(design, speed), crossings=crossings,
    )  # fmt: skip


def test_crossings_of_straight_lines_are_found_and_flagged_in_their_bands():
    speed = np.linspace(10.0, 40.0, 7)
    modes = np.array([np.full(7, 22.0), 12.5 + 0.5 * speed, np.full(7, 50.0), np.full(7, 15.0)])
    found = find_crossings(speed, modes, nominal=np.array([20.0, 26.0, 35.0]), band=2.5)

    # a flat mode, a split one: w = 12.5 + w / 2 at 25, none at 50, and one exactly on a grid point
    assert_allclose([crossing.speed for crossing in found], [15.0, 22.0, 25.0], rtol=1e-12)
    assert [crossing.mode for crossing in found] == [4, 1, 2]
    assert [tuple(crossing.wheels) for crossing in found] == [(), (1,), (2,)]
    assert [crossing.flagged for crossing in found] == [False, True, True]


def test_a_crossing_of_the_design_is_a_resonance_of_its_linear_response(design: Design):
    speed = np.linspace(100.0, 420.0, 40) * RPM
    band = design.config.wheel.speed_band
    found = find_crossings(speed, modal_frequencies(design.structure, speed, speed[-1]), design.response.nominal, band)
    assert len(found) >= 10
    for crossing in found:
        inside = np.abs(design.response.nominal - crossing.speed) <= band
        assert [i + 1 for i in np.flatnonzero(inside)] == list(crossing.wheels)
    at, beside = (predict(design, factor * np.array([c.speed for c in found])) for factor in (1.0, 1.04))
    # half a percent of damping: 4 % off, a mode that the wheels excite has fallen to a small part
    assert np.count_nonzero(at > 3.0 * beside) >= 2
    missed = predict(design, 1.01 * np.array([found[int(np.argmax(at / beside))].speed]))
    assert missed[0] < 0.8 * at[np.argmax(at / beside)]
    flagged = [crossing for crossing in found if crossing.flagged]
    assert all(crossing_deformation(design, crossing) > 0.0 for crossing in flagged)


def test_allowed_bands_are_the_union_of_the_wheels(design: Design):
    bands = np.array(allowed_bands(design)) / RPM
    nominal = np.unique(np.round(design.response.nominal / RPM, 3))
    assert len(bands) == len(nominal)  # centralised: 223 and 351 rpm, apart
    assert_allclose(bands.mean(axis=1), nominal, atol=1e-3)
    assert_allclose(np.diff(bands, axis=1), 50.0, rtol=1e-9)


def test_figure_marks_flagged_crossings_and_draws_measured_over_linear(design: Design):
    nominal = float(design.response.nominal.min())
    crossings = find_crossings(
        np.array([0.9, 1.1]) * nominal,
        np.full((1, 2), nominal),
        design.response.nominal,
        design.config.wheel.speed_band,
    )
    figure = waterfall_figure(made(design, crossings), design)

    upper, lower, bar = figure.axes
    marks = {line.get_label(): line for line in upper.get_lines()}
    assert_allclose(marks["crossing inside an allowed band"].get_xdata(), [nominal / RPM])
    assert_allclose(marks["crossing inside an allowed band"].get_ydata(), [nominal / (2.0 * np.pi)])
    assert len(marks["crossing outside"].get_xdata()) == 0
    harmonic = marks["first harmonic"]
    assert_allclose(harmonic.get_ydata(), np.asarray(harmonic.get_xdata()) / 60.0, rtol=1e-12)
    mesh = upper.collections[0].get_array()
    assert_allclose(np.nanmax(mesh), 0.1, rtol=1e-9)  # um/sqrt(Hz)
    assert "[µm/√Hz]" in bar.get_ylabel()
    assert lower.get_xlabel() == "wheel speed [rpm]"
    (measured,) = (line for line in lower.get_lines() if str(line.get_label()).startswith("co-simulation"))
    assert_allclose(measured.get_ydata(), 0.2, rtol=1e-12)


def test_sweep_is_reported_with_the_run_next_to_it(tmp_path: Path, design: Design):
    assert waterfall_blocks(tmp_path / "run") == []
    nominal = float(design.response.nominal.min())
    grid = np.array([0.9, 1.1]) * nominal
    crossings = find_crossings(grid, np.full((1, 2), nominal), design.response.nominal, design.config.wheel.speed_band)
    write_waterfall(made(design, crossings), design, tmp_path / "waterfall")

    content = json.loads((tmp_path / "waterfall" / "waterfall.json").read_text())
    (row,) = flagged_rows(content)
    assert row[0] == f"{nominal / RPM:.1f}"
    assert len(waterfall_blocks(tmp_path / "run")) == 3


def test_a_sweep_as_published_flies_25_modes_and_is_named_so(tmp_path: Path, delivered: Path, capsys: Any):
    system = delivered / "centralised" / "fine_pointing_open_loop.ssd"
    code = main(["waterfall", str(system), "--as-published", "--points", "2", "--stop-time", "1", "--jobs", "1",
                 "--speed-range", "340", "360", "--out", str(tmp_path / "out")])  # fmt: skip
    assert code == 0
    assert "centralised, as published, seed 1:" in capsys.readouterr().out
    content = json.loads((tmp_path / "out" / "waterfall.json").read_text())
    assert content["as_published"]
    published = build_designs("centralised").variant(AS_PUBLISHED)
    assert_allclose(content["linear_prediction_rms_m"], predict(published, np.array([340.0, 360.0]) * RPM), rtol=1e-9)
    shape = read_signals(tmp_path / "out" / "speed-0340.00rpm")["plant.modal.displacement"]
    assert np.any(shape[:, 24])
    assert not np.any(shape[:, 25:])  # the plant carries no more
