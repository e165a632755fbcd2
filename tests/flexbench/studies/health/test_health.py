"""Estimator health: statistics against known noise, the belief against a filter that is right, real runs replayed."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from flexbench.figures.drawing import save_figure
from flexbench.figures.health import estimator_health
from flexbench.loop.build import build_all
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexbench.report.sections.health import section
from flexbench.runs.run_folder import read_run
from flexbench.studies.health.analysis import SETTLED, analyse, measurement_groups, state_groups
from flexbench.studies.health.covariance import belief
from flexbench.studies.health.replay import MEASURED, Replay, replay
from flexbench.studies.health.statistics import autocorrelation, average, normalised, portmanteau, whiteness_bound
from flexbench.studies.health.study import table_rows, write_health
from flexsat.design.chain import build_designs
from flexsat.design.estimator import measurement_noise, process_covariance
from lockstep import InputError, load_system, simulate


@pytest.fixture(scope="module")
def design():
    return build_designs("centralised").corrected


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return 26 s of centralised fine pointing with two seeds, measurements recorded, and one run without them."""
    folder = tmp_path_factory.mktemp("health")
    build_all(("centralised",), folder / "fmus", lambda _: None)
    system = load_system(folder / "fmus" / "centralised" / "fine_pointing.ssd")
    for name, seed, record, stop in (
        ("1", 1, (*system.record, *MEASURED), 26.0),
        ("2", 2, (*system.record, *MEASURED), 26.0),
        ("bare", 1, None, 1.0),
    ):
        simulate(
            system,
            folder / name,
            stop_time=stop,
            record=record,
            overrides=scalar_overrides(scenario_parameters("fine_pointing", seed=seed)),
        )
    return folder


def test_normalised_vectors_of_their_own_covariance_are_white():
    generator = np.random.default_rng(1)
    factor = generator.normal(size=(4, 4)) + 3.0 * np.eye(4)
    vectors = generator.normal(size=(20_000, 4)) @ factor.T
    white = normalised(vectors, factor @ factor.T)
    assert np.cov(white.T) == pytest.approx(np.eye(4), abs=0.04)
    found = average(np.sum(white**2, axis=1), 4)
    assert found.low < found.value < found.high
    assert found.verdict == "consistent"


def test_the_bounds_of_an_average_are_those_of_chi_square():
    found = average(np.full(10, 3.0), 3)
    assert found.value == pytest.approx(1.0)
    assert (found.low, found.high) == pytest.approx((chi2.ppf(0.025, 30) / 30, chi2.ppf(0.975, 30) / 30))
    assert "optimistic" in average(np.full(10, 9.0), 3).verdict
    assert "cautious" in average(np.full(10, 0.3), 3).verdict


def test_white_noise_is_found_white_and_a_first_order_process_is_not():
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


@pytest.mark.parametrize("fine", [True, False])
def test_the_belief_returns_after_a_period_and_correcting_never_loses(design, fine):
    believed = belief(design, fine)
    estimator, config = design.fine if fine else design.coarse, design.config
    disturbance = process_covariance(design.model, config.wheel, config.weights.process_noise, config.rates.controller)
    again = estimator.a @ believed.corrected[-1] @ estimator.a.T + disturbance
    scale = np.sqrt(np.diag(again))
    assert (again - believed.predicted[0]) / np.outer(scale, scale) == pytest.approx(0.0, abs=1e-7)
    for before, after in zip(believed.predicted, believed.corrected, strict=True):
        assert np.all(np.diag(after) <= np.diag(before) * (1.0 + 1e-9))


def test_a_filter_that_is_right_is_found_consistent(design):
    """Truth from the filter's own model and noise: NIS and NEES must come out at one, innovations white."""
    estimator, config = design.coarse, design.config
    variance = measurement_noise(design.model, config.noise, config.noise.star_tracker_coarse)
    disturbance = process_covariance(design.model, config.wheel, config.weights.process_noise, config.rates.controller)
    believed = belief(design, fine=False)
    replays = {}
    for seed in range(1, 5):
        replays[seed] = _linear_run(estimator, variance, disturbance, believed, np.random.default_rng([seed, 9]))
    found = analyse(replays, design)
    for name, value in found.innovation.items():
        assert value.value == pytest.approx(1.0, abs=4.0 * (value.high - 1.0) / 1.96), name
    assert found.error["all"].low < found.error["all"].value < found.error["all"].high
    assert found.whiteness.outside == pytest.approx(0.05, abs=0.02)
    worse = {seed: replace(run, error=2.0 * run.error) for seed, run in replays.items()}
    assert analyse(worse, design).error["all"].value == pytest.approx(4.0 * found.error["all"].value)


def _linear_run(estimator, variance, disturbance, believed, generator):
    steps, states = 2400, len(estimator.a)
    shake = np.linalg.cholesky(disturbance)
    error = np.linalg.cholesky(believed.predicted[0]) @ generator.normal(size=states)
    innovations, errors, phases = [], [], []
    for step in range(steps):
        phase = step % len(estimator.gain)
        innovation = estimator.c @ -error + np.sqrt(variance) * generator.normal(size=len(variance))
        error = error + estimator.gain[phase] @ innovation
        innovations.append(innovation)
        errors.append(error[: believed.controlled])
        phases.append(phase)
        error = estimator.a @ error + shake @ generator.normal(size=states)
    time = SETTLED + 0.005 * np.arange(steps)
    return Replay(
        time=time, phase=np.array(phases), innovation=np.array(innovations), error=np.array(errors), fine=False
    )


def test_groups_cover_everything_once(design):
    measured = [i for part in measurement_groups(design).values() for i in range(part.start, part.stop)]
    assert measured == list(range(len(design.model.c)))
    groups = state_groups(design)
    whole = groups.pop("all")
    assert [i for part in groups.values() for i in range(part.start, part.stop)] == list(range(whole.stop))
    assert whole.stop == design.model.index.unfiltered


def test_a_replay_commands_what_the_fmu_commanded(runs):
    run = read_run(runs / "1")
    found = replay(run)  # raises if a torque differs
    assert set(np.flatnonzero(found.phase == 0) % 20) == {0}
    rate = slice(3 + run.design.spacecraft.mode_count, 6 + run.design.spacecraft.mode_count)
    assert 0.0 < np.sqrt(np.mean(found.error[-1000:, rate] ** 2)) < run.design.config.noise.gyro


def test_a_replay_of_other_parameters_is_refused(runs, tmp_path):
    for name in ("signals.parquet", "run.toml"):
        (tmp_path / name).write_bytes((runs / "1" / name).read_bytes())
    text = (tmp_path / "run.toml").read_text()
    assert '"jitter.feed_forward" = true' in text
    (tmp_path / "run.toml").write_text(text.replace('"jitter.feed_forward" = true', '"jitter.feed_forward" = false'))
    with pytest.raises(InputError, match="commands other torques than the FMU did"):
        replay(read_run(tmp_path))


def test_the_real_filter_is_right_about_encoders_and_cautious_about_the_rest(runs):
    """Its process noise is that of the release, in coordinates where it drowns the accelerometers."""
    found = analyse({seed: replay(read_run(runs / str(seed))) for seed in (1, 2)}, read_run(runs / "1").design)
    assert found.innovation["encoders"].value == pytest.approx(1.0, abs=0.02)
    assert found.innovation["accelerometers"].value < 1e-6
    assert found.error["all"].value < found.error["all"].low


def test_results_and_section_tell_the_same(runs, tmp_path):
    run = read_run(runs / "1")
    found = analyse({1: replay(run)}, run.design)
    write_health(found, tmp_path)
    told = json.loads((tmp_path / "health.json").read_text())
    assert told["seeds"] == [1]
    assert told["nis"]["gyros"]["average"] == found.innovation["gyros"].value
    svg = save_figure(estimator_health(found), tmp_path / "figures", "estimator-health")[1]
    assert svg.stat().st_size > 1000
    assert section(run)[2].rows == table_rows(found)
    assert "were not recorded" in section(read_run(runs / "bare"))[1].text


def test_a_run_that_ends_too_soon_is_refused(runs):
    run = read_run(runs / "1")
    whole = replay(run)
    early = whole.time < SETTLED + 1.0
    cut = {name: getattr(whole, name)[early] for name in ("time", "phase", "innovation", "error")}
    with pytest.raises(InputError, match=r"the run ends at 20\.995 s, and the filter is judged from 20 s on"):
        analyse({1: replace(whole, **cut)}, run.design)


def test_the_figure_shows_values_and_bounds(runs):
    run = read_run(runs / "1")
    found = analyse({1: replay(run)}, run.design)
    panels = estimator_health(found).axes
    marks = [line for line in panels[1].lines if line.get_marker() in "oD"]
    assert [line.get_xdata()[0] for line in marks] == [max(a.value, 1e-3) for a in found.error.values()]
    assert [text.get_text() for text in panels[1].get_yticklabels()] == list(found.error)
    assert panels[2].get_xlabel() == "time [s]"
    assert panels[3].lines[0].get_ydata() == pytest.approx(np.median(found.whiteness.correlation, axis=1))
