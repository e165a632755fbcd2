"""Simulate, analyse and report the flexible spacecraft: scenarios, studies, figures and the command line `flexsat`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["load"]


def load(path: Path | str, signals: Sequence[str] | None = None) -> Dataset:
    """Load the signals of a results folder as an xarray Dataset; see `flexbench.runs.dataset.load_dataset`."""
    from .runs.dataset import load_dataset  # xarray takes a second to import, so only where it is needed

    return load_dataset(path, signals)
