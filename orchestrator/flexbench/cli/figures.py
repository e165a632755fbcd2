"""The command `flexsat figures`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, out_option
from lockstep.cli.outcome import show_table, wrote
from lockstep.cli.parameter_types import PATH
from lockstep.errors import InputError

from .options import configurations, spacecraft_option, variant_option

if TYPE_CHECKING:
    from flexsat.parameters import ConfigurationName
    from flexsat.variants import Variant

    from ..figures.figure_lists import Drawn
    from ..runs.run_folder import Run

FMUS = Path("fmus")  # where spacecraft are that are named
_EXAMPLES = """
examples:
  {program} figures
  {program} figures --as-published
  {program} figures --robust-design --out robust
  {program} figures results/paper --configuration distributed --out figures
"""


@command("figures", _EXAMPLES, then="open {path}", tables=True)
@click.argument("results", type=PATH, nargs=-1, metavar="[RESULTS...]",
                help="results folders of runs, or folders of such folders (default: draw the design)")  # fmt: skip
@variant_option("draw the design as published: 25 modes, and the wheel speeds chosen on them")
@click.option(
    "--robust-design",
    is_flag=True,
    help="draw trade-offs and loop shapes of the robust design, and print its tables (minutes)",
)
@spacecraft_option
@out_option(f"folder to fill (default: results/figures{DISTINGUISHED})")
def figures(
    results: tuple[Path, ...],
    variant: Variant,
    robust_design: bool,
    configuration: tuple[str, ...],
    out: Path | None,
) -> int:
    """Draw the design, or the results of runs, as PNG and SVG."""
    from ..figures.drawing import save_figure
    from ..figures.figure_lists import design_figures, result_figures
    from ..loop.chosen_spacecraft import choose
    from ..runs.study_folder import study_folder

    for option, given in (("--as-published", variant.of_release), ("--robust-design", robust_design)):
        if results and given:
            raise InputError(f"{option}: has no effect on results, which hold their own design; leave one of them out")
    if variant.of_release and robust_design:
        raise InputError(
            "--robust-design: is not a design as published; leave out one of --as-published and --robust-design"
        )
    if results:
        drawn = result_figures(runs_of(results, configuration))
    elif robust_design:
        drawn = _robust_design(configurations(configuration))
    else:
        drawn = design_figures({one.name: one.designs() for one in choose(configuration, FMUS)}, variant)
    kind = "-robust-design" if robust_design else variant.mark
    with study_folder(out, f"figures{kind}") as folder:
        for name, make in drawn.items():
            try:
                figure = make()
            except InputError as error:  # a signal was not recorded, or not often enough
                raise InputError(f"figure {name}: {error}") from error
            wrote(*save_figure(figure, folder, name))
    return 0


def _robust_design(chosen: Sequence[ConfigurationName]) -> Drawn:
    """Print the tables of the robust design, and return its figures."""
    from ..figures.robust_design import robust_design_figures
    from ..studies.spillover import mode_choice, trade_off

    choices = [choice.row for choice in mode_choice.compare_mode_choices(chosen)]
    show_table(mode_choice.HEADER, choices)
    curves = {name: trade_off.robust_trade_off(name) for name in chosen}
    for name, points in curves.items():
        rows = [point.row for point in points]
        show_table(trade_off.HEADER, rows, f"{name}: factors of the robust design's weights")
    return robust_design_figures(curves)


def runs_of(folders: Sequence[Path], chosen: Sequence[ConfigurationName]) -> list[Run]:
    """Return the runs of the chosen configurations, all if none is chosen, in results folders, or in folders of such.

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
    kept = [run for run in runs if not chosen or run.configuration in chosen]
    if not kept:
        raise InputError(f"--configuration {', '.join(chosen)}: none of the {len(runs)} runs is of it")
    return kept
