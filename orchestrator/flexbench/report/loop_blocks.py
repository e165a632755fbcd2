"""Write the numbers of each run's loop in its windows as blocks."""

from __future__ import annotations

from collections.abc import Sequence

from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.runs.loop_numbers import QUANTITIES, LoopNumbers, loop_numbers
from flexbench.runs.loop_table import header, notes, rows
from flexbench.studies.paper.table import number
from flexsat.parameters import ARCSECOND
from lockstep import InputError

from .results import Result

MOST_TABLES = 3  # runs with a table of their own; more share one
_WINDOWS = (
    "Windows follow each run: during the slew, and after it has settled; without a slew, the steady part. Quantities "
    "of the paper have the paper's windows, so their values differ from these."
)


def loop_blocks(results: Sequence[Result], loops: Sequence[LoopNumbers | None]) -> list[Block]:
    """Return RMS and peak in the windows of each run with a plant of flexsat, and when it settled.

    `loops` are the numbers of each run, from `loop_numbers_of`.
    """
    found = [(result.name, one) for result, one in zip(results, loops, strict=True) if one is not None]
    if not found:
        return []
    if len(found) > MOST_TABLES:
        return [_common_table(found), Paragraph(_WINDOWS)]
    blocks: list[Block] = []
    for name, numbers in found:
        if len(results) > 1:
            blocks.append(Heading(3, name))
        cells = [[label, unit, *(number(float(text)) for text in values)] for label, unit, *values in rows(numbers)]
        blocks.append(Table(header(numbers), cells, code=frozenset()))
        blocks += [Paragraph(note) for note in notes(numbers)]
    return [*blocks, Paragraph(_WINDOWS)]


def loop_numbers_of(result: Result) -> LoopNumbers | None:
    """Return the numbers of a run's loop; None for another system, and where nothing of the loop was recorded."""
    try:
        numbers = loop_numbers(result.folder)
    except InputError:
        return None
    return numbers if numbers.windows else None


def _common_table(found: Sequence[tuple[str, LoopNumbers]]) -> Table:
    """Return one table of several runs: a row for each window."""
    lines = []
    for name, numbers in found:
        for k, one in enumerate(numbers.windows):
            cells = [
                f"{number(one.rms[q.key] / q.scale)} ({number(one.peak[q.key] / q.scale)})" if q.key in one.rms else "-"
                for q in QUANTITIES
            ]
            lines.append([name, one.window.text, *cells, _settling(numbers) if k == len(numbers.windows) - 1 else ""])
    labels = (f"{q.label} [{q.unit}], RMS (peak)" for q in QUANTITIES)
    return Table(("run", "window", *labels, "settled after [s] (within)"), lines, code=frozenset())


def _settling(numbers: LoopNumbers) -> str:
    """Return how long after the last slew, or after the start, a run settled."""
    if not numbers.settlings:
        return "-"
    last = numbers.settlings[-1]
    band = f"{last.band / ARCSECOND:g} arcsec"
    return f"not within {band}" if last.time is None else f"{last.time:.4g} ({band})"
