"""Lines, bands, logarithmic axes and files that all figures share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

from flexbench.figures.drawing import (
    BINS,
    bin_edges,
    draw_line,
    draw_noisy,
    envelope,
    make_logarithmic,
    save_figure,
)

PERIOD = 0.005  # s, of the controller


def test_envelope_keeps_a_short_series():
    time = np.arange(2.0 * BINS)
    assert envelope(time, time**2)[1] is not time
    assert_allclose(envelope(time, time**2), (time, time**2), atol=0.0)


def test_envelope_keeps_every_peak_and_only_points_of_the_series():
    time = np.arange(100_000) * PERIOD
    values = np.sin(40.0 * time)
    values[[17, 55_555]] = 9.0, -7.0

    short_time, short = envelope(time, values)

    assert len(short) <= 2 * BINS + 2
    assert np.all(np.diff(short_time) > 0.0)
    assert (short.max(), short.min()) == (9.0, -7.0)
    assert (short_time[0], short_time[-1]) == (time[0], time[-1])
    assert_allclose(short, values[np.rint(short_time / PERIOD).astype(int)], atol=0.0)


@pytest.mark.parametrize("rows", [1, 7, BINS, 60_001])
def test_bins_cover_all_rows_and_none_is_empty(rows: int):
    edges = bin_edges(rows)
    assert (edges[0], edges[-1]) == (0, rows)
    assert np.all(np.diff(edges) > 0)


def test_noise_is_drawn_as_rms_in_a_band_of_all_values():
    axes = Figure().add_subplot()
    values = np.tile([0.0, 2.0], 5 * BINS)
    values[100] = 50.0

    line = draw_noisy(axes, np.arange(len(values)) * 1.0, values, "noise", {"color": "black"})

    rms = np.asarray(line.get_ydata(), dtype=float)
    assert len(rms) == BINS
    assert_allclose(rms[20:], np.sqrt(2.0), rtol=1e-12)  # of zeros and twos; rounding
    (band,) = axes.collections
    reach = band.get_paths()[0].vertices[:, 1]
    assert (reach.min(), reach.max()) == (0.0, 50.0)


def test_a_dip_to_nothing_does_not_stretch_a_logarithmic_axis():
    axes = Figure().add_subplot()
    values = np.full(1000, 3.0)
    values[0] = 0.0
    values[500] = 1e-12
    axes.plot(np.arange(1000), values)

    make_logarithmic(axes)

    low, high = axes.get_ylim()
    assert 1.0 < low < 3.0 < high < 5.0


def test_nothing_stays_on_a_linear_axis():
    axes = Figure().add_subplot()
    axes.plot([0.0, 1.0], [0.0, 0.0])

    make_logarithmic(axes)

    assert axes.get_yscale() == "linear"


def noisy_figure() -> Figure:
    """Return a figure with all kinds of artists that get an id in an SVG."""
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    time = np.arange(5.0 * BINS)
    draw_noisy(axes, time, np.sin(time), "noise", {"color": "black"})
    draw_line(axes, time, np.cos(time), "line", {"color": "red", "marker": "D"})
    axes.legend()
    return figure


def test_saved_figures_repeat_byte_for_byte(tmp_path: Path):
    first, second = (save_figure(noisy_figure(), tmp_path / folder, "noisy") for folder in ("one", "two"))

    assert [path.name for path in first] == ["noisy.png", "noisy.svg"]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
    assert b"<dc:date>" not in first[1].read_bytes()


def test_an_hour_of_noise_makes_a_small_file(tmp_path: Path):
    figure = Figure()
    time = np.arange(720_000) * PERIOD
    noise = np.random.default_rng(1).standard_normal(len(time))
    draw_line(figure.add_subplot(), time, noise, "noise", {"color": "black"})

    _, svg = save_figure(figure, tmp_path, "noise")

    assert svg.stat().st_size < 50_000  # 600 points of about 20 characters, and the axes; all rows would make 14 MB
