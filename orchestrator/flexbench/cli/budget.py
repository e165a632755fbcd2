"""`flexsat budget`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lockstep import InputError, load_system

from ..html.text_table import format_table
from ..runs.run_folder import read_run
from ..studies.budget import split as split_study
from ..studies.budget import tables
from ..studies.budget.evaluate import LEVELS, Windows, compute_budget, steady_error
from ..studies.budget.requirements import judge, read_requirements
from ..studies.budget.result_file import write_budget


def budget(options: argparse.Namespace) -> int:
    """Print and leave the budget of results, or of sources one at a time; exit code 1 if a requirement fails."""
    windows = Windows(window=options.window, separation=options.separation, observation=options.observation)
    levels = tuple(options.level or LEVELS)
    if options.split is not None:
        if options.results or options.requirements:
            raise InputError(
                "--split: takes neither results nor --requirements; run `flexsat budget` on one of its runs"
            )
        return _split(options, windows, levels)
    if not options.results:
        raise InputError("RESULTS: missing; give folders of runs, or --split SYSTEM")
    requirements = read_requirements(options.requirements) if options.requirements else []
    failed = 0
    for folder in options.results:
        run = read_run(folder)
        history = steady_error(run, options.since)
        found = compute_budget(history, windows, levels)
        assessments = [judge(history, requirement) for requirement in requirements]
        failed += sum(not one.met for one in assessments)
        path = write_budget(found, assessments, run, options.requirements)
        from ..figures import save_figure
        from ..figures.budget import budget_figure

        save_figure(budget_figure(history, found), folder / "figures", "budget")
        print(f"{run.configuration}, seed {run.seed}: {folder}")
        print(format_table(tables.header(found), tables.rows(found)))
        print("\n".join(tables.notes(found)))
        if assessments:
            print(format_table(tables.ASSESSMENTS, tables.assessment_rows(assessments), left=3))
        print(path)
    if failed:
        print(f"flexsat: {failed} of {len(requirements) * len(options.results)} requirements fail", file=sys.stderr)
    return 1 if failed else 0


def _split(options: argparse.Namespace, windows: Windows, levels: tuple[float, ...]) -> int:
    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"--jobs {options.jobs}: must be 1 or more")
    system: Path = options.split
    name = load_system(system).name
    folder = options.out or Path("results") / f"{name}-split-seed{options.seed}"
    found = split_study.split_budget(
        system, folder, options.seed, options.stop, windows, options.since, levels, options.jobs
    )
    print(f"{name}, seed {found.seed}, {found.stop:g} s, from t = {found.start:g} s: line of sight, RMS [arcsec]")
    print(format_table(split_study.HEADER, split_study.rows(found), left=1))
    print(tables.SPLIT)
    print(folder / split_study.RESULT)
    return 0
