"""The command `flexsat shadow`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import from_option, out_option, results_argument
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import DURATION

_EXAMPLES = """
example:
  {program} shadow results/vendor

  evaluates a run with a shadow, for example of
  {program} run fmus/centralised/fine_pointing.ssd --stop-time 100 --out results/vendor \\
      --shadow controller=vendor.fmu --shadow-adapter vendor.toml --switchover 50
"""


@command("shadow", _EXAMPLES, then="{program} report {results[0]}    # a page with the plots of the run", tables=True)
@results_argument
@from_option("leave out everything before this time, in seconds (default: 0)")
@click.option("--window", type=DURATION, metavar="S",
              help="length of the compared windows: before the switchover, and at the end (default: all)")  # fmt: skip
@out_option("folder for results and figures (default: the run's); of several runs, one folder in it for each")
def shadow(results: tuple[Path, ...], start: float | None, window: float | None, out: Path | None) -> int:
    """Evaluate a shadow controller: residuals of each wheel, and the closed loop before and after the switchover."""
    from ..figures.drawing import save_figure
    from ..figures.shadow import shadow_figure
    from ..runs.evaluation_folder import evaluation_folders, writing
    from ..runs.run_folder import read_run
    from ..studies.shadow import tables
    from ..studies.shadow.study import study

    for folder, target in zip(results, evaluation_folders(results, out), strict=True):
        run = read_run(folder)
        found = study(run, start, window)
        with writing(target):
            path = tables.write_study(found, run, target)
            paths = save_figure(shadow_figure(run.signals(), found), target / "figures", "shadow")
        print(f"{run.configuration}, seed {run.seed}: {folder}")
        remark(*tables.summary(found))
        show_table(tables.RESIDUALS, tables.residual_rows(found))
        show_table(tables.loop_header(found), tables.loop_rows(found))
        wrote(path, *paths)
    return 0
