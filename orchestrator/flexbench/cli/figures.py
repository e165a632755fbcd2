"""The command `flexsat figures`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, out_option
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError

from .options import configuration_option, configurations

if TYPE_CHECKING:
    from flexsat.parameters import ConfigurationName

    from ..runs.run_folder import Run

_EXAMPLES = """
examples:
  {program} figures
  {program} figures --as-published
  {program} figures results/paper --configuration distributed --out figures
"""


@command("figures", _EXAMPLES)
@click.argument("results", type=PATH, nargs=-1, metavar="[RESULTS...]",
                help="results folders of runs, or folders of such folders (default: draw the design)")  # fmt: skip
@click.option("--as-published", is_flag=True,
              help="draw the design as published: 25 modes, and the wheel speeds chosen on them")  # fmt: skip
@configuration_option
@out_option(f"folder to fill (default: results/figures{DISTINGUISHED})")
def figures(results: tuple[Path, ...], as_published: bool, configuration: tuple[str, ...], out: Path | None) -> int:
    """Draw the design, or the results of runs, as PNG and SVG."""
    from flexsat.design.chain import build_designs

    from ..figures.drawing import save_figure
    from ..figures.figure_lists import design_figures, result_figures
    from ..runs.study_folder import study_folder

    chosen = configurations(configuration)
    if results and as_published:
        raise InputError("--as-published: has no effect on results, which know what they flew; leave one of them out")
    if results:
        drawn = result_figures(runs_of(results, chosen))
    else:
        drawn = design_figures({name: build_designs(name) for name in chosen}, as_published)
    with study_folder(out, "figures-as-published" if as_published else "figures") as folder:
        for name, make in drawn.items():
            try:
                figure = make()
            except InputError as error:  # a signal was not recorded, or not often enough
                raise InputError(f"figure {name}: {error}") from error
            for path in save_figure(figure, folder, name):
                print(path, flush=True)
    return 0


def runs_of(folders: Sequence[Path], chosen: Sequence[ConfigurationName]) -> list[Run]:
    """Return the runs of the chosen configurations in results folders, or in folders of such folders.

    Raises
    ------
    InputError
        If a folder holds no run, or no run is of a chosen configuration.
    """
    from ..runs.run_folder import read_run

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
