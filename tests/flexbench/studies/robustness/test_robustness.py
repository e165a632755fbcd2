"""Robustness to errors of the plant: the errors drawn, their effect on the plant, and unstable loops."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.loop.native_fmus import with_native_fmus
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexbench.runs.run_folder import Run, read_run
from flexbench.studies.robustness.model_errors import Variation, VariationPlan, judge, run_robustness, table_rows
from flexsat.closed_loop import port_values
from flexsat.parameters import ALL_MODES
from flexsat.ports.plant import parameters, ports, simulated
from flexsat.runtime.plant_parameters import lowest_modes
from flexsat.runtime.prepared_plant import prepare_motion
from flexsat.spacecraft.variation import dispersed
from lockstep import InputError, Signals, load_system, simulate


@pytest.fixture
def fmus(delivered):
    return delivered


@pytest.fixture
def centralised(designs):
    return designs["centralised"]


def drawn(what, kind, level, seed, modes):
    return np.array(Variation(what=what, kind=kind, level=level).parameters(seed, modes)[f"dispersion.{what}"])


def test_errors_are_shifts_or_draws_of_the_level():
    assert drawn("frequency", "all lower", 0.05, 1, 3).tolist() == [-0.05] * 3
    assert drawn("damping", "all higher", 0.5, 1, 2).tolist() == [0.5] * 2
    assert Variation().parameters(1, 2) == {}
    assert Variation(what="modes", level=28).parameters(1, 198) == {"modes": 28}
    many = np.concatenate([drawn("frequency", "random", 0.02, seed, 25) for seed in range(200)])
    assert np.std(many) == pytest.approx(0.02, rel=0.03)
    assert np.array_equal(drawn("frequency", "random", 0.02, 7, 25), drawn("frequency", "random", 0.02, 7, 25))
    assert np.all(drawn("participation", "random lower", 0.1, 3, 25) < 0.0)


def test_each_error_reaches_the_plant(centralised):
    """As FMUs have them: every error of the default plan gives a plant that can move, and another one."""
    matrices, plan = lowest_modes(centralised.plant, 40), VariationPlan(modes=(10, 20, 30))
    seen = set()
    for variation in plan.variations():
        values = port_values("plant", ports(matrices), variation.parameters(3, matrices.modes))
        chosen = simulated(matrices, values.__getitem__)
        motion = prepare_motion(chosen, parameters(chosen, values.__getitem__))
        if variation.what == "inertia" and variation.kind == "all lower":
            assert_allclose(np.diag(motion.mass)[3:6], 0.9 * np.diag(matrices.mass_matrix)[3:6], rtol=1e-12)
        seen.add((motion.mass.tobytes(), motion.stiffness.tobytes(), motion.free.velocity.tobytes()))
    assert len(seen) == len(list(plan.variations())) == 1 + 9 + 3 + 3 + 2 + 3


def test_participation_is_that_of_the_linear_model(centralised):
    errors = np.linspace(-0.3, 0.0, centralised.plant.modes)
    none = np.zeros(centralised.plant.modes)
    given = {"dispersion.participation": errors}
    values = port_values("plant", ports(centralised.plant), given)
    mass = prepare_motion(centralised.plant, parameters(centralised.plant, values.__getitem__)).mass
    expected = dispersed(centralised.structure, none, none, np.zeros(3), errors)
    assert_allclose(mass, expected.mass_matrix, rtol=1e-14, atol=1e-9)
    values["dispersion.participation"] = none + 0.1
    more = parameters(centralised.plant, values.__getitem__)
    with pytest.raises(ValueError, match=r"dispersion\.participation up to 0\.1, .* not positive definite"):
        prepare_motion(centralised.plant, more)


@pytest.mark.slow
def test_centralised_loop_is_stable_with_five_per_cent_errors(fmus, tmp_path):
    plan = VariationPlan(levels={"frequency": (0.05,)}, modes=())
    outcomes = run_robustness(fmus, tmp_path, ("centralised",), "fine_pointing", plan, (1,), 30.0, ALL_MODES, 1)
    assert [(o.kind, o.stable) for o in outcomes] == [
        ("", True),
        ("all higher", True),
        ("all lower", True),
        ("random", True),
    ]
    assert len({o.deformation for o in outcomes}) == 4  # the errors reach the plant
    assert [row[3] for row in table_rows(outcomes)] == ["0"] * 4
    assert len(json.loads((tmp_path / "robustness.json").read_text())) == 4


def test_loop_beyond_its_delay_margin_is_unstable(fmus, tmp_path):
    system = with_native_fmus(load_system(fmus / "centralised" / "fine_pointing.ssd"))
    system = system.with_delay("controller", "plant", 10)
    values = scalar_overrides(scenario_parameters("fine_pointing", seed=1))
    values |= {"controller.design": "published", "plant.modes": 25}  # its margin is 3.8 ms
    simulate(system, tmp_path / "run", stop_time=8.0, overrides=values)  # it reaches its limit cycle in 3 s
    run = read_run(tmp_path / "run")
    assert not judge(run, run.signals(), Variation()).stable


def test_recorded_run_is_stable(recorded_runs):
    run = read_run(recorded_runs / "1")
    outcome = judge(run, run.signals(), Variation())
    assert outcome.stable
    assert outcome.growth < 1.5


def made_run(torque):
    """Return a run without motion whose only wheel has this torque [N.m] over time."""
    zero = np.zeros(len(torque))
    columns = {"controller.wheel.torque[1]": torque, "plant.rms_deformation": zero}
    for name in ("plant.attitude.mrp", "controller.reference.mrp"):
        columns |= {f"{name}[{axis}]": zero for axis in (1, 2, 3)}
    signals = Signals(time=0.005 * np.arange(len(torque)), columns=columns, units={}, descriptions={})
    return Run(folder=Path(), configuration="centralised", slew=False, seed=1), signals


@pytest.mark.parametrize(
    ("growth", "last", "stable"),
    [(1.9, 0.5, True), (2.1, 0.5, False), (30.0, 0.5, False), (1.0, 4.9, True), (1.0, 5.1, False)],
)
def test_torque_that_grows_or_is_a_limit_cycle_is_unstable(growth, last, stable):
    """Limits: twice the torque of the third quarter, and 5 N.m."""
    torque = np.repeat([0.1, 0.1, last / growth, last], 100) * np.tile([1.0, -1.0], 200)
    outcome = judge(*made_run(torque), Variation())

    assert outcome.stable == stable
    assert (outcome.torque, outcome.growth) == pytest.approx((last, growth))


@pytest.mark.parametrize(
    ("plan", "stop", "message"),
    [
        ({"levels": {"frequency": (0.7,)}}, 20.0, "--levels 70: must be a percentage above 0, at most 50"),
        ({"levels": {"damping": (1.2,)}}, 20.0, "--damping 120: must be a percentage above 0, at most 100"),
        ({"modes": (25, 300)}, 20.0, "--modes 300: must be from 1 to 198"),
        ({}, 1.0, "--stop-time 1: quarters"),
    ],
)
def test_bad_levels_and_stop_times_are_refused_before_anything_runs(tmp_path, plan, stop, message):
    with pytest.raises(InputError, match=message):
        run_robustness(
            tmp_path, tmp_path / "out", ("centralised",), "slew", VariationPlan(**plan), (1,), stop, ALL_MODES
        )
    assert not (tmp_path / "out").exists()
