"""Sections of other studies: each a module whose `section(run)` returns blocks. Add a study by adding its line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import cast

from flexbench.html.document import Block, Heading, Paragraph
from flexbench.runs.run_folder import Run

from .gather import Result

# title on the page, module with section(run)
STUDIES: tuple[tuple[str, str], ...] = (
    ("Pointing budget", "flexbench.studies.budget"),
    ("Spectra", "flexbench.studies.spectra"),
    ("Shadow controller", "flexbench.studies.shadow"),
    ("Margins", "flexbench.studies.margins"),
    ("Estimator health", "flexbench.studies.health.study"),
    ("Design", "flexbench.figures"),
)
MOST_RUNS = 3  # on a page with sections: each takes seconds

Section = Callable[[Run], Sequence[Block]]


def study_sections(results: Sequence[Result]) -> list[tuple[str, list[Block]]]:
    """Return title and blocks of each study that has something to say of these runs."""
    ours = [result for result in results if result.run is not None]
    if not ours or len(ours) > MOST_RUNS:
        return []
    found = []
    for title, module in STUDIES:
        section = section_of(module)
        if section is None:
            continue
        blocks: list[Block] = []
        for result in ours:
            told = _told(section, result.run) if result.run is not None else []
            if told and len(ours) > 1:
                blocks.append(Heading(3, result.name))
            blocks += told
        if blocks:
            found.append((title, blocks))
    return found


def section_of(module: str) -> Section | None:
    """Return a study's section, None if the study is not installed or has none."""
    try:
        if find_spec(module) is None:
            return None
    except ModuleNotFoundError:  # its package is not there
        return None
    return cast("Section | None", getattr(import_module(module), "section", None))


def _told(section: Section, run: Run) -> list[Block]:
    """Return a run's blocks, or why there are none: too short, or a signal was not recorded."""
    try:
        blocks = list(section(run))
        # the page gives the title itself
        return blocks[1:] if blocks and isinstance(blocks[0], Heading) else blocks
    except ValueError as error:
        return [Paragraph(f"Not for this run: {error}")]
