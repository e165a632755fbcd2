"""Pointing error indices against closed forms, requirements, tables and the figure."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from flexbench.figures.budget import budget_figure
from flexbench.html.text_table import format_table
from flexbench.runs.run_folder import Run
from flexbench.studies.budget import ErrorHistory, IndexWindows, compute_budget, indices, judge, read_requirements
from flexbench.studies.budget.evaluate import since_default
from flexbench.studies.budget.split import OFF, SOURCES, plan_runs
from flexbench.studies.budget.tables import assessment_rows, notes, rows
from flexsat.parameters import ARCSECOND
from flexsat.runtime.rotations import error_angle, error_rotation
from lockstep import InputError

ROOT = Path(__file__).parents[4]
INTERVAL, AMPLITUDE = 0.005, 3.0
FEW_ULP = 1e-12  # of sums of thousands of numbers


def sine(period: float, duration: float, phase: float = 0.3) -> np.ndarray:
    """Return a sine of amplitude 3, sampled at the middle of each interval: its means are those of the samples."""
    time = (np.arange(round(duration / INTERVAL)) + 0.5) * INTERVAL
    return (AMPLITUDE * np.sin(2.0 * np.pi * time / period + phase))[:, None]


def dirichlet(window: float, period: float) -> float:
    """Return what a mean over a window leaves of the amplitude of a sampled sine, in closed form."""
    half, count = np.pi * INTERVAL / period, round(window / INTERVAL)
    return float(np.sin(count * half) / (count * np.sin(half)))


def test_absolute_error_of_a_sine_is_the_arc_sine_law():
    error = np.abs(sine(10.0, 100.0))[:, 0]
    for level in (0.5, 0.95, 0.9973):
        # the share of the time that |sin| stays below sin(pi p / 2) is p; 5 us of phase between neighbouring samples
        assert_allclose(indices.at_level(error, level), AMPLITUDE * np.sin(0.5 * np.pi * level), rtol=2e-3)


def test_mean_error_of_a_sine():
    window, period = 2.0, 7.0
    error = sine(period, 70.0)
    means = indices.window_means(error, round(window / INTERVAL))

    middle = (np.arange(35) + 0.5) * window
    expected = dirichlet(window, period) * AMPLITUDE * np.sin(2.0 * np.pi * middle / period + 0.3)
    assert_allclose(means[:, 0], expected, rtol=FEW_ULP, atol=FEW_ULP)


def test_relative_error_of_a_sine_over_whole_periods_is_the_sine():
    error = sine(2.0, 40.0)
    assert_allclose(indices.window_deviations(error, 400), error, atol=FEW_ULP)  # a window is a period
    assert_allclose(indices.window_means(error, 400), 0.0, atol=FEW_ULP)


@pytest.mark.parametrize("separation", [3.5, 7.0, 10.5])
def test_drift_of_a_sine(separation: float):
    """Twice the mean at half a period, nothing at a whole one."""
    window, period = 1.0, 7.0
    found = indices.drifts(sine(period, 70.0), 200, round(separation / INTERVAL))

    start = np.arange(len(found)) * window
    earlier, later = (
        dirichlet(window, period) * AMPLITUDE * np.sin(2.0 * np.pi * (start + shift + 0.5) / period + 0.3)
        for shift in (0.0, separation)
    )
    assert len(found) == int((70.0 - separation) / window)
    assert_allclose(found[:, 0], later - earlier, atol=FEW_ULP)
    worst = np.abs(found).max()
    assert worst < 1e-11 if separation == 7.0 else worst > 1.9 * dirichlet(window, period) * AMPLITUDE


def test_reproducibility_of_a_ramp_and_a_periodic_error():
    ramp = np.arange(6000.0)[:, None]
    found = indices.reproducibility(ramp, 100, 2000)
    # three observations of twenty windows: pairs one, one and two observations apart
    assert sorted(set(found[:, 0].tolist())) == [2000.0, 4000.0]
    assert len(found) == 60
    assert np.count_nonzero(found == 4000.0) == 20
    periodic = np.tile(np.arange(2000.0), 3)[:, None]
    assert not indices.reproducibility(periodic, 100, 2000).any()


def test_mean_and_deviation_divide_the_power():
    error = np.random.default_rng(1).standard_normal((9000, 3))
    means, deviations = indices.window_means(error, 300), indices.window_deviations(error, 300)
    assert_allclose(np.mean(means**2) + np.mean(deviations**2), np.mean(error**2), rtol=FEW_ULP)


def test_indices_of_band_limited_noise_follow_from_its_density():
    """MPE, RPE and PDE as filters on a density (ESSB-HB-E-003): sinc^2, 1 - sinc^2, and 4 sin^2 of the separation."""
    rng = np.random.default_rng(3)
    rows_, window, separation = 400_000, 200, 700
    frequency = np.fft.rfftfreq(rows_, INTERVAL)
    inside = (frequency > 0.2) & (frequency < 1.5)
    lines = inside * (rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency)))
    error = np.fft.irfft(lines, rows_)[:, None]
    density = 2.0 * np.mean(error**2) / np.count_nonzero(inside) * inside / 2.0  # mean power of a line
    angle = np.pi * frequency * INTERVAL
    with np.errstate(invalid="ignore"):
        kernel = np.nan_to_num(np.sin(window * angle) / (window * np.sin(angle)), nan=1.0) ** 2
    expected = {
        "MPE": np.sum(density * kernel),
        "RPE": np.sum(density * (1.0 - kernel)),
        "PDE": np.sum(density * kernel * 4.0 * np.sin(separation * angle) ** 2),
    }
    found = {
        "MPE": np.mean(indices.window_means(error, window) ** 2),
        "RPE": np.mean(indices.window_deviations(error, window) ** 2),
        "PDE": np.mean(indices.drifts(error, window, separation) ** 2),
    }
    for name in expected:  # 2000 windows: a variance is known to 1 / sqrt(1000), 3 %, and this is four times that
        assert_allclose(found[name], expected[name], rtol=0.12, err_msg=name)


def test_value_at_a_level_is_an_order_statistic():
    sizes = np.arange(1.0, 101.0)
    assert indices.at_level(sizes, 0.95) == 95.0
    assert indices.at_level(sizes, 0.9973) == 100.0  # too few for it: the largest


def test_normal_error_stays_within_two_and_three_sigma():
    history = ErrorHistory(error=np.random.default_rng(5).standard_normal((200_000, 3)), interval=0.01, start=0.0)
    entry = compute_budget(history, IndexWindows(), (0.9545, 0.9973)).entry("APE", "y")
    assert entry is not None
    # a quantile of 200000 values near three sigma is known to 1 %
    assert_allclose([entry.levels[0.9545], entry.levels[0.9973]], [2.0, 3.0], rtol=0.02)


def constant_history(duration: float = 150.0) -> ErrorHistory:
    """Return an error of 3, 4 and 12 arcsec about x, y, z."""
    rows_ = round(duration / 0.01)
    return ErrorHistory(error=np.tile([3.0, 4.0, 12.0], (rows_, 1)) * ARCSECOND, interval=0.01, start=150.0)


def test_axes_of_a_constant_error():
    budget = compute_budget(constant_history(), IndexWindows())
    expected = {"x": 3.0, "y": 4.0, "z": 12.0, "line_of_sight": 5.0, "angle": 13.0}
    for axis, size in expected.items():
        for index in ("APE", "MPE"):
            entry = budget.entry(index, axis)
            assert_allclose([entry.rms, *entry.levels.values()], size * ARCSECOND, rtol=1e-12)
        for index in ("RPE", "PDE", "PRE"):
            assert budget.entry(index, axis).rms < 1e-12 * ARCSECOND
    assert [row[0] for row in rows(budget)] == [
        index for index in ("APE", "MPE", "RPE", "PDE", "PRE") for _ in range(5)
    ]


def test_indices_that_a_run_is_too_short_for_are_listed():
    budget = compute_budget(constant_history(40.0), IndexWindows())
    assert budget.entry("PDE", "x") is None
    assert budget.entry("PRE", "x") is None
    text = "\n".join(notes(budget))
    assert "Too short for PDE, PRE" in text
    assert "fewer values" in text  # four windows are too few for 95 %


def test_error_rotation_agrees_with_scipy_and_with_the_angle():
    rng = np.random.default_rng(2)
    first, second = Rotation.random(50, rng=rng), Rotation.from_rotvec(1e-3 * rng.standard_normal((50, 3)))
    reference, turned = first.as_mrp(), (first * second).as_mrp()
    found = error_rotation(turned, reference)
    assert_allclose(found, second.as_rotvec(), rtol=1e-9, atol=1e-14)
    assert_allclose(np.linalg.norm(found, axis=1), error_angle(turned, reference), rtol=1e-12)
    assert_allclose(np.linalg.norm(error_rotation(reference, reference), axis=1), 0.0, atol=1e-15)
    # across half a turn, where the short rotations of the two have opposite signs
    across = [Rotation.from_rotvec([angle, 0.0, 0.0]).as_mrp()[None] for angle in (np.pi - 1e-3, np.pi + 1e-3)]
    assert_allclose(error_rotation(across[1], across[0]), [[2e-3, 0.0, 0.0]], atol=1e-12)


def test_bad_windows_levels_and_starts_are_refused():
    with pytest.raises(InputError, match=r"window 0\.0"):
        IndexWindows(window=0.0)
    with pytest.raises(InputError, match="observation 5 s: must hold a window of 10 s"):
        IndexWindows(observation=5.0)
    with pytest.raises(InputError, match=r"window 0\.015 s: must be a whole multiple of the record period"):
        compute_budget(constant_history(), IndexWindows(window=0.015))
    with pytest.raises(InputError, match=r"level 1\.0"):
        compute_budget(constant_history(), IndexWindows(), (1.0,))
    run = Run(folder=Path("there"), configuration="centralised", slew=False, seed=1)
    time = np.arange(2000) * 0.1
    assert since_default(run, time, None)[0] == 150.0
    assert since_default(run, time[:1000], None)[:2] == (pytest.approx(50.0), 500)
    with pytest.raises(InputError, match="--from 300"):
        since_default(run, time, 300.0)


LINE = '[[requirement]]\nname = "blur"\nindex = "RPE"\naxis = "x"\nlimit = 1.0\nunit = "arcsec"\n'


def test_requirements_pass_and_fail_at_their_limit(tmp_path: Path):
    path = tmp_path / "requirements.toml"
    lines = LINE.replace("RPE", "APE")
    path.write_text(lines.replace("1.0", "3.001") + lines.replace("1.0", "2.999") + lines.replace("arcsec", "urad"))

    assessments = [judge(constant_history(), requirement) for requirement in read_requirements(path)]

    assert [one.met for one in assessments] == [True, False, False]
    assert_allclose([one.value for one in assessments], [3.0, 3.0, 3e6 * ARCSECOND], rtol=1e-12)
    table = assessment_rows(assessments)
    assert [row[-1] for row in table] == ["pass", "FAIL", "FAIL"]
    assert len({len(line) for line in format_table(tuple("abcdefghi"), table).splitlines()[1:]}) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("limit = 1.0", "limit = -1.0"), "requirement 1: limit = -1.0: must be > 0"),
        (("limit = 1.0", "limit = true"), "limit = True: must be a number"),
        (("limit = 1.0\n", ""), "requirement 1: limit: missing"),
        (('"RPE"', '"REP"'), "index = 'REP': must be one of APE, MPE, RPE, PDE, PRE"),
        (('"x"', '"line of sight"'), "did you mean line_of_sight"),
        (('"arcsec"', '"arcsecs"'), "did you mean arcsec"),
        (("limit", "limits = 2.0\nlimit"), "limits: no such key"),
        (("limit", "separation = 2.0\nlimit"), "separation = 2.0: RPE has none; leave it out"),
        (("limit", "level = 95\nlimit"), "level = 95.0: must be between 0 and 1"),
        (("limit", "window = 0\nlimit"), "window 0.0: must be a time > 0 s"),
        (("[[requirement]]", "[requirement]"), "must be one or more [[requirement]] tables"),
        (("[[requirement]]", "[[requirements]]"), "requirements: no such key"),
        (("[[requirement]]", "[[requirement"), "no TOML"),
    ],
)
def test_bad_requirement_is_refused_with_key_value_and_remedy(tmp_path: Path, change: tuple[str, str], message: str):
    path = tmp_path / "requirements.toml"
    path.write_text(LINE.replace(*change))
    with pytest.raises(InputError, match=re.escape(message)) as refused:
        read_requirements(path)
    assert "\n" not in str(refused.value)
    assert str(path) in str(refused.value)


def test_requirement_that_a_run_is_too_short_for_is_refused(tmp_path: Path):
    path = tmp_path / "requirements.toml"
    path.write_text(LINE.replace("RPE", "PDE"))
    (requirement,) = read_requirements(path)
    with pytest.raises(InputError, match="'blur': PDE needs longer than the 40 s"):
        judge(constant_history(40.0), requirement)


def test_example_requirements_are_read():
    assert {r.index for r in read_requirements(ROOT / "examples" / "requirements.toml")} == {"APE", "RPE", "PDE", "PRE"}


def test_each_source_acts_in_all_and_in_its_own_run_only():
    runs = plan_runs()
    for source in SOURCES:
        for name in (*SOURCES, "none"):
            off = set(OFF[source]) <= set(runs[name])
            assert off == (name != source)
    assert runs["all"] == {}
    for one, other in pairwise(OFF.values()):
        assert not set(one) & set(other)


def test_figure_shows_errors_means_and_indices_in_arcsec():
    history = constant_history()
    figure = budget_figure(history, compute_budget(history, IndexWindows()))
    time, bars = figure.axes
    assert "[arcsec]" in time.get_ylabel()
    assert "[arcsec]" in bars.get_ylabel()
    assert [line.get_ydata()[0] for line in time.get_lines()] == pytest.approx([3.0, 4.0, 12.0])
    assert [text.get_text() for text in bars.get_xticklabels()] == ["APE", "MPE", "RPE", "PDE", "PRE"]
    heights = [patch.get_height() for patch in bars.patches]  # five indices an axis: x, y, z, line of sight
    assert heights[::5] == pytest.approx([3.0, 4.0, 12.0, 5.0])
    assert heights[1::5] == pytest.approx([3.0, 4.0, 12.0, 5.0])
