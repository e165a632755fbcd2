"""Show the table of a study, such as the paper's, that is stored with its runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.runs.json_file import read_table
from flexbench.studies.layouts.result_file import RESULT
from flexbench.studies.paper import design_margins
from flexbench.studies.paper.native import read_native
from flexbench.studies.paper.native_table import PORT_HEADER, RUN_HEADER, port_rows, remarks, run_rows
from flexbench.studies.paper.native_table import TITLE as NATIVE_TITLE
from flexbench.studies.paper.published import JUDGED, ROWS, TITLES, VARIANTS
from flexbench.studies.paper.table import FAILED, number, when_lost
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName

TABLE = "table.json"
LOST = "published_design"  # the variant that has no numbers
_DEVIATION = "Deviation: of what flew as published from the published value, ± the standard deviation of one seed."
STUDY_SHAPE = {
    "seeds": ["whole number"],
    "duration": "number",
    "rows": [
        {
            "row": "text", "unit": "text", "variant": "text", "configuration": "text", "published": "number?",
            "mean": "number", "standard_deviation": "number?", "deviation": "text?", "?definition": "text",
        }
    ],
    "?failed": [
        {
            "run": "text", "variant": "text", "configuration": "text", "scenario": "text", "seed": "whole number",
            "cause": "text", "folder": "text",
        }
    ],
    "?published_design_lost_at": {"*": ["number?"]},  # s, by configuration, for each seed
    "remarks": ["text"],
}  # fmt: skip


def study_folders(paths: Sequence[Path]) -> list[Path]:
    """Return the folders that hold the table of a study, or a comparison of layouts."""
    return [path for path in paths if any((path / name).is_file() for name in (TABLE, RESULT))]


def study_table(folder: Path) -> list[Block]:
    """Return a table for each configuration: published, simulated, deviation, and what each quantity is."""
    content = read_table(folder / TABLE, STUDY_SHAPE)
    assert content is not None  # the folder was chosen for it
    rows: list[dict[str, Any]] = content["rows"]
    failed: list[dict[str, Any]] = content.get("failed", [])
    known = {row["variant"] for row in [*rows, *failed]}
    variants = [variant for variant in (*VARIANTS, *sorted(known - set(VARIANTS))) if variant in known - {LOST}]
    blocks: list[Block] = []
    for name in CONFIGURATIONS:
        header = ["quantity", "unit", "published"]
        for variant in variants:
            header += [f"flown {TITLES.get(variant, variant)}", *(["deviation"] if variant == JUDGED else [])]
        lines = list(_lines(name, variants, rows, failed))
        if lines:
            blocks += [Heading(3, name), Table((*header, "definition"), lines, code=frozenset())]
    blocks += [
        Paragraph(
            f"Failed, and excluded from the numbers: {one['run']}: {one['cause'].removesuffix('.')}"
            f" (in {one['folder']})."
        )
        for one in failed
    ]
    seeds = ("seed " if len(content["seeds"]) == 1 else "seeds ") + ", ".join(map(str, content["seeds"]))
    blocks.append(Paragraph(f"Runs of {content['duration']:g} s through the FMUs; {seeds}. {_DEVIATION}"))
    lost: dict[str, list[float | None]] = content.get("published_design_lost_at", {})
    if lost:
        when = "; ".join(f"{name}: {when_lost(times)}" for name, times in lost.items())
        blocks.append(Paragraph(f"Published design on the full plant, fine pointing: {when}."))
    return [*blocks, *(Paragraph(remark) for remark in content["remarks"])]


def _lines(
    name: ConfigurationName,
    variants: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    failed: Sequence[Mapping[str, Any]],
) -> Iterator[list[str]]:
    """Yield the lines of a configuration, with a mark in a cell whose runs failed."""
    found = {(row["row"], row["variant"]): row for row in rows if row["configuration"] == name}
    lacking = {(one["variant"], one["scenario"]) for one in failed if one["configuration"] == name}
    known = {row.label: row for row in ROWS}
    for label in dict.fromkeys([*(row.label for row in ROWS), *(label for label, _ in found)]):
        own = [found[label, variant] for variant in variants if (label, variant) in found]
        scenario = known[label].scenario if label in known else ""
        if own:
            row = own[0]
            line = [label, shown_unit(row), number(row["published"])]
        elif any((variant, scenario) in lacking for variant in variants):
            line = [label, known[label].unit, number(known[label].published_for(name))]
        else:
            continue
        for variant in variants:
            mark = FAILED if (variant, scenario) in lacking else "-"
            cell = found.get((label, variant))
            line += _cells(cell) if cell else [mark, "-"] if variant == JUDGED else [mark]
        definition = own[0].get("definition", "") if own else known[label].definition
        yield [*line, definition]


def margin_blocks(folder: Path) -> list[Block]:
    """Return margins and spillover of the loops that a study flew, nothing if they were not analysed."""
    loops = design_margins.read_margins(folder)
    if not loops:
        return []
    return [
        Paragraph(" ".join(design_margins.sentences(loops))),
        Table(design_margins.HEADER, design_margins.rows(loops), code=frozenset()),
        Paragraph(design_margins.EXPLANATION),
    ]


def shown_unit(row: Mapping[str, Any]) -> str:
    """Return the unit of a row as pages spell it; earlier versions wrote `um`."""
    return str(row["unit"]).replace("um", "µm")


def native_blocks(folder: Path) -> list[Block]:
    """Return what the study found of the native FMUs, nothing if it had none."""
    study = read_native(folder)
    if study is None:
        return []
    runs, ports = run_rows(study), port_rows(study)
    return [
        Heading(3, NATIVE_TITLE),
        *(Paragraph(remark) for remark in remarks(study)),
        Table(RUN_HEADER, runs, code=frozenset()),
        *([Table(PORT_HEADER, ports, code=frozenset())] if ports else []),
    ]


def _cells(row: Mapping[str, Any]) -> list[str]:
    """Return the value of a row with its spread, and its deviation from the paper in the variant as published."""
    spread = row["standard_deviation"]
    value = number(row["mean"]) + (f" ± {number(spread)}" if spread is not None else "")
    return [value, row["deviation"] or "-"] if row["variant"] == JUDGED else [value]
