"""Show the table of a study, such as the paper's, that is stored with its runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexbench.html.document import Block, Heading, Paragraph, Table
from flexbench.runs.json_file import read_table
from flexbench.studies.layouts.result_file import RESULT
from flexbench.studies.paper.native import read_native
from flexbench.studies.paper.native_table import PORT_HEADER, RUN_HEADER, port_rows, remarks, run_rows
from flexbench.studies.paper.native_table import TITLE as NATIVE_TITLE
from flexbench.studies.paper.published import TITLES
from flexbench.studies.paper.table import number, when_lost
from flexsat.description.built_in import CONFIGURATIONS

TABLE = "table.json"
PUBLISHED = "as_published"  # the variant that is judged against the paper
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
    variants = list(dict.fromkeys(row["variant"] for row in rows))
    blocks: list[Block] = []
    for name in CONFIGURATIONS:
        lines: dict[str, list[str]] = {}
        definitions: dict[str, str] = {}
        for row in rows:
            if row["configuration"] == name:
                line = lines.setdefault(row["row"], [row["row"], shown_unit(row), number(row["published"])])
                line += _cells(row)
                definitions[row["row"]] = row.get("definition", "")
        header = ["quantity", "unit", "published"]
        for variant in variants:
            header += [f"flown {TITLES.get(variant, variant)}", *(["deviation"] if variant == PUBLISHED else [])]
        for label, line in lines.items():
            line.append(definitions[label])
        if lines:
            blocks += [Heading(3, name), Table((*header, "definition"), list(lines.values()), code=frozenset())]
    seeds = ("seed " if len(content["seeds"]) == 1 else "seeds ") + ", ".join(map(str, content["seeds"]))
    blocks.append(Paragraph(f"Runs of {content['duration']:g} s through the FMUs; {seeds}. {_DEVIATION}"))
    lost: dict[str, list[float | None]] = content.get("published_design_lost_at", {})
    if lost:
        when = "; ".join(f"{name}: {when_lost(times)}" for name, times in lost.items())
        blocks.append(Paragraph(f"Published design on the full plant, fine pointing: {when}."))
    return [*blocks, *(Paragraph(remark) for remark in content["remarks"])]


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


def _cells(row: dict[str, Any]) -> list[str]:
    """Return the value of a row with its spread, and its deviation from the paper in the variant as published."""
    spread = row["standard_deviation"]
    value = number(row["mean"]) + (f" ± {number(spread)}" if spread is not None else "")
    return [value, row["deviation"] or "-"] if row["variant"] == PUBLISHED else [value]
