"""`flexsat spectra`."""

from __future__ import annotations

import argparse

from ..html.text_table import format_table
from ..runs.run_folder import read_run
from ..studies.spectra.channels import CHANNELS, run_spectra
from ..studies.spectra.result_file import HEADER, rows, write_spectra


def spectra(options: argparse.Namespace) -> int:
    """Print a summary; leave spectra.json and the figure in each results folder."""
    for folder in options.results:
        run = read_run(folder)
        result = run_spectra(run, options.since, options.resolution, options.confidence)
        from ..figures.drawing import save_figure
        from ..figures.spectra import spectra_figure

        figure = spectra_figure(result, run.design)
        paths = [write_spectra(result, run), *save_figure(figure, folder / "figures", "spectra")]
        print(f"{run.configuration}, seed {run.seed}, from t = {result.start:g} s over {result.duration:g} s: {folder}")
        print(format_table(HEADER, rows(result), left=1))
        print(result.spectra[CHANNELS[0].name].method.describe())
        print("\n".join(map(str, paths)))
    return 0
