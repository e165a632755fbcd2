"""Sections of the report, in the order of the page: a title, and a function of a run that returns blocks.

To add a study to the report, write `section(run)` in a module of this folder and list it here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flexbench.figures import section as design
from flexbench.html.document import Block
from flexbench.runs.run_folder import Run
from flexbench.studies.budget.sections import section as budget
from flexbench.studies.health.study import section as health
from flexbench.studies.margins.sections import section as margins
from flexbench.studies.shadow.sections import section as shadow
from flexbench.studies.spectra.study import section as spectra

Section = Callable[[Run], Sequence[Block]]

SECTIONS: tuple[tuple[str, Section], ...] = (
    ("Pointing budget", budget),
    ("Spectra", spectra),
    ("Shadow controller", shadow),
    ("Margins", margins),
    ("Estimator health", health),
    ("Design", design),
)

__all__ = ["SECTIONS", "Section"]
