"""Which figures are drawn of a design and of runs, and by what."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexbench.figures.figure_lists import design_figures, result_figures
from flexbench.runs.run_folder import Run
from flexsat.parameters import CONFIGURATIONS, ConfigurationName


def test_figures_of_a_design_are_listed_without_being_drawn(built: Any):
    assert set(design_figures(built)) == {
        "structure", "software", "mode-shapes", "campbell", "wheel-responses-centralised",
        "wheel-responses-distributed", "architecture-centralised", "architecture-distributed",
    }  # fmt: skip


def run_of(name: ConfigurationName, **kind: Any) -> Run:
    given = {"as_published": False, "slew": True, "seed": 1, "open_loop": False} | kind
    return Run(folder=Path("unread"), configuration=name, **given)


def test_runs_of_both_configurations_share_a_figure_and_others_do_not():
    runs = [run_of(name, slew=True) for name in CONFIGURATIONS]
    runs += [run_of(name, slew=False, open_loop=loop) for name in CONFIGURATIONS for loop in (False, True)]
    runs += [run_of("centralised", slew=True, seed=2), run_of("centralised", slew=True, as_published=True)]
    runs += [run_of("centralised", slew=True)]  # once more, as of another controller

    drawn = result_figures(runs)

    assert list(drawn) == ["slew-seed1", "fine-pointing-seed1", "slew-seed2", "slew-as-published-seed1", "slew-seed1-2"]
