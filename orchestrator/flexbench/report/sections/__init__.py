"""Sections of the report, in the order of the page: a title, and a function of a run that returns blocks.

To add a study to the report, write `section(run)` in a module of this folder and list it here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flexbench.html.document import Block
from flexbench.runs.run_folder import Run

from . import budget, design, health, margins, shadow, spectra

Section = Callable[[Run], Sequence[Block]]

SECTIONS: tuple[tuple[str, Section], ...] = (
    ("Pointing budget", budget.section),
    ("Spectra", spectra.section),
    ("Shadow controller", shadow.section),
    ("Margins", margins.section),
    ("Estimator health", health.section),
    ("Design", design.section),
)

__all__ = ["SECTIONS", "Section"]
