"""The report's section on spectra, with the waterfall of a sweep that was left near the run."""

from __future__ import annotations

from flexbench.figures.drawing import svg_text
from flexbench.figures.spectra import spectra_figure
from flexbench.html.document import Block, Heading, Paragraph, Picture, Table
from flexbench.runs.run_folder import Run
from flexbench.studies.spectra.channels import CHANNELS, DEFINITIONS, run_spectra
from flexbench.studies.spectra.result_file import HEADER, rows

from .waterfall import waterfall_blocks


def section(run: Run) -> list[Block]:
    """Return densities and cumulative spectra of a run; raise InputError if it is too short or lacks a signal."""
    result = run_spectra(run)
    method = result.spectra[CHANNELS[0].name].method
    return [
        Heading(2, "Spectra"),
        Paragraph(
            f"From t = {result.start:g} s, over {result.duration:g} s, seed {run.seed}. {method.describe()}"
            " Cumulative: from one periodogram of the whole history, without a window, so that it ends at the RMS."
        ),
        Table(HEADER, rows(result), code=frozenset()),
        Picture(svg_text(spectra_figure(result, run.design), "spectra"), "spectra.svg",
                "Densities and cumulative spectra"),
        Paragraph(DEFINITIONS),
        *waterfall_blocks(run.folder),
    ]  # fmt: skip
