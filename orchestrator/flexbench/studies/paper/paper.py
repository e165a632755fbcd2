"""The paper's study: six runs a variant and seed, in parallel processes, then table and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from flexsat.fmu.reproducible_zip import write_atomically
from flexsat.parameters import CONFIGURATIONS, ConfigurationName

from ...loop.scenarios import SCENARIOS, ScenarioName, scalar_overrides, scenario_parameters
from ...runs.jobs import Job, run_jobs
from .published import Variant
from .table import Key, Results, as_csv, as_json, as_markdown, as_text


def run_folder(folder: Path, variant: Variant, name: ConfigurationName, scenario: ScenarioName, seed: int) -> Path:
    """Return where one run of the study goes."""
    parts = [name, scenario.replace("_", "-"), *(["as-published"] if variant == "as_published" else []), f"seed{seed}"]
    return folder / "-".join(parts)


def plan_jobs(
    fmus: Path, folder: Path, variants: Sequence[Variant], seeds: Sequence[int], duration: float
) -> dict[tuple[Key, int], Job]:
    """Return every run of the study, by variant, configuration and scenario, and seed."""
    return {
        ((variant, name, scenario), seed): Job(
            system=fmus / name / f"{scenario}.ssd",
            folder=run_folder(folder, variant, name, scenario, seed),
            overrides=scalar_overrides(
                scenario_parameters(scenario, as_published=variant == "as_published", seed=seed)
            ),
            stop_time=duration,
        )
        for seed in seeds
        for variant in variants
        for scenario in SCENARIOS
        for name in reversed(CONFIGURATIONS)  # the longer runs first
    }


def run_paper(
    fmus: Path,
    folder: Path,
    variants: Sequence[Variant],
    seeds: Sequence[int],
    duration: float,
    processes: int | None = None,
) -> Results:
    """Run the study and leave table and runs in `folder`."""
    jobs = plan_jobs(fmus, folder, variants, seeds, duration)
    finished = run_jobs(list(jobs.values()), processes)
    metrics: dict[Key, list[Mapping[str, float]]] = {}
    for (key, _), done in zip(jobs, finished, strict=True):
        metrics.setdefault(key, []).append(done.metrics)
    results = Results(metrics=metrics, seeds=list(seeds), duration=duration)
    for name, content in (
        ("table.txt", as_text(results)),
        ("table.md", as_markdown(results)),
        ("table.csv", as_csv(results)),
        ("table.json", as_json(results)),
    ):
        write_atomically(folder / name, content.encode())
    return results


def one_seed_folders(folder: Path, variants: Sequence[Variant], seed: int) -> list[Path]:
    """Return the results folders of one seed's runs."""
    return [
        run_folder(folder, variant, name, scenario, seed)
        for variant in variants
        for scenario in SCENARIOS
        for name in CONFIGURATIONS
    ]
