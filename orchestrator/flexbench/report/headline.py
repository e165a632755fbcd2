"""The first screen of a page: what was flown, the answer in sentences with numbers, and where it comes from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median

from flexbench.html.document import Block, Paragraph
from flexbench.runs.json_file import read_table
from flexbench.runs.loop_numbers import QUANTITIES, LoopNumbers, loop_numbers
from flexbench.runs.loop_table import notes
from flexbench.runs.run_folder import Run
from flexbench.studies.paper.published import JUDGED
from flexbench.studies.paper.table import number, when_lost
from flexsat.description.built_in import CONFIGURATIONS
from lockstep import InputError

from .results import Result
from .study_table import STUDY_SHAPE, TABLE, shown_unit

CITATION = (
    "The spacecraft and the published numbers: P. Cachim, W. Kraus, Z. Manchester, P. Lourenço, R. Ventura, Optimal "
    "Attitude Control of Large Flexible Space Structures with Distributed Momentum Actuators, IEEE Aerospace "
    "Conference 2025, arXiv 2410.07376."
)
MOST_DESCRIBED = 6  # runs
_SAID = ("pointing_error", "deformation", "torque")
_FINE = ("fine pointing: error", "fine pointing: torque", "deformation, closed loop")  # rows of the paper's table
_ENDED = {
    "interrupted": "was interrupted",
    "running": "has not ended, or was killed",
    "terminated": "was ended by a component",
}
_CLOSE = 0.3  # share of the published value


def headline_blocks(results: Sequence[Result], studies: Sequence[Path]) -> list[Block]:
    """Return the first blocks of a page; of the paper's study if the page has it, else of its runs."""
    blocks: list[Block] = []
    for folder in studies:
        blocks += _of_study(folder, results)
    runs = [result for result in results if result.run is not None]
    if not blocks and 0 < len(runs) <= MOST_DESCRIBED:
        for result in runs:
            blocks.append(Paragraph(" ".join(_of_run(result, named=len(results) > 1))))
    if any(result.run is not None and result.run.configuration in CONFIGURATIONS for result in results):
        blocks.append(Paragraph(CITATION))
    return blocks


def _of_run(result: Result, named: bool) -> Iterator[str]:
    """Yield what one run flew, how it ended, and the numbers of its last window."""
    assert result.run is not None
    yield f"{result.name}: {flown(result)}." if named else f"Flown: {flown(result)}."
    status = str(result.record.get("status", ""))
    if status != "completed":
        reason = " ".join(str(result.record.get("reason", "")).split()).removesuffix(".")
        yield f"The run {_ENDED.get(status, status)}{reason and ': '}{reason}."
    try:
        numbers = loop_numbers(result.folder)
    except InputError:  # nothing of the loop was recorded
        return
    if numbers.windows:
        yield _numbers(numbers)
        yield from list(notes(numbers))[1:]
    found = [str(one.get("kind", "")) for one in result.record.get("found", [])]
    if found:
        yield f"The run had {', '.join(dict.fromkeys(found))}."


def flown(result: Result) -> str:
    """Return what a run flew: spacecraft, controller, scenario, seed, length."""
    run: Run | None = result.run
    assert run is not None
    scenario = "a slew" if run.slew else "fine pointing in open loop" if run.open_loop else "fine pointing"
    modes = ""
    try:
        design = run.flown
        modes = f" of {len(design.wheel_axis)} wheels"
    except InputError:
        pass
    length = float(result.record.get("simulated_time", 0.0))
    return f"{scenario} of the {run.configuration} layout{modes}, {run.variant.flown}, seed {run.seed}, {length:g} s"


def _numbers(numbers: LoopNumbers) -> str:
    last = numbers.windows[-1]
    parts = [
        f"{quantity.label} {last.rms[quantity.key] / quantity.scale:.3g} {quantity.unit} RMS "
        f"({last.peak[quantity.key] / quantity.scale:.3g} at most)"
        for quantity in QUANTITIES
        if quantity.key in _SAID and quantity.key in last.rms
    ]
    window = last.window.text
    return f"{window[0].upper()}{window[1:]}: {', '.join(parts)}." if parts else ""


def _of_study(folder: Path, results: Sequence[Result]) -> list[Block]:
    """Return the answer of the paper's study: the published controller, the robust one, the agreement."""
    if not (folder / TABLE).is_file():
        return []
    content = read_table(folder / TABLE, STUDY_SHAPE)
    assert content is not None
    rows = content["rows"]
    seeds = ("seed " if len(content["seeds"]) == 1 else "seeds ") + ", ".join(str(seed) for seed in content["seeds"])
    sentences = [
        f"The paper's runs of {content['duration']:g} s through the FMUs, {seeds}: slew and fine pointing of "
        "both layouts of wheels."
    ]
    if failed := content.get("failed", []):
        shown = {result.folder.name: result.name for result in results}
        names = ", ".join(shown.get(one["run"], one["run"]) for one in failed)
        sentences.append(f"Failed, and excluded from the paper's table: {names}; the cause is below the table.")
        if any(one["run"] in shown for one in failed):
            sentences.append("What they recorded before they failed is on this page.")
    lost: Mapping[str, Sequence[float | None]] = content.get("published_design_lost_at", {})
    if lost:
        when = "; ".join(f"{name}: {when_lost(list(times))}" for name, times in lost.items())
        sentences.append(f"On the structure with all its modes the published controller does not stay stable ({when}).")
    for name in CONFIGURATIONS:
        cells = [_fine(rows, name, quantity) for quantity in _FINE]
        if any(cells):
            sentences.append(
                f"The robust design in fine pointing, {name}: {', '.join(cell for cell in cells if cell)}."
            )
    ratios = [row["mean"] / row["published"] for row in rows
              if row["variant"] == JUDGED and row["published"] and math.isfinite(row["mean"])]  # fmt: skip
    if ratios:
        close = sum(abs(ratio - 1.0) <= _CLOSE for ratio in ratios)
        sentences.append(
            f"As published, {close} of {len(ratios)} numbers lie within {100 * _CLOSE:.0f} % of the paper's "
            f"(median ratio {median(ratios):.2f}); the table below has all of them, and its remarks explain the others."
        )
    return [Paragraph(" ".join(sentences))]


def _fine(rows: Sequence[Mapping[str, object]], configuration: str, label: str) -> str:
    for row in rows:
        if (row["row"], row["configuration"], row["variant"]) == (label, configuration, "corrected"):
            value, published = (number(float(str(row[key]))) for key in ("mean", "published"))
            return f"{label.removeprefix('fine pointing: ')} {value} {shown_unit(row)} (published {published})"
    return ""
