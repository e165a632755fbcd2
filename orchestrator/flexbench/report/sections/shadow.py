"""The report's section on a shadow controller."""

from __future__ import annotations

from flexbench.figures.drawing import svg_text
from flexbench.figures.shadow import shadow_figure
from flexbench.html.document import Block, Heading, Paragraph, Picture, Table
from flexbench.runs.run_folder import Run
from flexbench.studies.shadow.study import study
from flexbench.studies.shadow.tables import NOTE, RESIDUALS, loop_header, loop_rows, residual_rows, summary
from lockstep.shadow.residual import has_shadow


def section(run: Run) -> list[Block]:
    """Return residuals and closed-loop numbers of a run; no block for a run without a shadow.

    Raises
    ------
    InputError
        If the run is too short, or a signal was not recorded.
    """
    if not has_shadow(run.folder):
        return []
    found = study(run)
    svg = svg_text(shadow_figure(run.signals(), found), "shadow")
    return [
        Heading(2, "Shadow controller"),
        Paragraph(" ".join(summary(found))),
        Table(loop_header(found), loop_rows(found), code=frozenset()),
        Picture(svg, "shadow.svg", "Torque of the original and of the shadow, their residual, and the pointing error"),
        Table(RESIDUALS, residual_rows(found)),
        Paragraph(f"Seed {run.seed}. {NOTE}"),
    ]
