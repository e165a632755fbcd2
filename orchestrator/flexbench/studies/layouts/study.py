"""Simulate all layouts of the wheels over the same dispersions, in parallel processes, and compare their numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from flexsat.parameters import DEFAULT_DESIGN, ConfigurationName
from lockstep import InputError, load_system
from lockstep.operating_system import available_cores
from lockstep.plan.plan import Plan

from ...engine.jobs import Job, run_jobs
from ...loop.feasibility import needs_of
from ...loop.fmu_choice import PrintLine, choose_fmus, silent
from ...loop.scenarios import ScenarioName, scalar_overrides, scenario_parameters
from ...loop.spacecraft import spacecraft_of
from ...runs.loop_monitor import NEEDED
from .outcome import measure
from .plan import Comparison, ComparisonPlan
from .result_file import write_result
from .wheels import wheels_of

AFTER = 5.0  # s from a slew's end to the end of its run, at least


def run_folder(folder: Path, name: ConfigurationName, scenario: ScenarioName, seed: int) -> Path:
    """Return where one run of the study goes."""
    return folder / f"{name}-{scenario.replace('_', '-')}-seed{seed}"


def plan_jobs(
    fmus: Path, folder: Path, plan: ComparisonPlan, native: bool = False
) -> dict[tuple[ConfigurationName, ScenarioName, int], Job]:
    """Return every run: a seed's layouts have the same errors, and one after the other."""
    jobs = {}
    for seed in plan.seeds:
        errors = plan.dispersion.draw(seed)
        for scenario, duration in plan.duration.items():
            for name in plan.layouts:
                parameters = scenario_parameters(scenario, seed=seed, slew=plan.slew)
                parameters["plant"] |= errors.parameters()
                jobs[name, scenario, seed] = Job(
                    system=fmus / name / f"{scenario}.ssd",
                    folder=run_folder(folder, name, scenario, seed),
                    overrides={**scalar_overrides(parameters), **plan.overrides},
                    stop_time=duration,
                    record=NEEDED,
                    metrics=False,
                    native=native,
                )
    return jobs


def run_layouts(
    fmus: Path,
    folder: Path,
    plan: ComparisonPlan,
    processes: int | None = None,
    report: PrintLine = silent,
    python: bool = False,
) -> Comparison:
    """Run the study; leave the runs, layouts.json, layouts.csv and layouts.txt in `folder`.

    Parameters
    ----------
    fmus : folder that `flexsat build` has written
    plan : what is simulated
    processes : at once; None for one a core
    report : called with the kind of the FMUs, the time that the runs take, and what the slews need
    python : simulate the FMUs in Python; else the native ones where they are built

    Raises
    ------
    InputError
        If a slew cannot be carried out, or its run ends too early after it.
    """
    systems = [load_system(fmus / name / f"{one}.ssd") for name in plan.layouts for one in plan.duration]
    chosen = choose_fmus(systems, python)  # of one kind for all layouts
    jobs = plan_jobs(fmus, folder, plan, chosen.native)
    needs: list[str] = []  # what is printed follows what is refused
    for name in plan.layouts:
        for scenario in plan.duration:
            check_slew(jobs[name, scenario, plan.seeds[0]], f"{name}: ", needs.append)
    for line in (chosen.text, plan.estimate(processes or len(available_cores()), chosen.native), *needs):
        report(line)
    finished = run_jobs(list(jobs.values()), processes, keep_failed=True)
    outcomes = [measure(done, *key, plan.band) for key, done in zip(jobs, finished, strict=True)]
    described = {
        name: spacecraft_of(name, fmus / name / "plant.fmu").configurations[DEFAULT_DESIGN] for name in plan.layouts
    }
    wheels = {}
    for (name, _, _), done in zip(jobs, finished, strict=True):
        if name not in wheels and not done.failure:
            wheels[name] = wheels_of(described[name].wheel_set, done.job.folder)
    result = Comparison(
        plan=plan,
        modes=tuple(one.modes.plant for one in described.values()),
        errors={seed: plan.dispersion.draw(seed) for seed in plan.seeds},
        outcomes=outcomes,
        wheels=wheels,
        fmus=chosen.kind,
    )
    write_result(result, folder)
    return result


def check_slew(job: Job, title: str, report: Callable[[str], None]) -> None:
    """Report what a run's slew needs; raise InputError if it cannot be carried out in it."""
    assert job.system is not None
    assert job.stop_time is not None
    needs = needs_of(Plan(load_system(job.system), job.stop_time, dict(job.overrides), job.record, None))
    if needs is None or not needs.angles:
        return
    objection = needs.objection()
    if objection is not None and needs.end <= job.stop_time:
        raise InputError(f"{title}{objection}")
    if needs.end + AFTER > job.stop_time:
        raise InputError(
            f"--stop-time {job.stop_time:g}: the slew ends at {needs.end:.4g} s, and what follows is evaluated;"
            f" give {needs.end + AFTER:.0f} or more"
        )
    report(title + needs.text())
