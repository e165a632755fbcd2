"""The waterfall of a sweep over wheel speed, as part of a report's section."""

from __future__ import annotations

from pathlib import Path

from flexbench.html.document import Block, Heading, Paragraph, Picture, Table
from flexbench.studies.waterfall.sweep import read_waterfall
from flexbench.studies.waterfall.tables import HEADER, flagged_rows, summary

FIGURE = Path("figures", "waterfall.svg")


def waterfall_blocks(folder: Path) -> list[Block]:
    """Return the blocks of a sweep in a run's folder, in its subfolder `waterfall`, or in `waterfall` next to it."""
    for candidate in (folder, folder / "waterfall", folder.parent / "waterfall"):
        content = read_waterfall(candidate)
        if content is None:
            continue
        blocks: list[Block] = [Heading(3, "Waterfall over wheel speed"), Paragraph(summary(content))]
        if (candidate / FIGURE).is_file():
            svg = (candidate / FIGURE).read_text(encoding="utf-8")
            blocks.append(Picture(svg[svg.index("<svg") :], FIGURE.name, "Deformation over wheel speed"))
        if flagged_rows(content):
            blocks.append(Table(HEADER, flagged_rows(content), code=frozenset()))
        return blocks
    return []
