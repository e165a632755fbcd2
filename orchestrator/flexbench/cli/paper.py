"""The command `flexsat paper`."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, jobs_option, out_option, stop_time_option
from lockstep.errors import InputError

from .options import fmus_option, seeds, seeds_option

if TYPE_CHECKING:
    from ..studies.paper.published import Variant

_EXAMPLES = """
example:
  {program} paper --seeds 6 --corrected
"""


@command("paper", _EXAMPLES)
@click.option("--as-published", is_flag=True, help="only with the slips of the published release")
@click.option("--corrected", is_flag=True, help="only without them (default: both)")
@seeds_option(1)
@stop_time_option(300.0)
@out_option(f"results folder (default: results/paper{DISTINGUISHED})")
@fmus_option
@jobs_option
def paper(
    as_published: bool,
    corrected: bool,
    seed_count: int,
    stop_time: float,
    out: Path | None,
    fmus: Path,
    jobs: int | None,
) -> int:
    """Build the FMUs, simulate the paper's six runs, and compare the results with its table."""
    from flexsat.parameters import CONFIGURATIONS

    from ..loop.build import build_all
    from ..report.paper_pages import draw_paper, report_paper
    from ..runs.metrics import SETTLED_FROM
    from ..runs.study_folder import study_folder
    from ..studies.paper.paper import run_paper
    from ..studies.paper.published import VARIANTS
    from ..studies.paper.table import as_text

    asked = {"as_published": as_published, "corrected": corrected, "published_design": corrected}
    chosen: list[Variant] = [variant for variant in VARIANTS if asked[variant]] or list(VARIANTS)
    if not stop_time > SETTLED_FROM:
        raise InputError(f"--stop-time {stop_time:g}: the table refers to t > {SETTLED_FROM:g} s; simulate longer")
    started = perf_counter()
    with study_folder(out, "paper") as folder:
        build_all(CONFIGURATIONS, fmus)
        print(f"built in {perf_counter() - started:.1f} s")
        numbers = seeds(seed_count)
        print(as_text(run_paper(fmus, folder, chosen, numbers, stop_time, jobs)))
        print("\n".join(str(path) for path in draw_paper(folder, chosen, numbers[0])))
        print(report_paper(folder, chosen, numbers[0]))
        print(f"table.txt, table.md, table.csv, table.json and every run: {folder}")
    return 0
