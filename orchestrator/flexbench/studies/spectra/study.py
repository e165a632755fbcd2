"""Spectra of a results folder: spectra.json, figures, and what a report shows of them."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.fmu.reproducible_zip import write_atomically

from ...html.document import Block, Heading, Paragraph, Picture, Table
from ...runs.run_folder import Run
from .channels import CHANNELS, DEFINITIONS, Channel, RunSpectra, run_spectra
from .welch import Spectrum

RESULT = "spectra.json"
HEADER = ("quantity", "RMS", "unit", "mean", "strongest line", "half of the power below")


def write_spectra(result: RunSpectra, run: Run) -> list[Path]:
    """Leave spectra.json, and the figure as PNG and SVG under figures/; return the paths."""
    from ...figures.drawing import save_figure
    from ...figures.spectra import spectra_figure

    content: dict[str, Any] = {
        "configuration": run.configuration,
        "seed": run.seed,
        "start": result.start,
        "duration": result.duration,
        "definitions": DEFINITIONS,
        "channels": {},
    }
    for channel in CHANNELS:
        spectrum = result.spectra[channel.name]
        low, high = spectrum.method.bounds()
        content["channels"][channel.name] = {
            "unit": channel.unit,
            "density_unit": f"({channel.unit})2/Hz",
            "method": spectrum.method.describe(),
            "bounds": [low, high],
            "level": spectrum.method.level,
            "rms": float(np.sqrt(spectrum.mean_square)),
            "frequency": spectrum.frequency.tolist(),
            "density": spectrum.total.tolist(),
        }
    path = run.folder / RESULT
    write_atomically(path, (json.dumps(content) + "\n").encode())
    figure = spectra_figure(result, run.design)
    return [path, *save_figure(figure, run.folder / "figures", "spectra")]


def rows(result: RunSpectra) -> list[tuple[str, ...]]:
    """Return the table's rows, as texts."""
    return [_row(channel, result.spectra[channel.name]) for channel in CHANNELS]


def _row(channel: Channel, spectrum: Spectrum) -> tuple[str, ...]:
    scale = channel.display_scale
    steps, cumulative = spectrum.cumulative_frequency, spectrum.cumulative
    inside = spectrum.frequency > 1.5 * spectrum.method.resolution  # the mean and slow drift are no line
    if not cumulative[-1] > 0.0:
        return (channel.label, "0", channel.display_unit, "0", "-", "-")
    line = float(spectrum.frequency[inside][np.argmax(spectrum.total[inside])])
    half = float(steps[np.searchsorted(cumulative, 0.5 * cumulative[-1])])
    return (
        channel.label,
        f"{np.sqrt(cumulative[-1]) / scale:.3g}",
        channel.display_unit,
        f"{np.sqrt(cumulative[0]) / scale:.2g}",
        f"{line:.2f} Hz",
        f"{half:.2f} Hz",
    )


def section(run: Run) -> list[Block]:
    """Return what a report shows; raise InputError if the run is too short or lacks a signal."""
    from ...figures.spectra import spectra_figure

    result = run_spectra(run)
    method = result.spectra[CHANNELS[0].name].method
    drawn = io.StringIO()
    spectra_figure(result, run.design).savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    svg = drawn.getvalue()
    blocks: list[Block] = [
        Heading(2, "Spectra"),
        Paragraph(
            f"From t = {result.start:g} s, over {result.duration:g} s, seed {run.seed}. {method.describe()}"
            " Cumulative: from one periodogram of the whole history, without a window, so that it ends at the RMS."
        ),
        Table(HEADER, rows(result), code=frozenset()),
        Picture(svg[svg.index("<svg") :], "spectra.svg", "Densities and cumulative spectra"),
        Paragraph(DEFINITIONS),
    ]
    from ..waterfall import blocks_beside

    return [*blocks, *blocks_beside(run.folder)]
