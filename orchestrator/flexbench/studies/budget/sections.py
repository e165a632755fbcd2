"""The budget as rows of text, as a file, and as a section of a report."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path

from flexsat.fmu.reproducible_zip import write_atomically
from flexsat.parameters import ARCSECOND
from lockstep import InputError

from ...html.document import Block, Heading, Paragraph, Picture, Table
from ...runs.run_folder import Run
from .evaluate import AXES, INDICES, INTERPRETATION, Budget, Entry, Windows, compute_budget, steady_error
from .requirements import Requirement, Verdict
from .split import read_split

RESULT = "budget.json"
VERDICTS = ("requirement", "index", "axis", "level", "value", "limit", "unit", "margin", "")
TITLES = {"line_of_sight": "line of sight", "angle": "angle"}
SPLIT = (
    "Sources are switched by parameters of the FMUs, one on at a time, same seeds; RMS of the line of sight in arcsec."
    " `sum of sources` adds the error histories, `residual` is what all together do differently: the part that is not"
    " linear. Gyroscopics: all, less all without them. Guidance: reference less commanded profile, on top of the rest."
)


def header(budget: Budget) -> tuple[str, ...]:
    """Return the columns of `rows`."""
    return ("index", "axis", "values", "RMS", *(f"{100.0 * level:g} %" for level in budget.levels))


def rows(budget: Budget, axes: Sequence[str] = tuple(AXES)) -> list[tuple[str, ...]]:
    """Return every index on the axes, in arcsec, as texts. A star marks a level that is the largest of few values."""
    return [_row(budget, entry) for entry in budget.entries if entry.axis in axes]


def _row(budget: Budget, entry: Entry) -> tuple[str, ...]:
    marks = ["" if entry.sampled_enough(level) else "*" for level in budget.levels]
    values = [f"{entry.levels[level] / ARCSECOND:.4g}{mark}" for level, mark in zip(budget.levels, marks, strict=True)]
    name = TITLES.get(entry.axis, entry.axis)
    return (entry.index, name, str(entry.count), f"{entry.rms / ARCSECOND:.4g}", *values)


def notes(budget: Budget) -> list[str]:
    """Return what a reader must know of the numbers."""
    times = budget.windows
    found = [
        f"Error: rotation vector from reference to attitude, body axes, in arcsec, from t = {budget.start:g} s over"
        f" {budget.duration:g} s. Line of sight: about x and y; angle: all three.",
        f"Windows of {times.window:g} s, one after another; PDE: starts {times.separation:g} s apart; PRE: between"
        f" observations of {times.observation:g} s. {INTERPRETATION}",
    ]
    if any(not entry.sampled_enough(level) for entry in budget.entries for level in budget.levels):
        found.append("* fewer values than the level needs: the largest of them.")
    absent = [index for index in INDICES if budget.entry(index, "x") is None]
    if absent:
        found.append(f"Too short for {', '.join(absent)} with these windows.")
    return found


def verdict_rows(verdicts: Sequence[Verdict]) -> list[tuple[str, ...]]:
    """Return the requirements' table, as texts."""
    return [
        (
            verdict.requirement.name,
            verdict.requirement.index,
            TITLES.get(verdict.requirement.axis, verdict.requirement.axis),
            f"{100.0 * verdict.requirement.level:g} %",
            f"{verdict.value:.4g}",
            f"{verdict.requirement.limit:g}",
            verdict.requirement.unit,
            f"{100.0 * verdict.margin:+.0f} %",
            "pass" if verdict.met else "FAIL",
        )
        for verdict in verdicts
    ]


def as_text(head: Sequence[str], lines: Sequence[Sequence[str]], left: int = 2) -> str:
    """Return a table of texts for a terminal, the first `left` columns aligned left."""
    widths = [max(len(row[i]) for row in (head, *lines)) for i in range(len(head))]
    texts = []
    for row in (head, *lines):
        cells = [
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        texts.append("  ".join(cells).rstrip())
    return "\n".join(texts)


def write_budget(budget: Budget, verdicts: Sequence[Verdict], run: Run, requirements: Path | None) -> Path:
    """Leave budget.json in the results folder, in SI; return its path."""
    content = {
        "configuration": run.configuration,
        "seed": run.seed,
        "unit": "rad",
        "interpretation": INTERPRETATION,
        "start": budget.start,
        "duration": budget.duration,
        "windows": {
            "window": budget.windows.window,
            "separation": budget.windows.separation,
            "observation": budget.windows.observation,
        },
        "indices": [
            {
                "index": entry.index,
                "axis": entry.axis,
                "values": entry.count,
                "rms": entry.rms,
                "levels": {str(level): value for level, value in entry.levels.items()},
                "largest_only": [level for level in budget.levels if not entry.sampled_enough(level)],
            }
            for entry in budget.entries
        ],
        "requirements_file": str(requirements) if requirements else None,
        "requirements": [
            dict(zip(("name", "index", "axis", "level", "limit", "unit", "value", "met"), (
                verdict.requirement.name, verdict.requirement.index, verdict.requirement.axis,
                verdict.requirement.level, verdict.requirement.limit, verdict.requirement.unit,
                verdict.value, verdict.met), strict=True))
            for verdict in verdicts
        ],
    }  # fmt: skip
    path = run.folder / RESULT
    write_atomically(path, (json.dumps(content, indent=2) + "\n").encode())
    return path


def section(run: Run) -> list[Block]:
    """Return what a report shows: the indices with the windows of an earlier `flexsat budget`, or the defaults.

    Raises
    ------
    InputError
        If the run is too short or lacks a signal.
    """
    from ...figures.budget import budget_figure

    windows, since, verdicts = _as_before(run.folder)
    history = steady_error(run, since)
    budget = compute_budget(history, windows)
    drawn = io.StringIO()
    budget_figure(history, budget).savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    svg = drawn.getvalue()
    blocks: list[Block] = [Heading(2, "Pointing budget")]
    if verdicts:
        blocks.append(Table(VERDICTS, verdicts, code=frozenset()))
    blocks.append(Table(header(budget), rows(budget), code=frozenset()))
    blocks += [Paragraph(f"Seed {run.seed}. {' '.join(notes(budget))}")]
    blocks.append(Picture(svg[svg.index("<svg") :], "budget.svg", "Pointing error, and its indices"))
    split = read_split(run.folder) or read_split(run.folder.parent)
    if split is not None and split["seed"] == run.seed and split["configuration"] == run.configuration:
        blocks += [
            Heading(3, "Split by source"),
            Table(split["header"], split["rows"], code=frozenset()),
            Paragraph(SPLIT),
        ]
    return blocks


def _as_before(folder: Path) -> tuple[Windows, float | None, list[tuple[str, ...]]]:
    """Return windows, start and verdicts of an earlier budget in this folder."""
    path = folder / RESULT
    if not path.is_file():
        return Windows(), None, []
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        verdicts = [
            Verdict(
                requirement=Requirement(
                    **{key: line[key] for key in ("name", "index", "axis", "limit", "unit", "level")}, windows=Windows()
                ),
                value=line["value"],
                count=0,
            )
            for line in content["requirements"]
        ]
        return Windows(**content["windows"]), content["start"], verdict_rows(verdicts)
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path}: not written by `flexsat budget`; delete it or write it anew") from None
