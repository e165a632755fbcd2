"""Write the text sections of the page as blocks: summary, numbers, events, system, versions."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexbench.html.document import Block, Heading, Listing, Paragraph, Picture, Table
from flexbench.runs.loop_numbers import LoopNumbers
from flexbench.studies.paper.published import ROWS, PaperRow
from flexbench.studies.paper.table import number
from lockstep import InputError, System, load_system
from lockstep.plan.timeline_svg import timeline_svg
from lockstep.ssp.native_fmu import shown_file
from lockstep.ssp.step_times import timing_of_run
from lockstep.system.clock import nanoseconds

from .results import Result
from .run_data import RunData, is_fault

MOST_EVENTS = 200  # lines of one run
MOST_COLUMNS = 4  # runs side by side
MOST_TICKS = 12  # of a drawn timeline
LONGEST_CELL = 300  # letters
# of the numbers in events: of any, then by kind of event
_UNITS = {
    "stop_time": "s",
    "since": "s",
    "tolerance": "N.m.s",
    "momentum_left": "N.m.s",
    "torque": "N.m",
    "frequency": "Hz",
}
_UNITS_OF = {("torque-saturation", "limit"): "N.m", ("speed-band-left", "band"): "rad/s", ("mode", "limit"): "s"}
_UNITS_OF_QUANTITY = {"pointing error": "rad", "rate": "rad/s", "deformation": "m"}


def summary_blocks(runs: Sequence[RunData]) -> list[Block]:
    """Return a table that describes the runs: one fact a row for a single run, one run a row for several."""
    facts = [_facts_of(run) for run in runs]
    if len(facts) == 1:
        return [Table(("", ""), list(facts[0].items()), code=frozenset())]
    names = ("system", "variant", "seed", "status", "simulated", "wall time", "recorded", "started")
    rows = [[run.result.name, *(one.get(name, "-") for name in names)] for run, one in zip(runs, facts, strict=True)]
    return [Table(("run", *names), rows, code=frozenset())]


def _facts_of(run: RunData) -> dict[str, str]:
    result, record = run.result, run.result.record
    simulated, wall = _simulated(run), float(record.get("wall_time", 0.0))
    speed = f" ({simulated / wall:.1f} x real time)" if wall > 0.0 else ""
    facts = {"system": str(record.get("system", {}).get("name", ""))}
    if result.run is not None:
        facts["variant"] = result.run.variant.label
        facts["seed"] = str(result.run.seed)
    return facts | {
        "status": str(record.get("status", "")),
        "simulated": f"{simulated:g} s of {float(record.get('stop_time', simulated)):g} s",
        "wall time": f"{wall:.1f} s{speed}",
        "recorded": f"{run.recorded} signals every {run.interval * 1e3:g} ms, {run.rows} rows",
        "started": str(record.get("started", "")),
        "folder": str(result.folder),
    }


def scenario_of(result: Result) -> str:
    """Return the scenario of the paper that a run belongs to, named as in its table; empty for other systems."""
    if result.run is None:
        return ""
    if result.run.slew:
        return "slew"
    return "fine_pointing_open_loop" if result.run.open_loop else "fine_pointing"


def _simulated(run: RunData) -> float:
    """Return the simulated time [s]; the record of a run that still goes on does not have it yet."""
    return float(run.result.record.get("simulated_time", 0.0)) or run.end


def run_description(run: RunData) -> str:
    """Return a short description of a run."""
    result = run.result
    words = [str(result.record.get("system", {}).get("name", ""))]
    if result.run is not None:
        words += [result.run.variant.label, f"seed {result.run.seed}"]
    return ", ".join([*words, f"{_simulated(run):g} s simulated"])


def number_blocks(
    runs: Sequence[RunData], loops: Sequence[LoopNumbers | None], with_metrics: bool = True
) -> list[Block]:
    """Return the paper's metrics next to the published values, if wanted.

    Runs without numbers of a loop, None in `loops`, get statistics of their histories instead.
    """
    blocks: list[Block] = []
    names = [run.result.name for run in runs]
    metrics = [run.result.metrics() if with_metrics else {} for run in runs]
    if any(metrics):
        rows = []
        for row in ROWS:
            cells = [_cell(row, run.result, one) for run, one in zip(runs, metrics, strict=True)]
            if any(cells):
                values = [cell or "-" for cell in cells]
                rows.append([row.label, row.unit, *values, _published(row, runs)])
        if rows:
            header = ["quantity of the paper", "unit", *names, "published"]
            if len(runs) <= MOST_COLUMNS:
                header.append("definition")
                rows = [[*row, definition] for row, definition in zip(rows, _definitions(rows), strict=True)]
                blocks.append(_narrow(header, rows, len(runs)))
            else:
                text = "; ".join(f"{row[0]}: {what}" for row, what in zip(rows, _definitions(rows), strict=True))
                blocks += [_narrow(header, rows, len(runs)), Paragraph(f"Definitions: {text}.")]
    runs = [run for run, loop in zip(runs, loops, strict=True) if loop is None]
    names = [run.result.name for run in runs]
    rows = []
    for name, unit in dict.fromkeys((one.name, one.unit) for run in runs for one in run.statistics):
        found = [next((one for one in run.statistics if one.name == name), None) for run in runs]
        rows.append([name, unit, *(f"{number(one.late)} / {number(one.largest)}" if one else "-" for one in found)])
    if rows:
        header = ["whole run: RMS of its second half / largest", "unit", *names]
        blocks.append(_narrow(header, rows, len(runs)))
    return blocks


def _narrow(header: Sequence[str], rows: Sequence[Sequence[str]], runs: int) -> Table:
    """Return a table with one column for each run, or with one row for each if there are many."""
    if runs <= MOST_COLUMNS:
        return Table(header, rows, code=frozenset())
    transposed = [list(column) for column in zip(header, *rows, strict=True)]
    return Table(transposed[0], transposed[1:], code=frozenset())


def _cell(row: PaperRow, result: Result, metrics: Mapping[str, float]) -> str:
    if row.scenario != scenario_of(result) or row.key not in metrics:
        return ""
    return number(metrics[row.key] * row.scale)


def _published(row: PaperRow, runs: Sequence[RunData]) -> str:
    """Return the published value for each configuration on the page."""
    results = [run.result for run in runs if scenario_of(run.result) == row.scenario]
    flown = {result.run.configuration for result in results if result.run}
    ordered = sorted(name for name in flown if math.isfinite(row.published_for(name)))
    if len(ordered) == 1:
        return number(row.published_for(ordered[0]))
    return ", ".join(f"{number(row.published_for(name))} {name}" for name in ordered)


def _definitions(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the definition of the quantity in each row."""
    by_label = {row.label: row.definition for row in ROWS}
    return [by_label[row[0]] for row in rows]


def event_blocks(results: Sequence[Result]) -> list[Block]:
    """Return the faults, then the other events, of each run in which something happened between start and end."""
    blocks: list[Block] = []
    for result in results:
        if not something_happened(result):
            continue
        if len(results) > 1:
            blocks.append(Heading(3, result.name))
        faults = [event for event in result.events if is_fault(event)]
        if faults:
            blocks += [Paragraph(f"{len(faults)} fault events."), _event_table(faults)]
        others = [event for event in result.events if not is_fault(event)]
        if others:
            blocks.append(_event_table(others))
        if len(others) > MOST_EVENTS:
            blocks.append(Paragraph(f"{len(others) - MOST_EVENTS} more are in {result.folder / 'events.jsonl'}."))
    return blocks


def something_happened(result: Result) -> bool:
    """Return whether a run has events other than a start and an end as planned."""
    return any(
        not (event.get("event") == "start" or (event.get("event") == "end" and event.get("status") == "completed"))
        for event in result.events
    )


def _event_table(found: Sequence[Mapping[str, Any]]) -> Table:
    rows = []
    for event in found[:MOST_EVENTS]:
        details = {key: value for key, value in event.items() if key not in ("time", "event")}
        text = ", ".join(f"{key}: {_detail(event, key, value)}" for key, value in details.items())
        short = text if len(text) <= LONGEST_CELL else text[: LONGEST_CELL - 1] + "…"
        rows.append([f"{float(event.get('time', 0.0)):.6g}", str(event.get("event", "")), short])
    return Table(("time [s]", "event", "details"), rows, code=frozenset())


def _detail(event: Mapping[str, Any], key: str, value: object) -> str:
    """Return a detail of an event as text, a number with its unit if that is known."""
    if isinstance(value, str):
        return value
    unit = _UNITS_OF.get((str(event.get("event")), key), _UNITS.get(key, ""))
    if key == "value":
        unit = _UNITS_OF_QUANTITY.get(str(event.get("quantity")), "")
    text = f"{value:.9g}" if isinstance(value, float) else json.dumps(value)
    return f"{text} {unit}".strip()


def system_blocks(result: Result) -> list[Block]:
    """Return components, latency contracts and timeline of the system of a run."""
    record = result.record
    components = record.get("component", [])
    rows = [
        [
            c["name"],
            c.get("model", ""),
            shown_file(Path(c.get("source", ""))),
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
        system = _simulated_system(record)
    except (InputError, OSError, KeyError) as error:
        return [*blocks, Paragraph(f"No timeline: {error}")]
    periods = [component.period // system.tick for component in system.components]
    ticks = min(MOST_TICKS, math.lcm(*periods) + 1)
    svg = timeline_svg(system, ticks)
    blocks.append(Picture(svg, "timeline.svg", f"Timeline of steps and connections: the first {ticks} ticks"))
    return blocks


def _simulated_system(record: Mapping[str, Any]) -> System:
    """Return the system as it was simulated: from its file, if unchanged, with the periods and delays of the run."""
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
    """Return versions, hashes, and the text of run.toml."""
    record = result.record
    versions = [[name, str(value)] for name, value in record.get("versions", {}).items()]
    hashes = [
        [c["name"], c.get("model", ""), c.get("sha256", ""), c.get("guid", "")] for c in record.get("component", [])
    ]
    file = record.get("system", {})
    if file.get("sha256"):
        hashes.append(["system file", str(file.get("name", "")), file["sha256"], ""])
    return [
        Table(("package", "version"), versions, code=frozenset()),
        Table(("component", "model", "SHA-256", "GUID"), hashes, code=frozenset({2, 3})),
        Paragraph("run.toml, enough to repeat the run:"),
        Listing(result.text),
    ]
