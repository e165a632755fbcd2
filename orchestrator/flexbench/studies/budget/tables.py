"""The pointing budget as rows of text: indices, requirements, and what a reader must know of them."""

from __future__ import annotations

from collections.abc import Sequence

from flexsat.parameters import ARCSECOND

from .evaluate import AXES, INDICES, INTERPRETATION, Budget, BudgetEntry
from .requirements import Assessment

ASSESSMENTS = ("requirement", "index", "axis", "level", "value", "limit", "unit", "margin", "")
TITLES = {"line_of_sight": "line of sight", "angle": "angle"}
SPLIT = (
    "Sources are switched by parameters of the FMUs, one on at a time, same seeds; RMS of the line of sight in arcsec."
    " `sum of sources` adds the error histories, `residual` is the difference of all together: the nonlinear part."
    " Gyroscopics: all, less all without them. Guidance: reference less commanded profile, on top of the rest."
)


def header(budget: Budget) -> tuple[str, ...]:
    """Return the columns of `rows`."""
    return ("index", "axis", "values", "RMS", *(f"{100.0 * level:g} %" for level in budget.levels))


def rows(budget: Budget, axes: Sequence[str] = tuple(AXES)) -> list[tuple[str, ...]]:
    """Return every index on the axes, in arcsec, as texts. A star marks a level that is the largest of few values."""
    return [_row(budget, entry) for entry in budget.entries if entry.axis in axes]


def _row(budget: Budget, entry: BudgetEntry) -> tuple[str, ...]:
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


def assessment_rows(assessments: Sequence[Assessment]) -> list[tuple[str, ...]]:
    """Return the table of requirements, `ASSESSMENTS` its columns, as texts."""
    return [
        (
            one.requirement.name,
            one.requirement.index,
            TITLES.get(one.requirement.axis, one.requirement.axis),
            f"{100.0 * one.requirement.level:g} %",
            f"{one.value:.4g}",
            f"{one.requirement.limit:g}",
            one.requirement.unit,
            f"{100.0 * one.margin:+.0f} %",
            "pass" if one.met else "FAIL",
        )
        for one in assessments
    ]
