"""Collect the sections of the studies for the runs of a page."""

from __future__ import annotations

from collections.abc import Sequence

from flexbench.html.document import Block, Heading, Paragraph
from flexbench.runs.run_folder import Run
from lockstep.errors import InputError

from .results import Result
from .sections import SECTIONS, Section

MOST_RUNS = 3  # on a page with sections: each takes seconds


def study_sections(results: Sequence[Result]) -> list[tuple[str, list[Block]]]:
    """Return title and blocks of each study that applies to some of these runs."""
    flexsat_runs = [(result.name, result.run) for result in results if result.run is not None]
    if not flexsat_runs or len(flexsat_runs) > MOST_RUNS:
        return []
    found = []
    for title, section in SECTIONS:
        blocks: list[Block] = []
        for name, run in flexsat_runs:
            of_run = _blocks_of(section, run)
            if of_run and len(flexsat_runs) > 1:
                blocks.append(Heading(3, name))
            blocks += of_run
        if blocks:
            found.append((title, blocks))
    return found


def _blocks_of(section: Section, run: Run) -> list[Block]:
    """Return a run's blocks, or why there are none: too short, or a signal was not recorded."""
    try:
        blocks = list(section(run))
        # the page writes the title itself
        return blocks[1:] if blocks and isinstance(blocks[0], Heading) else blocks
    except InputError as error:
        return [Paragraph(f"Not for this run: {error}")]
