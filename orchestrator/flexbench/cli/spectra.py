"""The command `flexsat spectra`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import from_option, out_option, results_argument
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import NUMBER, Number

from .options import SETTLED_HELP

_EXAMPLES = """
example:
  {program} spectra results/distributed-fine-pointing --resolution 0.1
"""


@command("spectra", _EXAMPLES, then="{program} report {results[0]}    # a page with the plots of the run", tables=True)
@results_argument
@click.option("--resolution", type=NUMBER, metavar="HZ",
              help="noise bandwidth in Hz (default: 0.05, coarser for short runs)")  # fmt: skip
@click.option(
    "--confidence",
    type=Number(above=0.0, most=0.999999),
    default=0.95,
    metavar="P",
    help="confidence of the bounds (default: 0.95)",
)
@from_option(SETTLED_HELP)
@out_option("folder for results and figures (default: the run's); of several runs, one folder in it for each")
def spectra(
    results: tuple[Path, ...], resolution: float | None, confidence: float, start: float | None, out: Path | None
) -> int:
    """Compute power spectral densities of pointing, rate, deformation and torque, with confidence bounds."""
    from ..figures.drawing import save_figure
    from ..figures.spectra import spectra_figure
    from ..runs.evaluation_folder import evaluation_folders, writing
    from ..runs.run_folder import read_run
    from ..studies.spectra.channels import CHANNELS, run_spectra
    from ..studies.spectra.result_file import HEADER, rows, write_spectra

    for folder, target in zip(results, evaluation_folders(results, out), strict=True):
        run = read_run(folder)
        result = run_spectra(run, start, resolution, confidence)
        figure = spectra_figure(result, run.design)
        with writing(target):
            paths = [write_spectra(result, run, target), *save_figure(figure, target / "figures", "spectra")]
        title = (
            f"{run.configuration}, seed {run.seed}, from t = {result.start:g} s over {result.duration:g} s: {folder}"
        )
        show_table(HEADER, rows(result), title)
        remark(result.spectra[CHANNELS[0].name].method.describe())
        wrote(*paths)
    return 0
