"""Evaluate a run and write metrics.json to its folder: the loop in its windows, and the rows of the paper's table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from flexsat.parameters import ARCSECOND
from lockstep import InputError

from .flown_design import keep_flown
from .json_file import write_json
from .loop_numbers import LoopNumbers, loop_numbers
from .loop_table import as_json, header, notes, rows
from .run_folder import METRICS, read_run

UNITS = {
    "total_cost": "1",
    "control_cost": "1",
    "pointing_error": "rad",
    "torque": "N.m",
    "wheel_torque": "N.m",
    "rate_error": "rad/s",
    "deformation": "m",
    "settling_time": "s",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluated:
    """What a run came to, in SI."""

    numbers: LoopNumbers
    paper: Mapping[str, float] = field(default_factory=dict)  # rows of its table; empty for another run
    reason: str = ""  # why not


def evaluate(folder: Path, band: float | None = None) -> Evaluated:
    """Evaluate a run with a plant of flexsat and write metrics.json to its folder.

    Parameters
    ----------
    folder : of the run
    band : of settling [rad], as in `loop_numbers`

    Raises
    ------
    InputError
        If it has no plant of flexsat, or recorded nothing of its loop.
    """
    numbers = loop_numbers(folder, band)
    keep_flown(folder)
    paper: Mapping[str, float] = {}
    about: dict[str, object] = {"configuration": numbers.configuration}
    reason = ""
    try:
        run = read_run(folder)
        about |= {**run.variant.switch, "seed": run.seed}
        paper = run.metrics()
    except InputError as error:
        reason = str(error)
    content = {**about, "units": UNITS, "metrics": dict(paper), **as_json(numbers)}
    write_json(folder / METRICS, content)
    return Evaluated(numbers=numbers, paper=paper, reason=reason)


def write_paper_metrics(folder: Path) -> Mapping[str, float]:
    """Evaluate a run and return the metrics of the paper's rows; raise InputError if it does not have them."""
    evaluated = evaluate(folder)
    if not evaluated.paper:
        raise InputError(evaluated.reason)
    return evaluated.paper


def closing_table(
    folder: Path, band_arcsec: float | None = None
) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
    """Evaluate a run and return its numbers as header, rows and notes; a note says why there are none.

    Parameters
    ----------
    folder : of the run
    band_arcsec : of settling; None: that of the attitude sensor
    """
    try:
        numbers = evaluate(folder, None if band_arcsec is None else band_arcsec * ARCSECOND).numbers
    except InputError as error:
        return (), [], [f"no metrics.json: {error}"]
    return (header(numbers), rows(numbers), list(notes(numbers))) if numbers.windows else ((), [], list(notes(numbers)))
