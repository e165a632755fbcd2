"""The comparison of the layouts on a page: its answer, its table, and the runs of one seed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.studies.layouts.result_file import read_result


def layouts_title(folder: Path) -> str:
    """Return the question that a comparison answers; of a folder without one nothing."""
    content = read_result(folder)
    return "" if content is None else _question(content["answer"])


def _question(answer: Sequence[str]) -> str:
    asked, mark, _ = answer[0].partition("?")
    return asked + mark


def layouts_blocks(folder: Path) -> list[Block]:
    """Return answer, table, verdicts and wheels of a comparison; no block for a folder without one."""
    content = read_result(folder)
    if content is None:
        return []
    table, wheels = content["table"], content["wheels"]
    blocks: list[Block] = [Paragraph(" ".join(content["answer"]).removeprefix(_question(content["answer"])).strip())]
    blocks.append(Table(table["header"], table["rows"], code=frozenset()))
    blocks += [Heading(3, "Verdicts"), *(Paragraph(text) for text in content["verdicts"])]
    if wheels["rows"]:
        blocks += [Heading(3, "Wheels"), Table(wheels["header"], wheels["rows"], code=frozenset())]
    return [*blocks, Heading(3, "What was simulated"), *(Paragraph(text) for text in content["notes"])]


def shown_runs(folder: Path) -> list[Path]:
    """Return the runs of a comparison that its page shows: of one seed; none for a folder without a comparison."""
    content = read_result(folder)
    return [] if content is None else [folder / name for name in content["shown"] if (folder / name).is_dir()]
