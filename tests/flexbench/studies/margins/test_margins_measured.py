"""Test signals, estimates and growth rates against closed forms; figures and tables of the study."""

import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from numpy.testing import assert_allclose

from flexbench.figures.margins import margin_figures, nichols_chart, sensitivity_singular_values
from flexbench.html.document import Heading, Paragraph, Picture, Table
from flexbench.html.render import as_html
from flexbench.report.sections.margins import section
from flexbench.runs.run_folder import Run, read_run
from flexbench.studies.margins.estimate import (
    COHERENT,
    MeasuredLoop,
    estimate_loop,
    jackknife,
    measured_margins,
    merged,
    transient,
)
from flexbench.studies.margins.injection import _drift
from flexbench.studies.margins.multisine import design_multisine
from flexbench.studies.margins.response import loop_margins
from flexbench.studies.margins.study import FILE, Curve, curves, zoomed_lines
from flexbench.studies.margins.tables import exact_rows, margin_rows
from flexbench.studies.margins.unstable_delay import WINDOW, growth_of

SAMPLE = 0.01  # s


# The test signal


def test_a_multisine_has_its_lines_and_no_others():
    signal = design_multisine(SAMPLE, 8.0, (0.25, 40.0), 20)
    spectrum = np.abs(np.fft.rfft(signal.values)) * 2.0 / len(signal.values)
    lines = np.flatnonzero(spectrum > 1e-9)
    assert_allclose(lines, signal.lines)
    assert_allclose(spectrum[lines], spectrum[lines[0]], rtol=1e-9)  # equal sines
    assert np.abs(signal.values).max() == pytest.approx(1.0)
    assert signal.frequency[0] == pytest.approx(0.25)
    assert signal.frequency[-1] == pytest.approx(40.0)
    assert np.sqrt(np.mean(signal.values**2)) > 0.3  # as one sine has .7, and sines in phase .16


def test_no_line_is_an_alias_of_another():
    # a sampler of 0.1 s turns a line at f into lines at |f + 10 k| Hz
    signal = design_multisine(0.005, 10.0, (0.1, 95.0), None, 0.1)
    images = {int(line): {abs(int(line) + 100 * k) for k in range(-10, 10)} for line in signal.lines}
    for line, others in images.items():
        assert not others & (set(images) - {line})
    assert len(images) > 20


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"length": 5.003}, "length 5.003 s must be a whole multiple of 0.01 s"),
        ({"slow_period": 0.3}, "length 5 s must be a whole multiple of 0.3 s"),
        ({"band": (0.1, 10.0)}, "band 0.1 to 10 Hz: must rise, from 1 / length = 0.2 Hz"),
        ({"band": (1.0, 50.0)}, "to below half the sampling rate, 50 Hz"),
        ({"lines": 0}, "lines must be >= 1, got 0"),
    ],
)
def test_multisine_that_does_not_fit_is_refused(changed, message):
    given = {"length": 5.0, "band": (1.0, 20.0), "lines": 10, "slow_period": None} | changed
    with pytest.raises(ValueError, match=message):
        design_multisine(SAMPLE, given["length"], given["band"], given["lines"], given["slow_period"])


# The estimate


def synthetic(noise, periods=6, seed=3):
    """Return experiments on two coupled channels of known L, from the definition u = d - L u, line by line."""
    signal = design_multisine(SAMPLE, 4.0, (0.5, 45.0), 24)
    back = np.exp(-2j * np.pi * signal.frequency * SAMPLE)
    loop = np.einsum("f,ij->fij", 0.3 * back / (1.0 - 0.9 * back), np.array([[1.0, 0.2], [-0.1, 0.7]]))
    generator = np.random.default_rng(seed)
    samples = len(signal.values)
    shape = np.fft.rfft(signal.values)[signal.lines]
    experiments = []
    for k in range(2):
        injected = shape[:, None] * np.eye(2)[k]
        inputs = np.linalg.solve(np.eye(2) + loop, injected[..., None])[..., 0]
        spectra = np.zeros((2, samples // 2 + 1, 2), complex)
        spectra[0, signal.lines], spectra[1, signal.lines] = inputs - injected, inputs
        before, after = (np.tile(np.fft.irfft(each, samples, axis=0), (periods, 1, 1)) for each in spectra)
        disturbance = noise * generator.standard_normal(before.shape)
        experiments.append((before + disturbance, after + disturbance))
    return signal, loop, experiments


def test_loop_is_estimated_exactly_without_noise():
    signal, loop, experiments = synthetic(0.0)
    found, _ = estimate_loop(experiments, signal, np.eye(2), ("a", "b"))
    assert_allclose(found.together, loop, atol=1e-12)
    assert_allclose(found.coherence, 1.0, rtol=1e-12)
    # one channel opened, the other closed: a + b c / (1 + d), from the definition
    expected = loop[:, 0, 0] - loop[:, 0, 1] * loop[:, 1, 0] / (1.0 + loop[:, 1, 1])
    assert_allclose(found.single[:, 0], expected, atol=1e-12)


def test_a_mode_that_rings_on_does_not_spoil_the_estimate():
    """A loop near instability: after the periods to settle its modes have hardly decayed."""
    signal, loop, experiments = synthetic(0.0)
    time = SAMPLE * np.arange(experiments[0][0][..., 0].size).reshape(experiments[0][0].shape[:2])
    for rate, frequency, channels in ((0.03, 3.1, [1.0, -0.4]), (0.08, 17.3, [0.2, 1.0])):
        ringing = 0.3 * np.exp(-rate * time) * np.cos(2.0 * np.pi * frequency * time + 1.0)
        for before, after in experiments:
            before += ringing[..., None] * channels
            after += ringing[..., None] * channels
    spectra = np.fft.rfft(experiments[0][0], axis=1)[:, signal.lines]
    untreated = np.abs(spectra[0] - spectra[-1]).max() / np.abs(spectra[0]).max()
    found, _ = estimate_loop(experiments, signal, np.eye(2), ("a", "b"))
    assert untreated > 0.05
    assert_allclose(found.together, loop, atol=1e-3)  # each line sees a little of the other mode as well
    assert np.all(found.coherence > COHERENT)


def test_noise_is_not_taken_for_a_decay():
    signal, _, experiments = synthetic(0.01)
    spectra = np.fft.rfft(experiments[0][0], axis=1)[:, signal.lines]
    assert np.count_nonzero(transient(spectra)) == 0


def test_the_stated_uncertainty_covers_the_error():
    inside = []
    for seed in range(20):
        signal, loop, experiments = synthetic(0.05, seed=seed)
        found, _ = estimate_loop(experiments, signal, np.eye(2), ("a", "b"))
        inside.append(np.abs(found.together[:, 0, 0] - loop[:, 0, 0]) <= found.together_uncertainty[:, 0, 0])
    # 460 intervals of 95 %; the modulus of a complex number leaves them a little oftener
    assert 0.9 < np.mean(inside) < 0.99


def test_incoherent_lines_are_not_used():
    signal, _, experiments = synthetic(2.0)
    found, replicas = estimate_loop(experiments, signal, np.eye(2), ("a", "b"))
    assert np.all(found.coherence < COHERENT)
    with pytest.raises(ValueError, match="only 0 of 23 lines are coherent in a: inject more"):
        measured_margins(found, replicas, "a")


def test_the_jackknife_of_a_mean_is_its_standard_error():
    values = np.random.default_rng(1).standard_normal(9)
    left_out = [np.delete(values, k).mean() for k in range(9)]
    assert jackknife(left_out) == pytest.approx(values.std(ddof=1) / 3.0)


def test_one_period_is_not_enough():
    signal, _, experiments = synthetic(0.0, periods=1)
    with pytest.raises(ValueError, match="two periods at least and 2 experiments, got 1 and 2"):
        estimate_loop(experiments, signal, np.eye(2), ("a", "b"))


def resonant(frequency):
    """Return a loop with a narrow mode at 7 Hz, that reaches beyond gain one."""
    s = 2j * np.pi * frequency
    return 5.0 / (s + 1.0) - 400.0 / (s**2 + 0.4 * s + (14.0 * np.pi) ** 2)


def measured_at(frequency):
    """Return a perfect measurement of it, of three periods."""
    loop = resonant(frequency)
    together, single = loop[:, None, None], loop[:, None]
    ones = np.ones(len(frequency))
    found = MeasuredLoop(
        frequency=frequency,
        together=together,
        single=single,
        together_uncertainty=np.zeros(together.shape),
        single_uncertainty=np.zeros(single.shape),
        coherence=ones[:, None],
        coherence_together=ones,
        names=("a",),
        period=SAMPLE,
        periods=3,
    )
    return found, [(together, single)] * 3


def test_zoom_adds_lines_where_a_mode_is_narrower_than_their_spacing():
    first = measured_at(np.geomspace(0.5, 20.0, 24))
    coarse = measured_margins(*first, "a").value
    assert coarse.unresolved
    more = zoomed_lines(*first, 400)
    assert len(more) <= 400
    assert more.min() <= 7.0 <= more.max()
    both = merged(first, measured_at(more))
    assert np.all(np.diff(both[0].frequency) > 0.0)
    fine = measured_margins(*both, "a").value
    dense = np.geomspace(0.5, 20.0, 5000)
    expected = loop_margins(dense, resonant(dense), SAMPLE)
    assert fine.unresolved == ()
    assert fine.phase == pytest.approx(expected.phase, rel=1e-3)
    assert fine.phase < 0.8 * coarse.phase  # the mode decides, and was not seen
    assert len(zoomed_lines(*both, 400)) == 0


def test_measurements_of_different_length_are_not_merged():
    first, second = measured_at(np.array([1.0, 2.0])), measured_at(np.array([3.0, 4.0]))
    with pytest.raises(ValueError, match="3 and 2 periods cannot be merged"):
        merged(first, (replace(second[0], periods=2), second[1]))


def test_a_slow_drift_is_taken_out():
    time = np.arange(4000) * SAMPLE
    periodic = np.sin(2.0 * np.pi * time)
    signal = (periodic + 0.3 * time)[:, None].reshape(4, 1000, 1)
    left = signal - _drift(signal)
    spectrum = np.abs(np.fft.rfft(left[1, :, 0]))
    assert spectrum[11:].max() < 1e-9 * spectrum[10]  # 1 Hz is line 10; a ramp would leak into every other one


@pytest.mark.parametrize("rate", [-0.7, -0.02, 0.05, 1.3])
def test_growth_of_a_mode_next_to_a_strong_one_that_decays(rate):
    time = np.arange(round(2.0 * WINDOW / 0.005)) * 0.005
    strong = np.exp(-0.9 * time) * np.sin(2.0 * np.pi * 5.5 * time)
    weak = 0.05 * np.exp(rate * time) * np.cos(2.0 * np.pi * 26.7 * time)
    found = growth_of(np.column_stack([strong, strong + weak]), 0.005, 1.0)
    assert found.rate == pytest.approx(rate, abs=1e-3)
    assert found.frequency == pytest.approx(26.7, abs=1.0)
    assert found.at(26.7) == pytest.approx(rate, abs=1e-3)


def test_a_loop_at_its_limits_grows():
    time = np.arange(800) * 0.005
    assert growth_of(4.4 * np.sign(np.sin(160.0 * time))[:, None], 0.005, 1e-3).rate > 0.0


# Figures and tables


@pytest.fixture
def content():
    """Return a study with a loop 2 / (s + 1), and one measured point beside it."""
    frequency = np.geomspace(0.1, 10.0, 50)
    values = 2.0 / (2j * np.pi * frequency + 1.0)
    margins = dict.fromkeys(("gain_up_at", "gain_down_at", "phase_at", "delay_at"))
    margins |= {"gain_up": 2.0, "gain_up_at": 3.0, "gain_down": 0.0, "phase": 60.0, "phase_at": 1.0, "delay": 4.1e-3,
                "delay_at": 27.0, "disk": 0.5, "disk_at": 1.5, "unresolved": []}  # fmt: skip
    plus = {"gain_up": 0.1, "phase": 1.5, "delay": 2e-5, "disk": 0.01}
    curve = {"frequency": frequency.tolist(), "real": values.real.tolist(), "imaginary": values.imag.tolist()}
    point = {name: [entries[9]] for name, entries in curve.items()} | {"uncertainty": [0.1]}
    return {
        "seed": 1,
        "analysis": {
            "exact": {"delay": 3.783e-3, "gain_up": 1.25, "gain_down": 0.0, "phase": None, "radius": 0.99},
            "margins": {"all wheels": margins},
            "frequency": frequency.tolist(),
            "largest_s": np.full(50, 1.5).tolist(),
            "largest_t": np.linspace(1.0, 0.1, 50).tolist(),
            "curves": {"axis x": curve},
        },
        "measured": {
            "margins": {
                "x": {"value": margins | {"unresolved": [1.0, 2.0]}, "uncertainty": plus},
                "y": {"problem": "only 0 of 9 lines are coherent"},
            },
            "frequency": frequency.tolist(),
            "coherence": {"x": np.full(50, 0.9995).tolist()},
            "curves": {"x": point},
            "settings": {"length": 20.0, "settle": 2, "periods": 4, "quiet": False},
        },
        "real": {"stable": 3.7e-3, "unstable": 3.8e-3, "delay": 3.7836e-3, "frequency": 26.6, "runs": 8},
    }


def test_the_nichols_chart_shows_gain_over_phase_and_the_measured_points(content):
    figure = nichols_chart(curves(content), 0.5)
    chart, nyquist = figure.axes
    line = next(line for line in chart.get_lines() if line.get_label() == "design: axis x")
    frequency = np.array(content["analysis"]["frequency"])
    assert_allclose(line.get_ydata(), 20.0 * np.log10(2.0 / np.hypot(1.0, 2.0 * np.pi * frequency)))
    assert_allclose(line.get_xdata(), -np.degrees(np.arctan(2.0 * np.pi * frequency)))
    bars = chart.containers[0]
    assert to_hex(bars[0].get_color()) == to_hex(line.get_color())  # the same axis
    assert bars.get_label() == "measured: x"
    assert_allclose(bars[0].get_ydata(), line.get_ydata()[9])
    assert chart.get_xlabel() == "phase [deg]"
    assert chart.get_ylabel() == "gain [dB]"
    assert nyquist.get_xlabel() == "real part [1]"
    ring = next(line for line in chart.get_lines() if "disk margin 0.50" in str(line.get_label()))
    assert ring.get_ydata().max() == pytest.approx(20.0 * np.log10(1.25 / 0.75), rel=1e-6)


def test_nichols_chart_without_loops_is_refused():
    with pytest.raises(ValueError, match="one loop at least"):
        nichols_chart([])


def test_a_line_does_not_run_across_the_chart_where_the_phase_wraps():
    angle = np.radians(np.linspace(-30.0, -400.0, 100))
    figure = nichols_chart([Curve(name="design: x", frequency=np.linspace(1.0, 2.0, 100), values=np.exp(1j * angle))])
    shown = np.asarray(figure.axes[0].get_lines()[0].get_xdata(), float)
    assert np.isnan(shown).sum() == 1
    assert np.nanmax(np.abs(np.diff(shown))) < 10.0


def test_sensitivity_figure_labels_its_peaks():
    frequency = np.array([1.0, 2.0, 4.0])
    figure = sensitivity_singular_values(frequency, np.array([1.0, 10.0, 1.0]), np.array([1.0, 0.5, 0.1]))
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert labels[0] == "largest singular value of S, peak 20.0 dB at 2.00 Hz"
    assert_allclose(figure.axes[0].get_lines()[0].get_ydata(), [0.0, 20.0, 0.0])
    assert figure.axes[0].get_xlabel() == "frequency [Hz]"


def test_tables_have_margins_with_units_and_uncertainties(content):
    assert exact_rows(content)[0] == ("delay", "3.783 ms")
    assert exact_rows(content)[2] == ("gain down", "none found")
    assert exact_rows(content)[4][1] == "3.784 ms, at 26.6 Hz (stable at 3.7, unstable at 3.8 ms)"
    design, measured, problem = margin_rows(content)
    assert design == ("design: all wheels", "+6.02 dB at 3 Hz", "60.0 deg at 1 Hz", "4.100 ms at 27 Hz",
                      "0.500 at 1.5 Hz", "")  # fmt: skip
    assert measured[0] == "measured: x"
    assert measured[3] == "<= 4.100 ± 0.020 ms at 27 Hz"  # crossings were left out
    assert measured[5] == "2"
    assert problem[1] == "only 0 of 9 lines are coherent"


def test_table_lists_the_lower_gain_margin_before_the_upper_one(content):
    content["analysis"]["margins"]["all wheels"] |= {"gain_down": 0.5, "gain_down_at": 0.2}
    content["analysis"]["exact"]["gain_down"] = 0.5
    assert margin_rows(content)[0][1] == "-6.02 dB at 0.2 Hz, +6.02 dB at 3 Hz"
    assert exact_rows(content)[2] == ("gain down", "-6.02 dB")


def test_the_report_shows_the_study_of_a_run(content, tmp_path):
    (tmp_path / FILE).write_text(json.dumps(content))
    run = Run(folder=tmp_path, configuration="centralised", slew=False, seed=1)
    blocks = section(run)
    assert [type(block) for block in blocks] == [Heading, Paragraph, Table, Table, Picture, Picture, Picture]
    assert set(margin_figures(content, COHERENT)) == {"nichols", "sensitivity", "coherence"}
    page = as_html([Heading(1, "page"), *blocks])
    assert page.count("<svg") == 3
    assert "<?xml" not in page


def test_report_of_a_run_without_a_study_has_the_delay_margin(recorded_runs):
    blocks = section(read_run(recorded_runs / "1"))
    assert "exact: 3.78 ms" in blocks[1].text
