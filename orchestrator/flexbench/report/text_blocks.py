"""What stands on the page as text: facts, numbers, events, system, and versions, as blocks of a document."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexbench.html.document import Block, Heading, Listing, Paragraph, Picture, Table
from flexbench.studies.paper.published import ROWS, Row
from flexbench.studies.paper.table import number
from lockstep import InputError, System, load_system
from lockstep.plan.timeline_svg import timeline_svg
from lockstep.ssp.step_times import timing_of_run
from lockstep.system.clock import nanoseconds

from .results import Result
from .run_data import RunData, is_fault

MOST_EVENTS = 200  # lines of one run
MOST_COLUMNS = 4  # runs side by side
MOST_TICKS = 12  # of a drawn timeline
LONGEST_CELL = 300  # letters


def summary_blocks(contents: Sequence[RunData]) -> list[Block]:
    """Return what the runs were: one below the other for a single run, a row each for several."""
    told = [_facts_of(content) for content in contents]
    if len(told) == 1:
        return [Table(("", ""), list(told[0].items()), code=frozenset())]
    names = ("system", "variant", "seed", "status", "simulated", "wall time", "recorded", "begun")
    rows = [[c.result.name, *(one.get(name, "-") for name in names)] for c, one in zip(contents, told, strict=True)]
    return [Table(("run", *names), rows, code=frozenset())]


def _facts_of(content: RunData) -> dict[str, str]:
    result, record = content.result, content.result.record
    simulated, wall = _simulated(content), float(record.get("wall_time", 0.0))
    speed = f" ({simulated / wall:.1f} x real time)" if wall > 0.0 else ""
    told = {"system": str(record.get("system", {}).get("name", ""))}
    if result.run is not None:
        told["variant"] = "as published" if result.run.as_published else "corrected"
        told["seed"] = str(result.run.seed)
    return told | {
        "status": str(record.get("status", "")),
        "simulated": f"{simulated:g} s of {float(record.get('stop_time', simulated)):g} s",
        "wall time": f"{wall:.1f} s{speed}",
        "recorded": f"{content.recorded} signals every {content.interval * 1e3:g} ms, {content.rows} rows",
        "begun": str(record.get("started", "")),
        "folder": str(result.folder),
    }


def scenario_of(result: Result) -> str:
    """Return which of the paper's scenarios a run is, as in its table."""
    if result.run is None:
        return ""
    if result.run.slew:
        return "slew"
    return "fine_pointing_open_loop" if result.run.open_loop else "fine_pointing"


def _simulated(content: RunData) -> float:
    """Return how far a run came [s]: one that still goes on has not yet said so itself."""
    return float(content.result.record.get("simulated_time", 0.0)) or content.end


def run_description(content: RunData) -> str:
    """Return what a run was in a few words."""
    result = content.result
    words = [str(result.record.get("system", {}).get("name", ""))]
    if result.run is not None:
        words += ["as published" if result.run.as_published else "corrected", f"seed {result.run.seed}"]
    return ", ".join([*words, f"{_simulated(content):g} s simulated"])


def number_blocks(contents: Sequence[RunData], with_metrics: bool = True) -> list[Block]:
    """Return the metrics of the paper beside its values, if wanted, and what the histories come to."""
    blocks: list[Block] = []
    metrics = [content.result.metrics() if with_metrics else {} for content in contents]
    if any(metrics):
        rows = []
        for row in ROWS:
            cells = [_cell(row, content.result, one) for content, one in zip(contents, metrics, strict=True)]
            if any(cells):
                values = [cell or "-" for cell in cells]
                rows.append([row.label, row.unit, *values, _published(row, contents)])
        if rows:
            header = ("the paper's quantities", "unit", *(c.result.name for c in contents), "published")
            blocks += [_narrow(header, rows, len(contents))]
            blocks += [Paragraph("What the quantities are:"), Listing("\n".join(_definitions(rows)))]
    names = list(dict.fromkeys((n.name, n.unit) for content in contents for n in content.numbers))
    rows = []
    for name, unit in names:
        found = [next((n for n in content.numbers if n.name == name), None) for content in contents]
        rows.append([name, unit, *(f"{number(n.late)} / {number(n.largest)}" if n else "-" for n in found)])
    if rows:
        header = ("RMS of the second half / largest", "unit", *_names(contents))
        blocks.append(_narrow(header, rows, len(contents)))
    return blocks


def _narrow(header: Sequence[str], rows: Sequence[Sequence[str]], runs: int) -> Table:
    """Return a table with a column a run, or with a row each if there are many."""
    if runs <= MOST_COLUMNS:
        return Table(header, rows, code=frozenset())
    turned = [list(column) for column in zip(header, *rows, strict=True)]
    return Table(turned[0], turned[1:], code=frozenset())


def _names(contents: Sequence[RunData]) -> list[str]:
    return [content.result.name for content in contents]


def _cell(row: Row, result: Result, metrics: Mapping[str, float]) -> str:
    if row.scenario != scenario_of(result) or row.key not in metrics:
        return ""
    return number(metrics[row.key] * row.scale)


def _published(row: Row, contents: Sequence[RunData]) -> str:
    """Return the paper's value, of each configuration that is on the page."""
    present = {c.result.run.configuration for c in contents if c.result.run and scenario_of(c.result) == row.scenario}
    ordered = sorted(present)
    if len(ordered) == 1:
        return number(row.published_for(ordered[0]))
    return ", ".join(f"{number(row.published_for(name))} {name}" for name in ordered)


def _definitions(rows: Sequence[Sequence[str]]) -> list[str]:
    labels = {row[0] for row in rows}
    return [f"{row.label}: {row.definition}" for row in ROWS if row.label in labels]


def event_blocks(results: Sequence[Result]) -> list[Block]:
    """Return faults, then all events, of each run."""
    blocks: list[Block] = []
    for result in results:
        if len(results) > 1:
            blocks.append(Heading(3, result.name))
        faults = [event for event in result.events if is_fault(event)]
        if faults:
            blocks += [Paragraph(f"{len(faults)} fault events."), _event_table(faults)]
        others = [event for event in result.events if not is_fault(event)]
        blocks.append(_event_table(others) if others else Paragraph("No events were recorded."))
        if len(others) > MOST_EVENTS:
            blocks.append(Paragraph(f"{len(others) - MOST_EVENTS} more stand in {result.folder / 'events.jsonl'}."))
    return blocks


def _event_table(found: Sequence[Mapping[str, Any]]) -> Table:
    rows = []
    for event in found[:MOST_EVENTS]:
        details = {key: value for key, value in event.items() if key not in ("time", "event")}
        text = ", ".join(
            f"{key}: {value if isinstance(value, str) else json.dumps(value)}" for key, value in details.items()
        )
        short = text if len(text) <= LONGEST_CELL else text[: LONGEST_CELL - 1] + "…"
        rows.append([f"{float(event.get('time', 0.0)):.6g}", str(event.get("event", "")), short])
    return Table(("time [s]", "event", "details"), rows, code=frozenset())


def system_blocks(result: Result) -> list[Block]:
    """Return components, latency contracts, and who runs when."""
    record = result.record
    components = record.get("component", [])
    rows = [
        [
            c["name"],
            c.get("model", ""),
            Path(c.get("source", "")).name,
            f"{c.get('period', 0.0) * 1e3:g}",
            c.get("kind", ""),
        ]
        for c in components
    ]
    blocks: list[Block] = [Table(("component", "model", "file", "period [ms]", "kind"), rows)]
    latencies = [[one["from"], one["to"], str(one["delay"])] for one in record.get("latency", [])]
    if latencies:
        blocks.append(Table(("from", "to", "delay [ticks]"), latencies))
    try:
        flown = _flown(record)
    except (InputError, OSError, KeyError) as error:
        return [*blocks, Paragraph(f"No timeline: {error}")]
    periods = [component.period // flown.tick for component in flown.components]
    ticks = min(MOST_TICKS, math.lcm(*periods) + 1)
    drawn = timeline_svg(flown, ticks)
    blocks.append(Picture(drawn, "timeline.svg", f"Who runs when and what travels where: the first {ticks} ticks"))
    return blocks


def _flown(record: Mapping[str, Any]) -> System:
    """Return the system as it was run: from its file, if that is still the same, with the run's periods and delays."""
    path = Path(record["system"]["path"])
    loaded = load_system(path, timing_of_run(record))
    if loaded.sha256 != record["system"]["sha256"]:
        raise InputError(f"the system file {path} has changed since the run")
    for component in record["component"]:
        period = nanoseconds(component["period"], component["name"])
        if loaded.component(component["name"]).period != period:
            loaded = loaded.with_period(component["name"], period)
    delays = {(c.from_component, c.to_component, c.delay) for c in loaded.connections}
    for one in record.get("latency", []):
        if (one["from"], one["to"], one["delay"]) not in delays:
            loaded = loaded.with_delay(one["from"], one["to"], one["delay"])
    return loaded


def version_blocks(result: Result) -> list[Block]:
    """Return versions, hashes, and all of run.toml."""
    record = result.record
    versions = [[name, str(value)] for name, value in record.get("versions", {}).items()]
    hashes = [
        [c["name"], c.get("model", ""), c.get("sha256", ""), c.get("guid", "")] for c in record.get("component", [])
    ]
    described = record.get("system", {})
    if described.get("sha256"):
        hashes.append(["system file", str(described.get("name", "")), described["sha256"], ""])
    return [
        Table(("package", "version"), versions, code=frozenset()),
        Table(("of", "model", "SHA-256", "guid"), hashes, code=frozenset({2, 3})),
        Paragraph("run.toml, all it takes to repeat the run:"),
        Listing(result.text),
    ]
