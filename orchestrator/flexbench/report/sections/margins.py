"""The report's section on stability margins."""

from __future__ import annotations

from flexbench.figures.drawing import svg_text
from flexbench.figures.margins import margin_figures
from flexbench.html.document import Block, Heading, Paragraph, Picture, Table
from flexbench.runs.run_folder import Run
from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.estimate import COHERENT
from flexbench.studies.margins.stability import delay_margin
from flexbench.studies.margins.study import FILE, read_study
from flexbench.studies.margins.tables import EXACT_HEADER, HEADER, exact_rows, explanation, margin_rows


def section(run: Run) -> list[Block]:
    """Return the study in the run's folder; without one the design's delay margin, and the command for the rest."""
    heading = Heading(2, "Margins")
    if not (run.folder / FILE).is_file():
        margin = delay_margin(DesignedLoop(design=run.design).at)
        text = (
            f"Delay margin of the design at the plant's input, all wheels together, exact: {margin * 1e3:.2f} ms, "
            f"on the {run.design.spacecraft.mode_count} modes that it knows. "
            f"`flexsat margins SYSTEM --out {run.folder}` finds gain, phase and disk margins with those of the plant, "
            "and measures them through the FMUs."
        )
        return [heading, Paragraph(text)]
    content = read_study(run.folder)
    blocks: list[Block] = [heading, Paragraph(explanation(content))]
    if exact_rows(content):
        blocks.append(Table(EXACT_HEADER, exact_rows(content), frozenset()))
    blocks.append(Table(HEADER, margin_rows(content), frozenset()))
    for name, figure in margin_figures(content, COHERENT).items():
        blocks.append(Picture(svg_text(figure, name), f"{name}.svg", name))
    return blocks
