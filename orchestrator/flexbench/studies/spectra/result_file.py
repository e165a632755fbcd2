"""Spectra of a run as a file, spectra.json, and as rows of text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...runs.json_file import write_json
from ...runs.run_folder import Run
from .channels import CHANNELS, DEFINITIONS, Channel, RunSpectra
from .welch import Spectrum

RESULT = "spectra.json"
HEADER = ("quantity", "RMS", "unit", "mean", "strongest line", "half of the power below")


def write_spectra(result: RunSpectra, run: Run, folder: Path) -> Path:
    """Write spectra.json to a folder, the run's or another; return its path."""
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
    return write_json(folder / RESULT, content, indent=None)


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
