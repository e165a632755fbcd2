"""Show the table of a study, such as the paper's, that is stored with its runs."""

from __future__ import annotations

from collections.abc import Sequence
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
STUDY_SHAPE = {
    "seeds": ["whole number"],
    "duration": "number",
    "rows": [
        {
            "row": "text", "unit": "text", "variant": "text", "configuration": "text", "published": "number?",
            "mean": "number", "standard_deviation": "number?", "deviation": "text?",
        }
    ],
    "?published_design_lost_at": {"*": ["number?"]},  # s, by configuration, for each seed
    "remarks": ["text"],
}  # fmt: skip


def study_folders(paths: Sequence[Path]) -> list[Path]:
    """Return the folders that hold the table of a study, or a comparison of layouts."""
    return [path for path in paths if any((path / name).is_file() for name in (TABLE, RESULT))]


def study_table(folder: Path) -> list[Block]:
    """Return a table for each configuration: the published value and those of the runs."""
    content = read_table(folder / TABLE, STUDY_SHAPE)
    assert content is not None  # the folder was chosen for it
    rows: list[dict[str, Any]] = content["rows"]
    variants = list(dict.fromkeys(row["variant"] for row in rows))
    blocks: list[Block] = []
    for name in CONFIGURATIONS:
        lines: dict[str, list[str]] = {}
        for row in rows:
            if row["configuration"] == name:
                line = lines.setdefault(row["row"], [row["row"], row["unit"], number(row["published"])])
                line.append(_with_spread(row) + (f" ({row['deviation']})" if row["deviation"] else ""))
        header = (
            "quantity",
            "unit",
            "published",
            *(f"flexsat, {TITLES.get(variant, variant)}" for variant in variants),
        )
        if lines:
            blocks += [Heading(3, name), Table(header, list(lines.values()), code=frozenset())]
    seeds = ", ".join(str(seed) for seed in content["seeds"])
    blocks.append(Paragraph(f"Runs of {content['duration']:g} s through the FMUs; seeds {seeds}."))
    lost: dict[str, list[float | None]] = content.get("published_design_lost_at", {})
    if lost:
        when = "; ".join(f"{name}: {when_lost(times)}" for name, times in lost.items())
        blocks.append(Paragraph(f"Published design on the full plant, fine pointing: {when}."))
    return [*blocks, *(Paragraph(remark) for remark in content["remarks"]), *_native(folder)]


def _native(folder: Path) -> list[Block]:
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


def _with_spread(row: dict[str, Any]) -> str:
    spread = row["standard_deviation"]
    return number(row["mean"]) + (f" ± {number(spread)}" if spread is not None else "")
