"""Figures and page of the paper's study, from the runs that it left."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexbench.figures.figure_lists import design_figures, result_figures, save_figures
from flexbench.runs.run_folder import read_run
from flexbench.studies.paper.paper import one_seed_folders
from flexbench.studies.paper.published import Variant
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import build_designs

from .write import write_report


def draw_paper(folder: Path, variants: Sequence[Variant], seed: int) -> list[Path]:
    """Draw the figures of the design and of one seed's runs into `folder`/figures; return their paths."""
    runs = [read_run(path) for path in one_seed_folders(folder, variants, seed)]
    designs = {name: build_designs(name) for name in CONFIGURATIONS}
    return save_figures(design_figures(designs) | result_figures(runs), folder / "figures")


def report_paper(folder: Path, variants: Sequence[Variant], seed: int) -> Path:
    """Write `folder`/report.html, of the table, the figures and one seed's runs; return its path."""
    return write_report(one_seed_folders(folder, variants, seed), folder / "report.html", studies=[folder])[0]
