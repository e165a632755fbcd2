"""The figure of fine pointing: both loops, the last seconds, and published values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.figures.fine_pointing import fine_pointing_comparison
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ARCSECOND, ConfigurationName
from lockstep import Signals


def test_fine_pointing_draws_both_loops_and_the_last_seconds(
    runs: dict[ConfigurationName, Signals], lines: Any, heights: Any
):
    figure = fine_pointing_comparison(runs, runs)

    pointing, jitter, whole, deformation = figure.axes
    assert [axes.get_yscale() for axes in figure.axes] == ["log", "linear", "linear", "linear"]
    assert "[arcsec]" in pointing.get_ylabel()
    assert "10^{-3}$ arcsec]" in jitter.get_ylabel()
    assert "[µm]" in whole.get_ylabel()
    assert "[µm]" in deformation.get_ylabel()
    labels = {f"{name}, {loop} loop" for name in CONFIGURATIONS for loop in ("open", "closed")}
    for axes in figure.axes:
        assert {line.get_label() for line in axes.get_lines()} == labels
        assert len({line.get_color() for line in axes.get_lines()}) == 4
    assert_allclose(heights(lines(pointing, "centralised, closed")[0]), 2.0, rtol=1e-6)
    assert_allclose(heights(lines(jitter, "centralised, closed")[0]), 0.0, atol=1e-6)
    assert_allclose(heights(lines(deformation, "centralised, closed")[0]), 0.1, rtol=1e-12)  # um
    for axes in (jitter, deformation):
        assert_allclose(axes.get_xlim(), (28.0, 30.0), rtol=1e-9)
    for axes in (pointing, whole):
        assert_allclose(axes.get_xlim(), (0.0, 30.0), rtol=1e-9)
    assert deformation.get_ylim()[0] == 0.0
    assert whole.dataLim.y1 == pytest.approx(5.0)  # um: the spike of one sample


def test_fine_pointing_zoom_shows_the_error_about_its_mean(designs: Any, lines: Any, heights: Any, made_signals: Any):
    signals = made_signals(designs["centralised"], 0.0)
    wobble = 3e-3 * np.sin(2.0 * np.pi * 5.0 * signals.time)  # arcsec, on 1 arcsec; ten whole turns in the zoom
    signals.columns["plant.attitude.mrp[1]"] = np.tan((1.0 + wobble) * ARCSECOND / 4.0)

    figure = fine_pointing_comparison({"centralised": signals}, {})

    drawn = heights(lines(figure.axes[1], "centralised, closed")[0])
    assert_allclose((drawn.min(), drawn.max()), (-3.0, 3.0), rtol=1e-2)  # 40 samples a turn


def test_fine_pointing_of_a_single_row_is_drawn(designs: Any, made_signals: Any):
    signals = {"centralised": made_signals(designs["centralised"], ARCSECOND, 1)}

    assert len(fine_pointing_comparison(signals, {}).axes) == 4


def test_fine_pointing_without_results_is_refused():
    with pytest.raises(ValueError, match="one run at least"):
        fine_pointing_comparison({}, {})


def test_fine_pointing_draws_the_published_values(whole_runs: Any, crowded: Any, lines: Any, heights: Any, legend: Any):
    figure = fine_pointing_comparison(whole_runs, whole_runs)

    pointing, _, whole, _ = figure.axes
    assert [heights(line)[0] for line in lines(pointing, "published, ")] == [0.068, 0.038]
    assert sorted(heights(line)[0] for line in lines(whole, "published, ")) == [0.15, 0.27, 0.27, 0.33]
    for line in lines(pointing, "published, ") + lines(whole, "published, "):
        assert_allclose(np.asarray(line.get_xdata()), (150.0, 300.0), rtol=1e-9)
    assert any("published" in text for text in legend(figure))
    assert crowded(figure) == []
