"""Write the numbers of each run's loop in its windows as blocks."""

from __future__ import annotations

from collections.abc import Sequence

from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.runs.loop_numbers import loop_numbers
from flexbench.runs.loop_table import header, notes, rows
from lockstep import InputError

from .results import Result


def loop_blocks(results: Sequence[Result]) -> list[Block]:
    """Return RMS and peak in the windows of each run with a plant of flexsat, and when it settled."""
    found: list[Block] = []
    for result in results:
        try:
            numbers = loop_numbers(result.folder)
        except InputError:  # another system, or nothing of the loop was recorded
            continue
        if not numbers.windows:
            continue
        if len(results) > 1:
            found.append(Heading(3, result.name))
        cells = [[label, unit.replace("um", "µm"), *values] for label, unit, *values in rows(numbers)]
        found.append(Table(header(numbers), cells, code=frozenset()))
        found += [Paragraph(note) for note in notes(numbers)]
    return found
