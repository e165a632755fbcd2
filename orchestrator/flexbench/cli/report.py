"""The command `flexsat report`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option
from lockstep.cli.outcome import wrote
from lockstep.cli.parameter_types import NUMBER, PATH

_EXAMPLES = """
example:
  {program} report results/distributed-slew results/centralised-slew --out slews.html --pdf
"""


@command("report", _EXAMPLES, then="open {path} in a browser")
@click.argument("results", type=PATH, nargs=-1, required=True, metavar="RESULTS...",
                help="results folders of runs, or folders of such folders")  # fmt: skip
@out_option("page to write (default: report.html in the first results folder)", metavar="FILE")
@click.option("--time-range", type=NUMBER, nargs=2, metavar="FROM TO",
              help="plot this time range, in seconds; a short one keeps every row")  # fmt: skip
@click.option("--pdf", is_flag=True, help="also print the page to PDF; needs Chromium or Chrome")
def report(results: tuple[Path, ...], out: Path | None, time_range: tuple[float, float] | None, pdf: bool) -> int:
    """Write one HTML page about a run, or a comparison of several; the page needs no network."""
    from ..report import write_report

    wrote(*write_report(results, out, pdf=pdf, window=time_range))
    return 0
