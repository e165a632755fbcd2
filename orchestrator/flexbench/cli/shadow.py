"""`flexsat shadow`."""

from __future__ import annotations

import argparse

from ..html.text_table import format_table
from ..runs.run_folder import read_run
from ..studies.shadow import tables
from ..studies.shadow.study import study


def shadow(options: argparse.Namespace) -> int:
    """Print residuals and the closed loop before and after; leave shadow.json and the figure in each folder."""
    for folder in options.results:
        run = read_run(folder)
        found = study(run, options.since, options.window)
        path = tables.write_study(found, run)
        from ..figures import save_figure
        from ..figures.shadow import shadow_figure

        figures = save_figure(shadow_figure(run.signals(), found), folder / "figures", "shadow")
        print(f"{run.configuration}, seed {run.seed}: {folder}")
        print("\n".join(tables.summary(found)))
        print(format_table(tables.RESIDUALS, tables.residual_rows(found)))
        print(format_table(tables.loop_header(found), tables.loop_rows(found)))
        print("\n".join(map(str, (path, *figures))))
    return 0
