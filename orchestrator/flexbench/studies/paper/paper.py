"""The paper's study: six runs a variant and seed, in parallel processes, then table and figures."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName
from lockstep import InputError
from lockstep.results.read_run_record import read_run_record
from lockstep.whole_file import write_whole

from ...engine.jobs import Job, run_jobs
from ...loop.scenarios import SCENARIOS, ScenarioName, Value, scalar_overrides, scenario_parameters
from .published import FLOWN, VariantName
from .table import Failed, Key, Results, as_csv, as_json, as_markdown, as_text

LOST_BY = 20.0  # s: the published design is at the limits of the wheels within one


def run_folder(folder: Path, variant: VariantName, name: ConfigurationName, scenario: ScenarioName, seed: int) -> Path:
    """Return where one run of the study goes."""
    marks = [] if variant == "corrected" else [variant.replace("_", "-")]
    parts = [name, scenario.replace("_", "-"), *marks, f"seed{seed}"]
    return folder / "-".join(parts)


def plan_jobs(
    fmus: Path, folder: Path, variants: Sequence[VariantName], seeds: Sequence[int], duration: float
) -> dict[tuple[Key, int], Job]:
    """Return every run of the study, by variant, configuration and scenario, and seed."""
    return {
        ((variant, name, scenario), seed): Job(
            system=fmus / name / f"{scenario}.ssd",
            folder=run_folder(folder, variant, name, scenario, seed),
            overrides=run_overrides(scenario, variant, seed),
            stop_time=min(duration, LOST_BY) if variant == "published_design" else duration,
            metrics=variant != "published_design",
        )
        for seed in seeds
        for variant in variants
        for scenario in _scenarios(variant)
        for name in reversed(CONFIGURATIONS)  # the longer runs first
    }


def _scenarios(variant: VariantName) -> tuple[ScenarioName, ...]:
    return ("fine_pointing",) if variant == "published_design" else SCENARIOS


def run_overrides(scenario: ScenarioName, variant: VariantName, seed: int) -> dict[str, Value | str]:
    """Return what a run of the study sets."""
    set_by_scenario = scalar_overrides(scenario_parameters(scenario, FLOWN[variant], seed))
    design = {"controller.design": "published"} if variant == "published_design" else {}
    return {**set_by_scenario, **design}


def saturated_from(folder: Path) -> float | None:
    """Return from when on a wheel of a run is at its torque limit until the end [s]; None if it is not."""
    record, _ = read_run_record(folder)
    found = [one for one in record.get("found", ()) if one["event"] == "torque-saturation"]
    return next((float(one["first"]) for one in found if one.get("until_the_end")), None)


def has_begun(folder: Path, failure: str) -> bool:
    """Return whether a folder is what a failed run left, and not one of an earlier study that was not replaced."""
    try:
        record, _ = read_run_record(folder)
    except InputError:
        return False
    return record.get("status") != "completed" and str(record.get("reason", "")) in failure


def run_paper(
    fmus: Path,
    folder: Path,
    variants: Sequence[VariantName],
    seeds: Sequence[int],
    duration: float,
    processes: int | None = None,
) -> Results:
    """Run the study and leave table and runs in `folder`; runs that failed are marked, and do not stop the others."""
    jobs = plan_jobs(fmus, folder, variants, seeds, duration)
    finished = run_jobs(list(jobs.values()), processes, keep_all=True)
    metrics: dict[Key, list[Mapping[str, float]]] = {}
    lost: dict[ConfigurationName, list[float | None]] = {}
    failed = []
    for (key, seed), done in zip(jobs, finished, strict=True):
        if done.failure:
            cause, begun = " ".join(done.failure.split()), has_begun(done.job.folder, done.failure)
            failed.append(Failed(key=key, seed=seed, folder=done.job.folder, cause=cause, begun=begun))
        elif key[0] == "published_design":
            lost.setdefault(key[1], []).append(saturated_from(done.job.folder))
        else:
            metrics.setdefault(key, []).append(done.metrics)
    results = Results(metrics=metrics, seeds=list(seeds), duration=duration, lost=lost, failed=failed)
    for name, content in (
        ("table.txt", as_text(results)),
        ("table.md", as_markdown(results)),
        ("table.csv", as_csv(results)),
        ("table.json", as_json(results)),
    ):
        write_whole(folder / name, content.encode())
    return results


def failures_text(results: Results) -> list[str]:
    """Return one line about the runs that failed; none where all succeeded."""
    if not results.failed:
        return []
    runs = sum(map(len, [*results.metrics.values(), *results.lost.values()])) + len(results.failed)
    which = "; ".join(one.text for one in results.failed)
    return [f"{len(results.failed)} of {runs} runs failed, table and page have the others: {which}"]


def one_seed_folders(
    folder: Path, variants: Sequence[VariantName], seed: int, without: Collection[Path] = ()
) -> list[Path]:
    """Return the results folders of one seed's runs, without those that failed."""
    found = [
        run_folder(folder, variant, name, scenario, seed)
        for variant in variants
        if variant != "published_design"  # a limit cycle has nothing to compare
        for scenario in SCENARIOS
        for name in CONFIGURATIONS
    ]
    return [path for path in found if path not in without]
