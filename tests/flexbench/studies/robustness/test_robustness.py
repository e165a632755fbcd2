"""Robustness to modal-frequency errors: the errors drawn, their effect on the plant, and unstable loops."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexbench.runs.run_folder import Run, read_run
from flexbench.studies.robustness.frequency_errors import frequency_errors, judge, run_robustness, table_rows
from lockstep import InputError, Signals, load_system, simulate


@pytest.fixture
def fmus(delivered):
    return delivered


def test_errors_are_shifts_or_draws_of_the_level():
    assert frequency_errors("all lower", 0.05, 1, 3).tolist() == [-0.05] * 3
    assert frequency_errors("nominal", 0.05, 1, 2).tolist() == [0.0, 0.0]
    drawn = np.concatenate([frequency_errors("random", 0.02, seed, 25) for seed in range(200)])
    assert np.std(drawn) == pytest.approx(0.02, rel=0.03)
    assert np.array_equal(frequency_errors("random", 0.02, 7, 25), frequency_errors("random", 0.02, 7, 25))
    with pytest.raises(ValueError, match="'sideways': no such kind"):
        frequency_errors("sideways", 0.1, 1, 2)


@pytest.mark.slow
def test_centralised_loop_is_stable_with_five_per_cent_errors(fmus, tmp_path):
    outcomes = run_robustness(fmus, tmp_path, ("centralised",), "fine_pointing", (0.05,), (1,), 30.0, 25, processes=1)
    assert [(o.kind, o.stable) for o in outcomes] == [
        ("nominal", True),
        ("all higher", True),
        ("all lower", True),
        ("random", True),
    ]
    assert len({o.deformation for o in outcomes}) == 4  # the errors reach the plant
    assert [row[3] for row in table_rows(outcomes)] == ["0"] * 4
    assert len(json.loads((tmp_path / "robustness.json").read_text())) == 4


def test_loop_beyond_its_delay_margin_is_unstable(fmus, tmp_path):
    system = load_system(fmus / "centralised" / "fine_pointing.ssd").with_delay("controller", "plant", 10)
    values = scalar_overrides(scenario_parameters("fine_pointing", seed=1))
    simulate(system, tmp_path / "run", stop_time=8.0, overrides=values)  # it reaches its limit cycle in 3 s
    run = read_run(tmp_path / "run")
    assert not judge(run, run.signals(), "nominal", 0.0).stable


def test_recorded_run_is_stable(recorded_runs):
    run = read_run(recorded_runs / "1")
    outcome = judge(run, run.signals(), "nominal", 0.0)
    assert outcome.stable
    assert outcome.growth < 1.5


def made_run(torque):
    """Return a run without motion whose only wheel has this torque [N.m] over time."""
    zero = np.zeros(len(torque))
    columns = {"controller.wheel.torque[1]": torque, "plant.rms_deformation": zero}
    for name in ("plant.attitude.mrp", "controller.reference.mrp"):
        columns |= {f"{name}[{axis}]": zero for axis in (1, 2, 3)}
    signals = Signals(time=0.005 * np.arange(len(torque)), columns=columns, units={}, descriptions={})
    return Run(folder=Path(), configuration="centralised", as_published=False, slew=False, seed=1), signals


@pytest.mark.parametrize(
    ("growth", "last", "stable"),
    [(1.9, 0.5, True), (2.1, 0.5, False), (30.0, 0.5, False), (1.0, 4.9, True), (1.0, 5.1, False)],
)
def test_torque_that_grows_or_is_a_limit_cycle_is_unstable(growth, last, stable):
    """Limits: twice the torque of the third quarter, and 5 N.m."""
    torque = np.repeat([0.1, 0.1, last / growth, last], 100) * np.tile([1.0, -1.0], 200)
    outcome = judge(*made_run(torque), "nominal", 0.0)

    assert outcome.stable == stable
    assert (outcome.torque, outcome.growth) == pytest.approx((last, growth))


@pytest.mark.parametrize(
    ("levels", "stop", "message"), [((0.7,), 20.0, "--levels 70"), ((0.01,), 1.0, "--stop-time 1: quarters")]
)
def test_bad_levels_and_stop_times_are_refused_before_anything_runs(tmp_path, levels, stop, message):
    with pytest.raises(InputError, match=message):
        run_robustness(tmp_path, tmp_path / "out", ("centralised",), "slew", levels, (1,), stop, 25)
    assert not (tmp_path / "out").exists()
