"""`flexsat figures`: draw the design, or runs."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from flexbench.runs.run_folder import Run, read_run
from flexsat.design.chain import build_designs
from flexsat.parameters import CONFIGURATIONS, ConfigurationName
from lockstep import InputError

from ..figures.drawing import save_figure
from ..figures.figure_lists import design_figures, result_figures


def draw(options: argparse.Namespace) -> int:
    """Draw the figures of the design if no results are given, else those of the runs; print a line a file."""
    chosen: Sequence[ConfigurationName] = [
        name for name in CONFIGURATIONS if name in (options.configuration or CONFIGURATIONS)
    ]
    if options.results:
        drawn = result_figures(runs_of(options.results, chosen))
    else:
        drawn = design_figures({name: build_designs(name) for name in chosen})
    for name, make in drawn.items():
        try:
            figure = make()
        except ValueError as error:  # a signal was not recorded, or not often enough
            raise InputError(f"figure {name}: {error}") from error
        for path in save_figure(figure, options.out, name):
            print(path, flush=True)
    return 0


def runs_of(folders: Sequence[Path], chosen: Sequence[ConfigurationName]) -> list[Run]:
    """Return the runs of the chosen configurations in these folders, each one of a run or one that holds such.

    Raises
    ------
    InputError
        If a folder holds no run, or no run is of a chosen configuration.
    """
    runs = []
    for folder in folders:
        found = (
            [folder] if (folder / "run.toml").exists() else sorted(path.parent for path in folder.glob("*/run.toml"))
        )
        if not found:
            raise InputError(
                f"{folder}: neither a run's results folder nor one that holds such; `flexsat run` makes one"
            )
        runs += [read_run(path) for path in found]
    kept = [run for run in runs if run.configuration in chosen]
    if not kept:
        raise InputError(f"--configuration {', '.join(chosen)}: none of the {len(runs)} runs is of it")
    return kept
