"""The files of the comparison: layouts.json with all numbers in SI, layouts.csv a line a run, layouts.txt to read."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lockstep.whole_file import write_whole

from ...html.text_table import format_table
from ...runs.json_file import read_table, write_json
from .outcome import QUANTITIES
from .plan import Comparison
from .statistics import Estimate
from .tables import ComparisonRow, answer, cells, compare, header, notes, verdict, wheel_rows, wheels_header

RESULT = "layouts.json"
_TABLE = {"header": ["text"], "rows": [["text"]]}
_SHAPE = {
    "answer": ["text"],
    "verdicts": ["text"],
    "notes": ["text"],
    "table": _TABLE,
    "wheels": _TABLE,
    "shown": ["text"],
}


def write_result(comparison: Comparison, folder: Path) -> list[Path]:
    """Write the files; return their paths."""
    rows = compare(comparison)
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / "layouts.txt", as_text(comparison, rows).encode())
    write_whole(folder / "layouts.csv", as_csv(comparison).encode())
    write_json(folder / RESULT, as_json(comparison, rows))
    return [folder / name for name in ("layouts.txt", "layouts.csv", RESULT)]


def as_text(comparison: Comparison, rows: Sequence[ComparisonRow]) -> str:
    """Return everything for a terminal."""
    parts = [format_table(header(comparison), [cells(row) for row in rows]), "\n".join(map(verdict, rows))]
    if wheels := wheel_rows(comparison):
        parts.append(format_table(wheels_header(comparison), wheels))
    return "\n\n".join([*parts, "\n".join(answer(comparison, rows)), "\n".join(notes(comparison))]) + "\n"


def as_csv(comparison: Comparison) -> str:
    """Return a line a run: its errors and its numbers, in SI; empty where there is none."""
    output = io.StringIO()
    writer = csv.writer(output, lineterminator="\n")
    keys = [one.key for one in QUANTITIES]
    errors = ["frequency", "damping", "inertia x", "inertia y", "inertia z"]
    writer.writerow(["configuration", "scenario", "seed", *errors, *keys, "lost"])
    for one in comparison.outcomes:
        drawn = comparison.errors[one.seed]
        numbers = [one.numbers.get(key) for key in keys]
        writer.writerow(
            [
                *(one.configuration, one.scenario, one.seed),
                *(repr(value) for value in (drawn.frequency, drawn.damping, *drawn.inertia)),
                *("" if value is None else repr(value) for value in numbers),
                one.lost,
            ]
        )
    return output.getvalue()


def as_json(comparison: Comparison, rows: Sequence[ComparisonRow]) -> dict[str, Any]:
    """Return all numbers in SI, and the texts."""
    plan = comparison.plan
    lost = {one.seed for one in comparison.outcomes if one.lost}
    shown = next((seed for seed in plan.seeds if seed not in lost), plan.seeds[0])
    return {
        "seeds": list(plan.seeds),
        "duration": dict(plan.duration),
        "dispersion": asdict(plan.dispersion),
        "layouts": list(plan.layouts),
        "modes": dict(zip(plan.layouts, comparison.modes, strict=True)),
        "fmus": comparison.fmus,
        "overrides": {name: str(value) for name, value in plan.overrides.items()},
        "errors": {str(seed): asdict(errors) for seed, errors in comparison.errors.items()},
        "runs": [asdict(one) for one in comparison.outcomes],
        "quantities": [
            {
                "key": row.quantity.key,
                "label": row.quantity.label,
                "means": {name: _plain(one) for name, one in row.means.items()},
                "ratio" if row.is_ratio else "difference": _plain(row.contrast),
                "better": row.better,
            }
            for row in rows
        ],
        "table": {"header": list(header(comparison)), "rows": [list(cells(row)) for row in rows]},
        "verdicts": [verdict(row) for row in rows],
        "wheels": {"header": list(wheels_header(comparison)), "rows": [list(row) for row in wheel_rows(comparison)]},
        "answer": answer(comparison, rows),
        "notes": notes(comparison),
        "shown": [
            f"{one.configuration}-{one.scenario.replace('_', '-')}-seed{one.seed}"
            for one in comparison.outcomes
            if one.seed == shown
        ],  # runs on the page of the study
    }


def _plain(estimate: Estimate | None) -> dict[str, Any] | None:
    """Return an estimate as a table; bounds that there are none of are null."""
    if estimate is None:
        return None
    low, high = (None if bound != bound else bound for bound in (estimate.low, estimate.high))
    return {"value": estimate.value, "low": low, "high": high, "count": estimate.count}


def read_result(folder: Path) -> dict[str, Any] | None:
    """Return the texts of a comparison in a folder, None if there is none; InputError if its file is damaged."""
    return read_table(folder / RESULT, _SHAPE)
