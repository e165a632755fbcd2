"""The comparison of the native FMUs with those in Python, as lines of tables: for the terminal, and for the page."""

from __future__ import annotations

from ...loop.equivalence import Difference
from .native import TOLERANCE, NativeRun, NativeStudy
from .published import TITLES

TITLE = "Native FMUs against those in Python"
RUN_HEADER = ("run", "Python [s]", "native [s]", "largest difference", "in")
PORT_HEADER = ("port", "largest difference", "in", "run")


def run_rows(study: NativeStudy) -> list[list[str]]:
    """Return a line for each run: both times, and where it differs most; then the sum of the times."""
    rows = [[run.run, f"{run.python_time:.1f}", f"{run.native_time:.1f}", *_result(run)] for run in study.runs]
    done = [run for run in study.runs if not run.failure]
    python, native = sum(run.python_time for run in done), sum(run.native_time for run in done)
    faster = f"{python / native:.1f} times as fast" if native else ""
    return [*rows, ["sum", f"{python:.1f}", f"{native:.1f}", "", faster]]


def _result(run: NativeRun) -> tuple[str, str]:
    largest = run.largest
    if largest is None:
        return "-", run.failure
    return (f"{largest.relative:.1e}", largest.signal) if largest.relative else ("0", "")


def port_rows(study: NativeStudy) -> list[list[str]]:
    """Return a line for each port that differs in some run, with the run where it does most; the largest first."""
    farthest: dict[str, tuple[Difference, str]] = {}
    for run in study.runs:
        for found in run.differences:
            before = farthest[found.port][0].relative if found.port in farthest else 0.0
            if found.relative > before:
                farthest[found.port] = (found, run.run)
    ranked = sorted(farthest.values(), key=lambda entry: -entry[0].relative)
    return [[found.port, f"{found.relative:.1e}", found.signal, run] for found, run in ranked]


def remarks(study: NativeStudy) -> list[str]:
    """Return what was compared, which ports are equal, and the largest difference, in sentences."""
    ports = {found.port for run in study.runs for found in run.differences}
    rows = port_rows(study)
    equal = sorted(ports - {row[0] for row in rows})
    found = [
        f"{TITLES.get(study.variant, study.variant)}, seed {study.seed}, runs of {study.duration:g} s through the FMUs"
        " in Python and through those in C. Times are those of the runs, some of which ran at the same time.",
        "Differences are relative to the largest value of the port through the FMUs in Python.",
    ]
    if equal:
        found.append(f"Equal in all runs: {', '.join(equal)}.")
    if rows:
        found.append(f"Largest difference: {rows[0][1]} in {rows[0][2]}, {rows[0][3]}; {_judged(study)}")
    return found


def _judged(study: NativeStudy) -> str:
    return f"at most {TOLERANCE:g} is allowed." if study.met else f"more than the {TOLERANCE:g} that is allowed."


def objections(study: NativeStudy) -> list[str]:
    """Return a line for each run that failed, or differs by more than is allowed."""
    lines = []
    for run in study.runs:
        largest = run.largest
        if largest is None:
            lines.append(f"{run.run}, native: {run.failure}")
        elif not run.met:
            what = f"differs by {largest.relative:.1e} in {largest.signal}, more than {TOLERANCE:g}"
            lines.append(f"{run.run}, native: {what}")
    return lines
