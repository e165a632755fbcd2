"""The report's section on the pointing budget."""

from __future__ import annotations

from flexbench.figures.budget import budget_figure
from flexbench.figures.drawing import svg_text
from flexbench.html.document import Block, Heading, Paragraph, Picture, Table
from flexbench.runs.run_folder import Run
from flexbench.studies.budget.evaluate import IndexWindows, compute_budget, steady_error
from flexbench.studies.budget.result_file import read_budget
from flexbench.studies.budget.split import read_split
from flexbench.studies.budget.tables import ASSESSMENTS, SPLIT, assessment_rows, header, notes, rows


def section(run: Run) -> list[Block]:
    """Return the indices of a run, with the windows of an earlier `flexsat budget` or else the default ones.

    Raises
    ------
    InputError
        If the run is too short or lacks a signal.
    """
    stored = read_budget(run.folder)
    history = steady_error(run, stored.start if stored else None)
    budget = compute_budget(history, stored.windows if stored else IndexWindows())
    blocks: list[Block] = [Heading(2, "Pointing budget")]
    if stored and stored.assessments:
        blocks.append(Table(ASSESSMENTS, assessment_rows(stored.assessments), code=frozenset()))
    blocks += [
        Table(header(budget), rows(budget), code=frozenset()),
        Paragraph(f"Seed {run.seed}. {' '.join(notes(budget))}"),
        Picture(svg_text(budget_figure(history, budget), "budget"), "budget.svg", "Pointing error, and its indices"),
    ]
    split = read_split(run.folder) or read_split(run.folder.parent)
    if split is not None and split["seed"] == run.seed and split["configuration"] == run.configuration:
        blocks += [
            Heading(3, "Split by source"),
            Table(split["header"], split["rows"], code=frozenset()),
            Paragraph(SPLIT),
        ]
    return blocks
