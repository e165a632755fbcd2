"""Estimator health: statistics against known noise, a filter with the right model, and replays of recorded runs."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from flexbench.figures.drawing import save_figure
from flexbench.figures.health import estimator_health
from flexbench.report.sections import health as report_section
from flexbench.report.sections.health import section
from flexbench.runs.run_folder import read_run
from flexbench.studies.health.analysis import SETTLED, analyse, measurement_groups, state_groups
from flexbench.studies.health.covariance import filter_covariance
from flexbench.studies.health.replay import Replay, mrp_error, replay
from flexbench.studies.health.statistics import autocorrelation, average, normalised, portmanteau, whiteness_bound
from flexbench.studies.health.study import run_health, table_rows, write_health
from flexsat.design.estimator import measurement_noise, process_covariance
from lockstep import InputError

FROM = 5.0  # s: half of a recorded run


@pytest.fixture(scope="module")
def design(built):
    """Return the published design, whose filter assumes the noise that there is."""
    return built["centralised"].published


@pytest.fixture(scope="module")
def replays(recorded_runs):
    """Return the replays of two recorded runs, by seed."""
    return {seed: replay(read_run(recorded_runs / str(seed))) for seed in (1, 2)}


@pytest.fixture(scope="module")
def health(replays, design):
    """Return the health of seed 1, judged from 5 s on."""
    return analyse({1: replays[1]}, design, FROM)


def test_vectors_normalised_by_their_covariance_are_white():
    generator = np.random.default_rng(1)
    factor = generator.normal(size=(4, 4)) + 3.0 * np.eye(4)
    vectors = generator.normal(size=(20_000, 4)) @ factor.T
    white = normalised(vectors, factor @ factor.T)
    assert np.cov(white.T) == pytest.approx(np.eye(4), abs=0.04)
    found = average(np.sum(white**2, axis=1), 4)
    assert found.low < found.value < found.high
    assert found.assessment == "consistent"


def test_bounds_of_an_average_are_those_of_chi_square():
    found = average(np.full(10, 3.0), 3)
    assert found.value == pytest.approx(1.0)
    assert (found.low, found.high) == pytest.approx((chi2.ppf(0.025, 30) / 30, chi2.ppf(0.975, 30) / 30))
    assert average(np.full(10, 9.0), 3).assessment == "optimistic: covariance underestimated"
    assert average(np.full(10, 0.3), 3).assessment == "conservative: covariance overestimated"


def test_white_noise_is_white_and_a_first_order_process_is_not():
    generator = np.random.default_rng(2)
    white = generator.normal(size=(4000, 200))
    found = autocorrelation(white, 20)
    assert np.mean(np.abs(found) > whiteness_bound(4000)) == pytest.approx(0.05, abs=0.01)
    assert np.mean(portmanteau(found, 4000) < 0.05) == pytest.approx(0.05, abs=0.04)
    coloured = np.zeros_like(white)
    for row in range(1, len(white)):
        coloured[row] = 0.6 * coloured[row - 1] + white[row]
    found = autocorrelation(coloured, 20)
    assert found[:3].mean(axis=1) == pytest.approx([0.6, 0.36, 0.216], abs=0.02)
    assert np.all(portmanteau(found, 4000) < 1e-6)


def test_the_portmanteau_of_few_samples_has_the_correction_of_ljung_and_box():
    found = portmanteau(np.array([[0.5], [0.25]]), 10)  # n (n + 2) (r1^2 / (n - 1) + r2^2 / (n - 2))
    assert found == pytest.approx([chi2.sf(120.0 * (0.25 / 9.0 + 0.0625 / 8.0), 2)], rel=1e-12)


@pytest.mark.parametrize("fine", [True, False])
def test_covariance_repeats_after_a_period_and_no_correction_enlarges_it(design, fine):
    covariances = filter_covariance(design, fine)
    estimator, config = design.fine if fine else design.coarse, design.config
    disturbance = process_covariance(
        design.model, config.wheel_set.broadband, config.weights.process_noise, config.rates.controller
    )
    again = estimator.a @ covariances.corrected[-1] @ estimator.a.T + disturbance
    scale = np.sqrt(np.diag(again))
    assert (again - covariances.predicted[0]) / np.outer(scale, scale) == pytest.approx(0.0, abs=1e-7)
    for before, after in zip(covariances.predicted, covariances.corrected, strict=True):
        assert np.all(np.diag(after) <= np.diag(before) * (1.0 + 1e-9))


def test_filter_with_the_right_model_is_consistent(design):
    """With truth from the filter's own model and noise NIS and NEES are one, and the innovations white."""
    estimator, config = design.coarse, design.config
    variance = measurement_noise(design.model, config.noise, config.noise.star_tracker_coarse)
    disturbance = process_covariance(
        design.model, config.wheel_set.broadband, config.weights.process_noise, config.rates.controller
    )
    covariances = filter_covariance(design, fine=False)
    replays = {}
    for seed in range(1, 5):
        replays[seed] = _linear_run(estimator, variance, disturbance, covariances, np.random.default_rng([seed, 9]))
    found = analyse(replays, design)
    for name, value in found.innovation.items():
        assert value.value == pytest.approx(1.0, abs=4.0 * (value.high - 1.0) / 1.96), name
    assert found.error["all"].low < found.error["all"].value < found.error["all"].high
    assert found.whiteness.outside == pytest.approx(0.05, abs=0.02)
    worse = {seed: replace(run, error=2.0 * run.error) for seed, run in replays.items()}
    assert analyse(worse, design).error["all"].value == pytest.approx(4.0 * found.error["all"].value)


def _linear_run(estimator, variance, disturbance, covariances, generator):
    steps, states = 2400, len(estimator.a)
    shake = np.linalg.cholesky(disturbance)
    error = np.linalg.cholesky(covariances.predicted[0]) @ generator.normal(size=states)
    innovations, errors, phases = [], [], []
    for step in range(steps):
        phase = step % len(estimator.gain)
        innovation = estimator.c @ -error + np.sqrt(variance) * generator.normal(size=len(variance))
        error = error + estimator.gain[phase] @ innovation
        innovations.append(innovation)
        errors.append(error[: covariances.controlled])
        phases.append(phase)
        error = estimator.a @ error + shake @ generator.normal(size=states)
    time = SETTLED + 0.005 * np.arange(steps)
    return Replay(
        time=time, phase=np.array(phases), innovation=np.array(innovations), error=np.array(errors), fine=False
    )


def test_groups_cover_each_measurement_and_state_once(design):
    measured = [i for part in measurement_groups(design).values() for i in range(part.start, part.stop)]
    assert measured == list(range(len(design.model.c)))
    groups = state_groups(design)
    whole = groups.pop("all")
    assert [i for part in groups.values() for i in range(part.start, part.stop)] == list(range(whole.stop))
    assert whole.stop == design.model.index.unfiltered


def test_replay_commands_the_torques_of_the_fmu(replays, design):
    found = replays[1]  # the replay raises if a torque differs
    assert set(np.flatnonzero(found.phase == 0) % 20) == {0}
    rate = slice(3 + design.spacecraft.mode_count, 6 + design.spacecraft.mode_count)
    assert 0.0 < np.sqrt(np.mean(found.error[-1000:, rate] ** 2)) < design.config.noise.gyro


def test_the_error_of_an_estimated_attitude_is_in_mrps_of_the_state():
    """That of the filter's state: near zero the difference, and elsewhere that of the turn between the two."""
    small = np.array([[1e-6, -2e-6, 3e-6]])
    assert mrp_error(small, np.zeros((1, 3))) == pytest.approx(small, rel=1e-9)
    truth = Rotation.from_rotvec([0.9, -0.4, 0.2])
    estimate = Rotation.from_mrp(small[0]) * truth
    found = np.linalg.norm(mrp_error(estimate.as_mrp()[None], truth.as_mrp()[None]))
    assert found == pytest.approx(np.linalg.norm(small), rel=1e-6)  # 1e-10 of an MRP is rounding of a large one


def test_replay_with_other_parameters_is_refused(recorded_runs, tmp_path):
    for name in ("signals.parquet", "run.toml"):
        (tmp_path / name).write_bytes((recorded_runs / "1" / name).read_bytes())
    text = (tmp_path / "run.toml").read_text()
    assert '"jitter.feed_forward" = true' in text
    (tmp_path / "run.toml").write_text(text.replace('"jitter.feed_forward" = true', '"jitter.feed_forward" = false'))
    with pytest.raises(InputError, match="commands other torques than the FMU did"):
        replay(read_run(tmp_path))


def test_filter_is_consistent_in_encoders_and_conservative_in_the_rest(replays, design):
    """Its process noise is that of the release, in coordinates where it exceeds the noise of the accelerometers."""
    found = analyse(replays, design, FROM)
    assert found.innovation["encoders"].value == pytest.approx(1.0, abs=0.02)
    assert found.innovation["accelerometers"].value < 1e-6
    assert found.error["all"].value < found.error["all"].low


def test_file_and_report_show_the_same_numbers(recorded_runs, health, tmp_path, monkeypatch):
    run = read_run(recorded_runs / "1")
    write_health(health, tmp_path, "native")
    written = json.loads((tmp_path / "health.json").read_text())
    assert [written[name] for name in ("seeds", "settled_from", "configuration", "fmus")] == [
        [1],
        FROM,
        "centralised",
        "native",
    ]
    assert written["nis"]["gyros"]["average"] == health.innovation["gyros"].value
    monkeypatch.setattr(report_section, "analyse", lambda *_: health)
    assert section(run)[2].rows == table_rows(health)
    assert "from 5 s on" in section(run)[1].text


def test_report_of_a_run_that_cannot_be_judged_gives_the_reason(recorded_runs, tmp_path):
    short = section(read_run(recorded_runs / "1"))
    assert "the run ends at 9.995 s, and the filter is judged from 20 s on" in short[1].text
    (tmp_path / "run.toml").write_bytes((recorded_runs / "1" / "run.toml").read_bytes())
    table = pq.read_table(recorded_runs / "1" / "signals.parquet")
    pq.write_table(table.select([name for name in table.column_names if not name.startswith("sensors.")]),
                   tmp_path / "signals.parquet")  # fmt: skip
    assert "were not recorded" in section(read_run(tmp_path))[1].text


def test_run_that_ends_before_the_filter_has_settled_is_refused(replays, design):
    with pytest.raises(InputError, match=r"the run ends at 9\.995 s, and the filter is judged from 20 s on"):
        analyse({1: replays[1]}, design)
    with pytest.raises(InputError, match=r"judged from 8 s on; simulate more than 10 s"):
        analyse({1: replays[1]}, design, 8.0)


def test_figure_shows_values_and_bounds(health, tmp_path):
    figure = estimator_health(health)
    panels = figure.axes
    marks = [line for line in panels[1].lines if line.get_marker() in "oD"]
    assert [line.get_xdata()[0] for line in marks] == [max(a.value, 1e-3) for a in health.error.values()]
    assert [text.get_text() for text in panels[1].get_yticklabels()] == list(health.error)
    assert panels[2].get_xlabel() == "time [s]"
    assert figure.get_suptitle() == "centralised, seed 1"
    svg = save_figure(figure, tmp_path, "estimator-health")[1]
    assert svg.stat().st_size > 1000


def test_a_seed_that_the_study_sets_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("flexbench.studies.health.study.load_system", lambda _: None)
    with pytest.raises(InputError, match=r"--set plant\.seed=7: each run has a seed of its own; give --seeds N"):
        run_health(tmp_path / "loop.ssd", tmp_path, range(1, 3), 100.0, {"plant.seed": "7"}, 1)
