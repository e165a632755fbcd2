"""What the figures draw: data, labels with units, limits; never pixels."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.testing import assert_allclose

from flexbench import figures
from flexbench.figures.drawing import BINS, bin_edges, draw_line, draw_noisy, envelope, make_logarithmic
from flexbench.loop.scenarios import slew_end
from flexsat.design.chain import Design, build_designs
from flexsat.parameters import ARCSECOND, CONFIGURATIONS, Aperture, ConfigurationName, Plate
from flexsat.runtime.rotations import rotate_mrp
from flexsat.structure.mesh import record_mesh
from flexsat.structure.modes import Structure, build_structure
from lockstep import Signals

WHOLE = 60_001  # rows of 300 s
ROWS, PERIOD = 6001, 0.005  # 30 s at the controller's period: more rows than are drawn
UNIT = re.compile(r"\[.+\]$")
Designs = dict[ConfigurationName, Design]


@pytest.fixture(scope="module")
def drawn_designs() -> Designs:
    return {name: build_designs(name).corrected for name in CONFIGURATIONS}


@pytest.fixture(scope="module")
def drawn_structure() -> Structure:
    return build_structure(record_mesh(Aperture()), Plate())


def made_signals(design: Design, error: float, rows: int = ROWS) -> Signals:
    """Make a run at rest, `error` [rad] off about x, with one spike of deformation in row 1234."""
    modes, wheels = design.spacecraft.mode_count, design.spacecraft.wheel_count
    sizes = {"modal.displacement": modes, "rate": 3, "modal.velocity": modes}
    columns: dict[str, Any] = {}

    def add(name: str, values: Any) -> None:
        values = np.broadcast_to(np.asarray(values, dtype=float), (rows, np.shape(values)[-1]))
        columns.update({f"{name}[{i + 1}]": values[:, i] for i in range(values.shape[1])})

    for name, size in sizes.items():
        add(f"plant.{name}", np.zeros(size))
        add(f"controller.reference.{name}", np.zeros(size))
    add("plant.attitude.mrp", rotate_mrp((0.0, 0.0, 0.0), (error, 0.0, 0.0)))
    add("controller.reference.mrp", np.zeros(3))
    add("plant.wheel.speed", design.response.nominal)
    add("controller.reference.wheel.speed", np.zeros(wheels))
    add("controller.reference.torque", np.zeros(wheels))
    add("controller.wheel.torque", np.full(wheels, 0.25))
    columns["plant.rms_deformation"] = np.full(rows, 1e-7)
    columns["plant.rms_deformation"][1234:1235] = 5e-6
    return Signals(time=np.arange(rows) * PERIOD, columns=columns, units={}, descriptions={})


@pytest.fixture(scope="module")
def runs(drawn_designs: Designs) -> dict[ConfigurationName, Signals]:
    return {
        name: made_signals(drawn_designs[name], error)
        for name, error in zip(CONFIGURATIONS, (2.0 * ARCSECOND, 1.0 * ARCSECOND), strict=True)
    }


@pytest.fixture(scope="module")
def slew(runs: dict[ConfigurationName, Signals], drawn_designs: Designs) -> Figure:
    return figures.slew_comparison(runs, drawn_designs)


def panel(figure: Figure, title: str) -> Axes:
    (found,) = [axes for axes in figure.axes if axes.get_title("left").startswith(title)]
    return found


def lines(axes: Axes, label: str) -> list[Line2D]:
    found = [line for line in axes.get_lines() if str(line.get_label()).startswith(label)]
    assert found, f"no line {label!r}"
    return found


def heights(line: Line2D) -> Any:
    return np.asarray(line.get_ydata(), dtype=float)


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

    rms = heights(line)
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


def test_mode_shapes_draw_each_mode_with_its_frequency_on_one_symmetric_scale(drawn_structure: Structure):
    figure = figures.mode_shapes(drawn_structure, 7)

    panels = [axes for axes in figure.axes if axes.get_title().startswith("mode")]
    titles = [axes.get_title() for axes in panels]
    hertz = drawn_structure.frequency[:7] / (2.0 * np.pi)
    published = (
        0.3441,
        0.3441,
        0.4117,
        0.5285,
        0.5285,
        1.026,
        1.245,
    )  # PHYSICS section 1, the authors' finite elements
    assert titles == [
        f"mode {k}:  {value:.3f} Hz  ({theirs})"
        for k, (value, theirs) in enumerate(zip(hertz, published, strict=True), start=1)
    ]
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told == ["clamped to the bus", "bus", "in brackets: the authors' finite elements [Hz]"]
    largest = np.abs(drawn_structure.shape[::3, :7]).max()
    for axes in panels:
        filled = axes.collections[0]
        assert_allclose(filled.get_clim(), (-filled.get_clim()[1], filled.get_clim()[1]), rtol=1e-12)
        assert_allclose((filled.levels[0], filled.levels[-1]), (-largest, largest), rtol=1e-12)
        assert axes.get_aspect() == 1.0
    (bar,) = [axes for axes in figure.axes if axes.get_ylabel().startswith("deflection")]
    assert UNIT.search(bar.get_ylabel())


def test_mode_shapes_mark_the_six_clamped_vertices(drawn_structure: Structure):
    figure = figures.mode_shapes(drawn_structure, 1)

    (clamped,) = lines(figure.axes[0], "clamped")
    x, y = (np.asarray(data) for data in (clamped.get_xdata(), clamped.get_ydata()))
    assert_allclose(np.hypot(x, y), np.full(6, 2.0), rtol=1e-9)


def test_mode_shapes_outline_is_the_edge_of_aperture_and_hole(drawn_structure: Structure):
    figure = figures.mode_shapes(drawn_structure, 1)

    outline = figure.axes[0].collections[-1].get_segments()
    # 54 outer vertices and 6 of the hole, and as many edges; one of an edge of 2 m each
    assert len(outline) == 60
    assert_allclose([np.linalg.norm(end - start) for start, end in outline], np.full(60, 2.0), rtol=1e-9)


def test_mode_shapes_of_a_design_are_those_of_its_structure(drawn_designs: Designs, drawn_structure: Structure):
    of_design, of_structure = (
        figures.mode_shapes(given, 2).axes[1].get_title() for given in (drawn_designs["distributed"], drawn_structure)
    )
    assert of_design == of_structure


@pytest.mark.parametrize("count", [0, 26])
def test_mode_shapes_refuse_more_modes_than_there_are(drawn_structure: Structure, count: int):
    with pytest.raises(ValueError, match=f"count must be from 1 to 25, got {count}"):
        figures.mode_shapes(drawn_structure, count)


def test_slew_has_nine_panels_with_units_over_the_whole_run(slew: Figure):
    assert len(slew.axes) == 9
    assert len({axes.get_title("left") for axes in slew.axes}) == 9
    for axes in slew.axes:
        assert UNIT.search(axes.get_ylabel()), axes.get_title("left")
        assert_allclose(axes.get_xlim(), (0.0, ROWS * PERIOD), rtol=1e-9)
    assert [axes.get_xlabel() for axes in slew.axes] == [""] * 6 + ["time [s]"] * 3


def test_slew_marks_its_start_and_end_in_every_panel(slew: Figure, drawn_designs: Designs):
    expected = {5.0, *(slew_end(design) for design in drawn_designs.values())}
    for axes in slew.axes:
        upright = {float(line.get_xdata()[0]) for line in axes.get_lines() if len(line.get_xdata()) == 2}
        assert upright == expected


def test_slew_draws_errors_in_the_units_of_the_labels(slew: Figure):
    pointing = panel(slew, "Pointing")
    assert "[arcsec]" in pointing.get_ylabel()
    assert pointing.get_yscale() == "log"
    assert_allclose(heights(lines(pointing, "centralised")[0]), 2.0, rtol=1e-6)
    assert_allclose(heights(lines(pointing, "distributed")[0]), 1.0, rtol=1e-6)
    rotation = panel(slew, "Rotation")
    assert_allclose(heights(lines(rotation, "centralised")[0]), 2.0 / 3600.0, rtol=1e-6)
    assert_allclose(heights(lines(rotation, "reference")[0]), 0.0, atol=0.0)


def test_slew_shows_a_spike_of_one_sample(slew: Figure):
    deformation = panel(slew, "Deformation")
    assert deformation.dataLim.y1 == pytest.approx(5.0)  # um
    assert deformation.get_ylim()[1] > 5.0


def test_slew_sums_torque_over_wheels_and_time(slew: Figure):
    for name, wheels in (("centralised", 6), ("distributed", 33)):
        assert_allclose(heights(lines(panel(slew, "Wheel torque, over"), name)[0])[-1], 0.25 * wheels * 30.0)


def test_slew_cost_grows_to_the_sum_over_samples(slew: Figure, drawn_designs: Designs):
    cost = panel(slew, "LQR cost")
    for name in CONFIGURATIONS:
        weights = drawn_designs[name].regulator.torque_weight
        expected = ROWS * 0.5 * 0.25**2 * weights.sum()
        assert_allclose(heights(lines(cost, f"{name}, control")[0])[-1], expected, rtol=1e-9)
        assert heights(lines(cost, f"{name}, total")[0])[-1] > expected


def test_slew_draws_the_x_wheels_against_their_band(slew: Figure):
    wheels = panel(slew, "Wheels")
    about_x = {"centralised": range(1, 7, 3), "distributed": range(1, 34, 3)}  # +x +y +z, -x -y -z, ...
    for name, numbers in about_x.items():
        assert [line.get_label() for line in lines(wheels, name)] == [f"{name}, wheel {k}" for k in numbers]
    (band,) = wheels.patches
    assert_allclose((band.get_y(), band.get_y() + band.get_height()), (-25.0, 25.0), rtol=1e-12)  # rpm


def test_slew_tells_the_configurations_apart_without_colour(slew: Figure):
    one, other = (lines(panel(slew, "Rotation"), name)[0] for name in CONFIGURATIONS)
    assert one.get_color() != other.get_color()
    assert one.get_linewidth() != other.get_linewidth()
    assert one._dash_pattern != other._dash_pattern
    labels = [text.get_text() for text in slew.legends[0].get_texts()]
    assert labels[:3] == ["centralised", "distributed", "reference"]


def test_slew_of_one_configuration_is_drawn_alone(runs: Any, drawn_designs: Designs):
    figure = figures.slew_comparison({"distributed": runs["distributed"]}, drawn_designs)
    assert "centralised" not in [text.get_text() for text in figure.legends[0].get_texts()]


def test_figures_refuse_no_results(drawn_designs: Designs):
    with pytest.raises(ValueError, match="one configuration at least"):
        figures.slew_comparison({}, drawn_designs)
    with pytest.raises(ValueError, match="one run at least"):
        figures.fine_pointing_comparison({}, {})


def test_fine_pointing_draws_both_loops_and_the_last_seconds(runs: dict[ConfigurationName, Signals]):
    figure = figures.fine_pointing_comparison(runs, runs)

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
        assert_allclose(axes.get_xlim(), (0.0, ROWS * PERIOD), rtol=1e-9)
    assert deformation.get_ylim()[0] == 0.0
    assert whole.dataLim.y1 == pytest.approx(5.0)  # um: the spike of one sample


def test_a_run_of_a_single_row_is_drawn(drawn_designs: Designs):
    signals = {"centralised": made_signals(drawn_designs["centralised"], ARCSECOND, 1)}

    assert len(figures.fine_pointing_comparison(signals, {}).axes) == 4
    assert len(figures.slew_comparison(signals, drawn_designs).axes) == 9


def test_fine_pointing_zoom_shows_what_the_error_does_about_its_mean(drawn_designs: Designs):
    signals = made_signals(drawn_designs["centralised"], 0.0)
    wobble = 3e-3 * np.sin(2.0 * np.pi * 5.0 * signals.time)  # arcsec, on 1 arcsec; ten whole turns in the zoom
    signals.columns["plant.attitude.mrp[1]"] = np.tan((1.0 + wobble) * ARCSECOND / 4.0)

    figure = figures.fine_pointing_comparison({"centralised": signals}, {})

    drawn = heights(lines(figure.axes[1], "centralised, closed")[0])
    assert_allclose((drawn.min(), drawn.max()), (-3.0, 3.0), rtol=1e-2)  # 40 samples a turn


def test_published_values_stand_where_and_when_they_refer_to(drawn_designs: Designs, crowded: Any):
    whole_runs = {name: made_signals(drawn_designs[name], ARCSECOND, WHOLE) for name in CONFIGURATIONS}
    slew = figures.slew_comparison(whole_runs, drawn_designs)
    fine = figures.fine_pointing_comparison(whole_runs, whole_runs)
    expected = {  # PHYSICS section 7
        ("Pointing error", "centralised"): 49.0,
        ("Pointing error", "distributed"): 1.8,
        ("Angular rate error", "centralised"): 1.1e-3,
        ("Angular rate error", "distributed"): 1.1e-4,
        ("Deformation", "centralised"): 2.3,
        ("Deformation", "distributed"): 0.33,
    }
    for (title, name), value in expected.items():
        (line,) = lines(panel(slew, title), f"published, {name}")
        assert_allclose(heights(line), value, rtol=1e-12)
        assert_allclose(np.asarray(line.get_xdata()), (150.0, 300.0), rtol=1e-9)
    costs = [heights(line)[0] for line in lines(panel(slew, "LQR cost"), "published, ")]
    assert sorted(costs) == [34.0, 219.0, 461.0, 1.9e4]
    settled = [line.get_xdata()[0] for line in lines(panel(slew, "Pointing"), "published settling")]
    assert_allclose(
        settled, [slew_end(drawn_designs["centralised"]) + 100.0, slew_end(drawn_designs["distributed"]) + 30.0]
    )
    pointing, _, whole, _ = fine.axes
    assert [heights(line)[0] for line in lines(pointing, "published, ")] == [0.068, 0.038]
    assert sorted(heights(line)[0] for line in lines(whole, "published, ")) == [0.15, 0.27, 0.27, 0.33]
    for line in lines(pointing, "published, ") + lines(whole, "published, "):
        assert_allclose(np.asarray(line.get_xdata()), (150.0, 300.0), rtol=1e-9)
    for figure in (slew, fine):
        assert crowded(figure) == []
        assert any("published" in text.get_text() for text in figure.legends[0].get_texts())


def test_published_rows_of_the_published_variant_refer_to_its_window(drawn_designs: Designs):
    design = replace(drawn_designs["distributed"], as_published=True)
    signals = made_signals(design, ARCSECOND, WHOLE)

    figure = figures.slew_comparison({"distributed": signals}, {"distributed": design})

    for title, start, end in (("Angular rate", 75.0, 150.0), ("Deformation", 75.0, 150.0), ("Pointing", 150.0, 300.0)):
        (line,) = lines(panel(figure, title), "published, distributed")
        assert_allclose(np.asarray(line.get_xdata()), (start, end), rtol=1e-9)


def test_a_short_run_is_not_compared_with_published_values(slew: Figure):
    labels = [str(line.get_label()) for axes in slew.axes for line in axes.get_lines()]
    assert not [label for label in labels if label.startswith("published")]


def test_saved_figures_repeat_byte_for_byte(tmp_path: Path, runs: dict[ConfigurationName, Signals]):
    first, second = (
        figures.save_figure(figures.fine_pointing_comparison(runs, runs), tmp_path / folder, "fine-pointing")
        for folder in ("one", "two")
    )

    assert [path.name for path in first] == ["fine-pointing.png", "fine-pointing.svg"]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
    assert b"<dc:date>" not in first[1].read_bytes()


def test_an_hour_of_noise_makes_a_small_file(tmp_path: Path):
    figure = Figure()
    time = np.arange(720_000) * PERIOD
    noise = np.random.default_rng(1).standard_normal(len(time))
    draw_line(figure.add_subplot(), time, noise, "noise", {"color": "black"})

    _, svg = figures.save_figure(figure, tmp_path, "noise")

    assert svg.stat().st_size < 50_000  # 600 points of about 20 characters, and the axes; all rows would make 14 MB
