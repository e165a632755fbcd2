"""The paper's results table next to the numbers of flexsat: as text, Markdown, CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import RUN_DURATION, ConfigurationName
from lockstep.plain_table import plain_lines

from .published import JUDGED, REMARKS, ROWS, TITLES, VARIANTS, PaperRow, VariantName

Key = tuple[VariantName, ConfigurationName, str]  # variant, configuration, scenario
FAILED = "failed"  # in a cell whose runs did
ENOUGH = 4  # seeds from which their scatter is estimated


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
class Failed:
    """A run of a study that failed."""

    key: Key
    seed: int
    folder: Path
    cause: str  # one line
    begun: bool = False  # whether its folder holds what it recorded

    @property
    def text(self) -> str:
        """The run, its cause, and where it is."""
        return f"{self.folder.name}: {self.cause.removesuffix('.')} ({self.folder})"


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """All metrics of a study, by variant, configuration and scenario: one mapping a seed."""

    metrics: Mapping[Key, Sequence[Mapping[str, float]]]
    seeds: Sequence[int]
    duration: float  # s
    lost: Mapping[ConfigurationName, Sequence[float | None]] = field(default_factory=dict)
    # s: when the published design saturates on the corrected plant, by configuration and seed; None: it did not
    failed: Sequence[Failed] = ()  # not among the metrics

    def cell(self, row: PaperRow, variant: VariantName, name: ConfigurationName) -> Cell | None:
        """Return the number of a cell; None if that variant was not run, or its row refers to runs of 300 s."""
        runs = self.metrics.get((variant, name, row.scenario))
        if not runs or (row.of_whole_run and self.duration != RUN_DURATION):
            return None
        values = np.array([run[row.key] for run in runs]) * row.scale
        deviation = float(values.std(ddof=1)) if len(values) > 1 else None
        return Cell(mean=float(values.mean()), deviation=deviation, count=len(values))

    @property
    def variants(self) -> list[VariantName]:
        """The variants that were run and have numbers."""
        return [variant for variant in VARIANTS if any(key[0] == variant for key in self.metrics)]

    def lacks(self, key: Key) -> bool:
        """Return whether a cell has no number because all its runs failed."""
        return not self.metrics.get(key) and any(one.key == key for one in self.failed)


def when_lost(times: Sequence[float | None]) -> str:
    """Return when the published design saturated on the corrected plant: the range over the seeds, None where not."""
    found = sorted(time for time in times if time is not None)
    if len(found) < len(times):
        return f"lost in {len(found)} of {len(times)}"
    return f"lost at {found[0]:.3g} s" if found[0] == found[-1] else f"lost at {found[0]:.3g} to {found[-1]:.3g} s"


def number(value: float) -> str:
    """Format a number with three significant digits, in exponent form only where it is shorter."""
    if value == 0.0:
        return "0"
    if 1e-2 <= abs(value) < 1e4:
        return f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def against_published(row: PaperRow, results: Results, name: ConfigurationName) -> str:
    """Return the deviation of the variant as published from the paper, and the standard deviation of one seed."""
    cell = results.cell(row, JUDGED, name)
    if cell is None:
        return "-"
    published = row.published_for(name)
    scatter = one_seed_scatter(row, name, cell)
    spread = "" if scatter is None else f" ± {100.0 * scatter / published:.0f}"
    return f"{100.0 * (cell.mean / published - 1.0):+.0f}{spread} %"


def one_seed_scatter(row: PaperRow, name: ConfigurationName, cell: Cell) -> float | None:
    """Return the standard deviation of one seed as published: of these runs if there are enough, else as stored."""
    if cell.deviation is not None and cell.count >= ENOUGH:
        return cell.deviation
    stored = _stored_scatter().get(f"{row.label} | {JUDGED} | {name}")
    return stored["standard_deviation"] if stored else None


@cache
def _stored_scatter() -> dict[str, dict[str, float]]:
    """Return mean and standard deviation of one seed by cell, from six seeds."""
    content = json.loads(resources.files(__package__).joinpath("scatter.json").read_text(encoding="utf-8"))
    return dict(content["cells"])


def header(results: Results) -> list[str]:
    """Return the columns of `lines`."""
    columns = ["row", "unit", "published"]
    for variant in results.variants:
        columns.append(TITLES[variant])
        if variant == JUDGED:
            columns.append("deviation")
    return columns + ([TITLES["published_design"]] if results.lost else [])


def lines(results: Results, name: ConfigurationName) -> list[list[str]]:
    """Return the rows of a configuration as texts."""
    found = []
    for row in ROWS:
        line = [row.label, row.unit, number(row.published_for(name))]
        for variant in results.variants:
            cell = results.cell(row, variant, name)
            lacking = results.lacks((variant, name, row.scenario))
            line.append(cell.text if cell else FAILED if lacking else "-")
            if variant == JUDGED:
                line.append(against_published(row, results, name))
        if results.lost:
            times = results.lost.get(name) if row.scenario == "fine_pointing" else None
            lacking = row.scenario == "fine_pointing" and results.lacks(("published_design", name, row.scenario))
            line.append(when_lost(times) if times else FAILED if lacking else "-")
        found.append(line)
    return found


def footnotes(results: Results) -> list[str]:
    """Return seeds, definitions and remarks, a line each."""
    seeds = ", ".join(map(str, results.seeds))
    spread = " (mean ± standard deviation of one seed)" if len(results.seeds) > 1 else ""
    notes = [f"Runs of {results.duration:g} s through the FMUs; seeds {seeds}{spread}."]
    notes += [f"Failed, and excluded from the numbers: {one.text}." for one in results.failed]
    if results.duration != RUN_DURATION:
        notes.append(f"Costs and settling refer to runs of {RUN_DURATION:g} s and are not shown.")
    if JUDGED in results.variants:
        notes.append("Deviation: of as published from published ± standard deviation of one seed, from six seeds.")
    if results.lost:
        notes.append(
            "Corrected, published design: fine pointing with the published weights on the full plant, at its wheel"
            " speeds; the time from which a wheel is at its torque limit to the end of the run."
        )
    notes += [f"{row.label}: {row.definition}{f' ({row.note})' if row.note else ''}." for row in ROWS]
    return notes + list(REMARKS)


def title(name: ConfigurationName) -> str:
    """Return what stands above the table of a configuration."""
    return f"{name}: results of the paper and of flexsat"


def as_text(results: Results) -> str:
    """Return the tables as `flexsat paper` prints them into a file."""
    found = []
    for name in CONFIGURATIONS:
        found += [title(name), *plain_lines([header(results), *lines(results, name)])]
    return "\n".join([*found, *footnotes(results)]) + "\n"


def numbers(results: Results) -> list[tuple[PaperRow, VariantName, ConfigurationName, Cell]]:
    """Return every number that the runs gave."""
    found = []
    for row in ROWS:
        for variant in results.variants:
            for name in CONFIGURATIONS:
                cell = results.cell(row, variant, name)
                if cell is not None:
                    found.append((row, variant, name, cell))
    return found


def as_markdown(results: Results) -> str:
    """Return the tables in Markdown, with their footnotes."""
    parts = []
    for name in CONFIGURATIONS:
        columns = header(results)
        rules = ["---" if column in ("row", "unit") else "---:" for column in columns]
        rows = [[name, *columns[1:]], rules, *lines(results, name)]
        parts.append("\n".join("| " + " | ".join(row) + " |" for row in rows))
    parts.append("\n".join(f"- {note}" for note in footnotes(results)))
    return "\n\n".join(parts) + "\n"


def as_csv(results: Results) -> str:
    """Return one line a number: full precision, in the printed unit."""
    output = io.StringIO()
    writer = csv.writer(output, lineterminator="\n")
    writer.writerow(["row", "unit", "variant", "configuration", "published", "mean", "standard deviation", "seeds"])
    for row, variant, name, cell in numbers(results):
        spread = "" if cell.deviation is None else repr(cell.deviation)
        writer.writerow(
            [row.label, row.unit, variant, name, row.published_for(name), repr(cell.mean), spread, cell.count]
        )
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
                "deviation": against_published(row, results, name) if variant == JUDGED else None,
            }
            for row, variant, name, cell in numbers(results)
        ],
        "published_design_lost_at": {name: list(times) for name, times in results.lost.items()},
        "metrics_si": {" ".join(key): [dict(run) for run in runs] for key, runs in results.metrics.items()},
        "failed": [
            {
                "run": one.folder.name,
                "variant": one.key[0],
                "configuration": one.key[1],
                "scenario": one.key[2],
                "seed": one.seed,
                "cause": one.cause,
                "folder": str(one.folder),
            }
            for one in results.failed
        ],
        "remarks": list(REMARKS),
    }
    return json.dumps(content, indent=2) + "\n"
