"""The errors drawn for the layouts: the same for both, within their limits, others for another seed."""

from pathlib import Path

import numpy as np
import pytest

from flexbench.studies.layouts.dispersions import Dispersion, dispersion_of
from flexbench.studies.layouts.plan import ComparisonPlan
from flexbench.studies.layouts.study import plan_jobs
from flexsat.description.built_in import CONFIGURATIONS
from lockstep import InputError


def drawn(job):
    """Return the errors that a job gives its plant."""
    return {name: value for name, value in job.overrides.items() if name.startswith("plant.dispersion.")}


def test_both_layouts_of_a_seed_have_the_same_errors_and_seed_in_both_scenarios():
    jobs = plan_jobs(Path("fmus"), Path("out"), ComparisonPlan(seeds=(1, 2, 3)))
    by_seed = {seed: [job for (_, _, s), job in jobs.items() if s == seed] for seed in (1, 2, 3)}

    assert [len(of) for of in by_seed.values()] == [4, 4, 4]
    for seed, of in by_seed.items():
        assert {len(drawn(job)) for job in of} == {6}  # frequency, damping, participation, three moments of inertia
        assert all(drawn(job) == drawn(of[0]) for job in of)
        assert {job.overrides[f"{part}.seed"] for job in of for part in ("plant", "sensors")} == {seed}
    assert drawn(by_seed[1][0]) != drawn(by_seed[2][0])
    assert len({job.folder for job in jobs.values()}) == 12
    assert {job.system.parent.name for job in jobs.values()} == set(CONFIGURATIONS)


def test_errors_are_uniform_within_their_limits():
    """The mean of 2000 uniform draws scatters by 1.3 % of the limit, their standard deviation by 1.0 %."""
    errors = [Dispersion(frequency=0.02, damping=0.3, inertia=0.1).draw(seed) for seed in range(2000)]
    columns = {0.02: [e.frequency for e in errors], 0.3: [e.damping for e in errors]}
    columns |= {0.1: [e.inertia[0] for e in errors]}
    for limit, values in columns.items():
        assert np.max(np.abs(values)) <= limit
        assert np.mean(values) == pytest.approx(0.0, abs=0.05 * limit)
        assert np.std(values) == pytest.approx(limit / np.sqrt(3.0), rel=0.04)
    together = np.corrcoef([[e.frequency, e.damping, *e.inertia] for e in errors], rowvar=False)
    assert np.max(np.abs(together - np.eye(5))) < 0.1  # they are independent


def test_with_less_inertia_the_modes_carry_less_of_it():
    for seed in range(20):
        errors = Dispersion().draw(seed)
        least = min(errors.inertia)
        assert errors.participation == pytest.approx(np.sqrt(1.0 + least) - 1.0 if least < 0.0 else 0.0, abs=1e-15)


def test_limits_are_given_in_percent_and_checked():
    assert dispersion_of({}) == Dispersion(frequency=0.05, damping=0.5, inertia=0.1)
    assert dispersion_of({"frequency": 2.0, "inertia": 0.0}) == Dispersion(frequency=0.02, damping=0.5, inertia=0.0)
    with pytest.raises(InputError, match="--dispersion stiffness: no such error; there are frequency, damping, iner"):
        dispersion_of({"stiffness": 1.0})
    for name, value, most in (("frequency", 60.0, 50), ("damping", 120.0, 100), ("inertia", -1.0, 50)):
        with pytest.raises(InputError, match=rf"--dispersion {name}={value:g}: must be a percentage from 0 to {most}"):
            dispersion_of({name: value})


def test_plans_that_show_nothing_are_refused():
    with pytest.raises(InputError, match="--seeds 1: an interval needs 2 or more"):
        ComparisonPlan(seeds=(1,))
    with pytest.raises(InputError, match="--scenario rest: no such scenario; there are fine_pointing, slew"):
        ComparisonPlan(seeds=(1, 2), duration={"rest": 5.0})


def test_the_time_that_runs_take_is_estimated():
    plan = ComparisonPlan(seeds=range(1, 9), duration={"fine_pointing": 200.0, "slew": 100.0})
    assert plan.estimate(2) == "32 runs, 4800 s to simulate: about 8 min with 2 at once, at 5 x real time each"
