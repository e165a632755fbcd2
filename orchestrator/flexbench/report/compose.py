"""Compose the page of some runs: its sections in order, rendered by the templates in `page/`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from flexbench.html.document import Block, Heading, Paragraph
from flexbench.html.page_parts import PageSection, render_page
from lockstep import InputError

from .figure_images import drawn_images, fitted_images, stored_images
from .headline import headline_blocks
from .layouts_page import layouts_blocks, layouts_title
from .loop_blocks import loop_blocks, loop_numbers_of
from .paper_figures import paper_figures
from .results import Result, Unread
from .run_data import RunData, Window, read_run_data
from .script_data import MOST_SHOWN, script_data
from .study_sections import study_sections
from .study_table import TABLE, margin_blocks, native_blocks, study_table
from .text_blocks import (
    event_blocks,
    number_blocks,
    run_description,
    something_happened,
    summary_blocks,
    system_blocks,
    version_blocks,
)

PAGE_FOLDER = Path(__file__).with_name("page")
SCRIPTS = ("data.js", "axes.js", "plots.js", "scene.js")


def compose_page(
    results: Sequence[Result],
    studies: Sequence[Path] = (),
    window: Window | None = None,
    unread: Sequence[Unread] = (),
) -> str:
    """Return the page of some runs as HTML.

    Parameters
    ----------
    results : of the runs
    studies : folders with the table of a study and its figures
    window : part of the time to show, begin and end [s]
    unread : further runs, which could not be read

    Raises
    ------
    InputError
        If the signals of no run can be read.
    """
    runs, unread = _read_all(results, window, unread)
    results = [run.result for run in runs]
    title = results[0].name if len(results) == 1 else f"{len(results)} runs compared"
    if len(results) > 1 and len(studies) == 1:
        title = f"{studies[0].resolve().name}: {title}"
    contents, data = script_data(title, runs)
    names = ", ".join(result.name for result in results) if len(results) <= MOST_SHOWN else ""
    return render_page(
        title=title,
        subtitle=run_description(runs[0]) if len(results) == 1 else names,
        sections=list(_sections(runs, studies, unread)),
        contents=contents,
        data=data,
        scripts=[PAGE_FOLDER / name for name in SCRIPTS],
        folder=PAGE_FOLDER,
        status=str(results[0].record.get("status", "")) if len(results) == 1 else "",
    )


def _read_all(
    results: Sequence[Result], window: Window | None, unread: Sequence[Unread]
) -> tuple[list[RunData], list[Unread]]:
    """Return the data of the runs whose signals can be read, and the others."""
    runs: list[RunData] = []
    failed = list(unread)
    for result in results:
        try:
            runs.append(read_run_data(result, len(results), window))
        except InputError as error:
            if len(results) == 1:
                raise
            failed.append(Unread(name=result.name, reason=str(error)))
    if not runs:
        raise InputError("; ".join(one.reason for one in failed))
    return runs, failed


def _sections(runs: Sequence[RunData], studies: Sequence[Path], unread: Sequence[Unread]) -> Iterator[PageSection]:
    """Yield the sections: the answer and its numbers, figures, histories, motion, studies, bookkeeping last."""
    results = [run.result for run in runs]
    missing: list[Block] = [Paragraph(f"Not on this page: {one.name} ({one.reason}).") for one in unread]
    answer = headline_blocks(results, studies)
    records = summary_blocks(runs)
    if answer:
        yield PageSection(anchor="answer", title="In short", blocks=[*answer, *missing])
    else:
        yield PageSection(anchor="summary", title="Summary", blocks=[*records, *missing])
    for study in studies:
        if compared := layouts_blocks(study):
            yield PageSection(anchor="layouts", title=layouts_title(study), blocks=compared)
        else:
            yield PageSection(anchor="study", title="Published and flown", blocks=study_table(study))
    margins = [block for study in studies for block in margin_blocks(study)]
    if margins:
        yield PageSection(anchor="design-margins", title="Margins and spillover", blocks=margins)
    yield from _figures(results, studies)
    loops = [loop_numbers_of(result) for result in results]
    numbers = [*loop_blocks(results, loops), *number_blocks(runs, loops, with_metrics=not studies)]
    if numbers:
        yield PageSection(anchor="numbers", title="Numbers", blocks=numbers)
    yield PageSection(
        anchor="histories", title="Time histories", template="histories_section.html", notes=list(_reductions(runs))
    )
    if any(run.for_script["motion"] for run in runs):
        yield PageSection(anchor="structure", title="The structure in motion", template="structure_section.html")
    for name, blocks in study_sections(results):
        yield PageSection(anchor=name.lower().replace(" ", "-"), title=name, blocks=blocks)
    if any(map(something_happened, results)):
        yield PageSection(anchor="events", title="Events and faults", blocks=event_blocks(results))
    native = [block for study in studies for block in native_blocks(study)]
    if answer:  # else it stands first
        yield PageSection(anchor="summary", title="Records of the runs", blocks=[*records, *native])
    for anchor, title, blocks_of in (
        ("system", "System", system_blocks),
        ("versions", "Versions and hashes", version_blocks),
    ):
        of_runs = [(result.name, blocks_of(result)) for result in results]
        yield PageSection(anchor=anchor, title=title, template="runs_section.html", runs=of_runs)


def _figures(results: Sequence[Result], studies: Sequence[Path]) -> Iterator[PageSection]:
    """Yield the figures of studies and runs, those stored or else drawn; for the paper's study with its figures."""
    stored = [image for folder in [*studies, *(r.folder for r in results)] for image in stored_images(folder)]
    images, large = fitted_images(stored or drawn_images(results))
    blocks: list[Block] = [Paragraph(f"No room on this page for `figures/{one.name}`: {one.title}") for one in large]
    if any((study / TABLE).is_file() for study in studies):
        blocks += [Heading(3, "The paper's figures"), *paper_figures([image.name for image in images])]
    if images or blocks:
        yield PageSection(
            anchor="figures", title="Figures", template="figures_section.html", images=images, blocks=blocks
        )


def _reductions(runs: Sequence[RunData]) -> Iterator[str]:
    """Yield which histories are reduced to the extremes of intervals, and which are left out for lack of room."""
    for run in runs:
        for part in run.for_script["parts"]:
            stride = part["time"]["stride"]
            if stride > 1 and part["histories"]:
                names = ", ".join(dict.fromkeys(history["group"] for history in part["histories"]))
                yield (
                    f"{run.for_script['name']}: minimum and maximum of every {stride * run.interval:.3g} s, so that"
                    f" no peak is lost, rounded outwards to 16 bits of their range, of {names}"
                )
        windows = run.for_script["full_rate"]["windows"]
        if windows:
            named = "; ".join(f"{one['name']}, {one['begin']:.4g} to {one['end']:.4g} s" for one in windows)
            count = len(run.for_script["full_rate"]["data"])
            yield f"{run.for_script['name']}: every row of the first {count} of these signals in windows: {named}"
        for part in run.for_script["parts"]:
            if part["left_out"]:
                yield f"{run.for_script['name']}: no room on this page for {', '.join(part['left_out'])}"
