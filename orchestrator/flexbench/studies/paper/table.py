"""The paper's results table next to the numbers of flexsat: as text, Markdown, CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexsat.parameters import CONFIGURATIONS, ConfigurationName

from .published import REMARKS, ROWS, VARIANTS, PaperRow, Variant

Key = tuple[Variant, ConfigurationName, str]  # variant, configuration, scenario
WITHIN = 0.10  # relative deviation from the reference that counts as met
ENOUGH = 4  # seeds from which their scatter is estimated
DEVIATIONS = 3.0  # or this many standard deviations of one seed, where it scatters more


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A number of flexsat, in the printed unit, over the seeds."""

    mean: float
    deviation: float | None  # standard deviation of one seed; None with a single seed
    count: int

    @property
    def text(self) -> str:
        """The mean, and the spread if there is one."""
        spread = "" if self.deviation is None else f" ± {number(self.deviation)}"
        return number(self.mean) + spread


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A number of flexsat compared with an earlier independent simulation."""

    reference: float
    deviation: float  # relative
    criterion: str
    met: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """All metrics of a study, by variant, configuration and scenario: one mapping a seed."""

    metrics: Mapping[Key, Sequence[Mapping[str, float]]]
    seeds: Sequence[int]
    duration: float  # s

    def cell(self, row: PaperRow, variant: Variant, name: ConfigurationName) -> Cell | None:
        """Return the number of a cell; None if that variant was not run."""
        runs = self.metrics.get((variant, name, row.scenario))
        if not runs:
            return None
        values = np.array([run[row.key] for run in runs]) * row.scale
        deviation = float(values.std(ddof=1)) if len(values) > 1 else None
        return Cell(mean=float(values.mean()), deviation=deviation, count=len(values))

    @property
    def variants(self) -> list[Variant]:
        """The variants that were run."""
        return [variant for variant in VARIANTS if any(key[0] == variant for key in self.metrics)]


def number(value: float) -> str:
    """Format a number with three significant digits, in exponent form only where it is shorter."""
    if value == 0.0:
        return "0"
    if 1e-2 <= abs(value) < 1e4:
        return f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def compare(cell: Cell, reference: float, scatter: float) -> Comparison:
    """Compare with the reference: within 10 %, or within three standard deviations where one seed scatters more.

    Parameters
    ----------
    cell : of flexsat
    reference : a mean over some six seeds itself
    scatter : standard deviation of one seed, in the printed unit
    """
    deviation = cell.mean / reference - 1.0 if reference else (0.0 if cell.mean == 0.0 else float("inf"))
    if scatter > WITHIN * abs(reference):
        return Comparison(
            reference=reference,
            deviation=deviation,
            criterion="3 standard deviations of one seed",
            met=abs(cell.mean - reference) <= DEVIATIONS * scatter,
        )
    return Comparison(
        reference=reference, deviation=deviation, criterion="10 %", met=abs(cell.mean - reference) <= WITHIN * reference
    )


def one_seed_scatter(row: PaperRow, variant: Variant, name: ConfigurationName, cell: Cell) -> float:
    """Return the standard deviation of one seed: of these runs if there are enough, else of a stored study."""
    if cell.deviation is not None and cell.count >= ENOUGH:
        return cell.deviation
    stored = _stored_scatter().get(f"{row.label} | {variant} | {name}")
    return stored["standard_deviation"] if stored else 0.0


@cache
def _stored_scatter() -> dict[str, dict[str, float]]:
    """Return mean and standard deviation of one seed by cell, from six seeds."""
    content = json.loads(resources.files(__package__).joinpath("scatter.json").read_text(encoding="utf-8"))
    return dict(content["cells"])


def _header(results: Results) -> list[str]:
    return ["row", "unit", "published", *(variant.replace("_", " ") for variant in results.variants)]


def _lines(results: Results, name: ConfigurationName) -> list[list[str]]:
    lines = []
    for row in ROWS:
        cells = [results.cell(row, variant, name) for variant in results.variants]
        numbers = [cell.text if cell else "-" for cell in cells]
        lines.append([row.label, row.unit, number(row.published_for(name)), *numbers])
    return lines


def footnotes(results: Results) -> list[str]:
    """Return seeds, definitions and remarks, a line each."""
    seeds = ", ".join(map(str, results.seeds))
    spread = " (mean ± standard deviation of one seed)" if len(results.seeds) > 1 else ""
    notes = [f"Runs of {results.duration:g} s through the FMUs; seeds {seeds}{spread}."]
    notes += [f"{row.label}: {row.definition}{f' ({row.note})' if row.note else ''}." for row in ROWS]
    return notes + list(REMARKS)


def as_text(results: Results, width: int = 110) -> str:
    """Return the table for a terminal."""
    output = io.StringIO()
    console = Console(file=output, width=width)
    for name in CONFIGURATIONS:
        table = Table(title=f"{name}: results of the paper and of flexsat", title_justify="left", box=SIMPLE_HEAD)
        for column in _header(results):
            table.add_column(column, justify="left" if column in ("row", "unit") else "right")
        for line in _lines(results, name):
            table.add_row(*line)
        console.print(table)
    console.print(_comparison(results))
    return output.getvalue() + "\n".join(footnotes(results)) + "\n"


def _comparison(results: Results) -> Table:
    table = Table(
        title="Against an earlier independent simulation on the same mesh", title_justify="left", box=SIMPLE_HEAD
    )
    for column in ("row", "variant", "configuration", "flexsat", "reference", "deviation", "criterion", ""):
        table.add_column(column, justify="right" if column in ("flexsat", "reference", "deviation") else "left")
    for row, variant, name, cell, comparison in comparisons(results):
        deviation = f"{100.0 * comparison.deviation:+.0f} %" if np.isfinite(comparison.deviation) else "-"
        table.add_row(
            row.label,
            variant.replace("_", " "),
            name,
            cell.text,
            number(comparison.reference),
            deviation,
            comparison.criterion,
            "met" if comparison.met else "not met",
        )
    return table


def comparisons(results: Results) -> list[tuple[PaperRow, Variant, ConfigurationName, Cell, Comparison]]:
    """Return the comparison of every number that was run with its reference."""
    found = []
    for row in ROWS:
        for variant in results.variants:
            for name in CONFIGURATIONS:
                cell = results.cell(row, variant, name)
                if cell is not None:
                    scatter = one_seed_scatter(row, variant, name, cell)
                    found.append((row, variant, name, cell, compare(cell, row.reference_for(variant, name), scatter)))
    return found


def as_markdown(results: Results) -> str:
    """Return the tables in Markdown, with their footnotes."""
    parts = []
    for name in CONFIGURATIONS:
        header = _header(results)
        rules = ["---" if column in ("row", "unit") else "---:" for column in header]
        rows = [[name, *header[1:]], rules, *_lines(results, name)]
        parts.append("\n".join("| " + " | ".join(row) + " |" for row in rows))
    parts.append("\n".join(f"- {note}" for note in footnotes(results)))
    return "\n\n".join(parts) + "\n"


def as_csv(results: Results) -> str:
    """Return one line a number: full precision, in the printed unit."""
    output = io.StringIO()
    writer = csv.writer(output, lineterminator="\n")
    writer.writerow(
        ["row", "unit", "variant", "configuration", "published", "mean", "standard deviation", "seeds", "reference"]
    )
    for row, variant, name, cell, comparison in comparisons(results):
        spread = "" if cell.deviation is None else repr(cell.deviation)
        writer.writerow(
            [row.label, row.unit, variant, name, row.published_for(name), repr(cell.mean), spread, cell.count,
             comparison.reference]
        )  # fmt: skip
    return output.getvalue()


def as_json(results: Results) -> str:
    """Return everything behind the table, every seed's metrics in SI included."""
    content = {
        "seeds": list(results.seeds),
        "duration": results.duration,
        "rows": [
            {
                "row": row.label,
                "unit": row.unit,
                "definition": row.definition,
                "variant": variant,
                "configuration": name,
                "published": row.published_for(name),
                "mean": cell.mean,
                "standard_deviation": cell.deviation,
                "reference": comparison.reference,
                "criterion": comparison.criterion,
                "met": comparison.met,
            }
            for row, variant, name, cell, comparison in comparisons(results)
        ],
        "metrics_si": {" ".join(key): [dict(run) for run in runs] for key, runs in results.metrics.items()},
        "remarks": list(REMARKS),
    }
    return json.dumps(content, indent=2) + "\n"
