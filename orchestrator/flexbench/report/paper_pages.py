"""Figures and page of the paper's study, from the runs that it left."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from flexbench.figures.figure_lists import Drawn, design_figures, result_figures, save_figures
from flexbench.figures.margins import nichols_chart, sensitivity_singular_values, stability_maps
from flexbench.figures.wheels import responses_over_loop
from flexbench.runs.run_folder import read_run
from flexbench.studies.margins.study import curves
from flexbench.studies.paper.design_margins import LoopMargins, bandwidth, read_margins
from flexbench.studies.paper.paper import one_seed_folders
from flexbench.studies.paper.published import JUDGED, VariantName
from flexbench.studies.paper.table import Failed
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import Design, build_designs
from flexsat.parameters import ConfigurationName

from .write import write_report


def draw_paper(folder: Path, variants: Sequence[VariantName], seed: int, without: Collection[Path] = ()) -> list[Path]:
    """Draw the figures of the design and of one seed's runs into `folder`/figures; return their paths.

    `without` are the folders of runs that failed.
    """
    runs = [read_run(path) for path in one_seed_folders(folder, variants, seed, without)]
    designs = {name: build_designs(name) for name in CONFIGURATIONS}
    drawn = design_figures(designs) | result_figures(runs)
    loops = read_margins(folder)
    for name, every in designs.items():
        drawn |= figures_of_loops([loop for loop in loops if loop.configuration == name], name, every.corrected)
    return save_figures(drawn, folder / "figures")


def figures_of_loops(loops: Sequence[LoopMargins], name: ConfigurationName, design: Design) -> Drawn:
    """Return the figures of the margins of one layout: of the loop that flew, and its stability beside the others'."""
    if not loops:
        return {}
    by_variant = {loop.variant: loop for loop in loops}
    flown = by_variant.get("corrected", loops[0])
    grids = {
        f"{name}, {loop.title}: where the loop is stable, else growth in 1/s": loop.content["stability"]["grid"]
        for loop in loops
        if loop.variant != JUDGED or len(loops) == 1  # of the three the one on a part of the plant
    }
    drawn: Drawn = {f"spillover-{name}": partial(stability_maps, grids)}
    if not flown.stable:
        return drawn
    found = flown.content["analysis"]
    disk = found["margins"]["all wheels"]["disk"]
    values = (np.array(found[key]) for key in ("frequency", "largest_s", "largest_t"))
    published = by_variant[JUDGED].axes() if JUDGED in by_variant and flown is not loops[0] else {}
    return drawn | {
        f"bandwidth-{name}": partial(responses_over_loop, design, flown.axes(), published, bandwidth(flown)),
        f"nichols-{name}": partial(nichols_chart, curves(flown.content), disk),
        f"sensitivity-{name}": partial(sensitivity_singular_values, *values),
    }


def report_paper(
    folder: Path, variants: Sequence[VariantName], seed: int, failed: Sequence[Failed] = ()
) -> Path | None:
    """Write `folder`/report.html, of the table, the figures and one seed's runs; return its path.

    A run that failed has its histories there, marked, as far as it came. If all failed, there is no page, and one of an
    earlier study is removed.
    """
    page = folder / "report.html"
    without = [one.folder for one in failed]
    if not one_seed_folders(folder, variants, seed, without):
        page.unlink(missing_ok=True)
        return None
    begun = [one.folder for one in failed if one.begun]
    runs = one_seed_folders(folder, variants, seed, [path for path in without if path not in begun])
    return write_report(runs, page, studies=[folder])[0]
