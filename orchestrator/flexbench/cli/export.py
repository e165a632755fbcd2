"""The command `flexsat export`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import out_option
from lockstep.cli.outcome import suggest, wrote
from lockstep.cli.parameter_types import PATH, OneOf

READ = {  # how other tools read the file
    "csv": "pandas.read_csv({path})",
    "mat": "load({path}) in MATLAB, scipy.io.loadmat({path}) in Python",
    "hdf5": "xarray.open_dataset({path})",
    "parquet": "pandas.read_parquet({path})",
}
_EXAMPLES = """
example:
  {program} export results/distributed-slew --format mat --signals plant.rate --signals 'plant.wheel.*'
"""


@command("export", _EXAMPLES)
@click.argument("results", type=PATH, metavar="RESULTS", help="results folder of a run")
@click.option("--format", "format_", type=OneOf(("csv", "mat", "hdf5", "parquet")), required=True, metavar="FORMAT",
              help="csv, mat (MATLAB structures), hdf5 (netCDF-4) or parquet")  # fmt: skip
@out_option("file to write (default: RESULTS/NAME OF RESULTS.csv etc.)", metavar="FILE")
@click.option("--signals", multiple=True, metavar="PATTERN",
              help="signals to write; * and ? are wildcards (default: all that were recorded)")  # fmt: skip
def export(results: Path, format_: str, out: Path | None, signals: tuple[str, ...]) -> int:
    """Write the signals of a run, with units, as one file for other tools."""
    from ..runs.export import export_run

    wrote(export_run(results, format_, out, signals))
    suggest(f"read it: {READ[format_]}")
    return 0
