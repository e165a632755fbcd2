"""Fly a system with several seeds, judge the estimator, leave numbers and a figure."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lockstep import InputError, load_system

from ...html.document import Block, Heading, Paragraph, Table
from ...runs.jobs import Job, run_jobs
from ...runs.run_folder import Run, read_run
from .analysis import SETTLED, Health, analyse
from .replay import MEASURED, recorded, replay
from .statistics import Average

RESULT = "health.json"
HEADER = ("quantity", "average", "95 % if consistent", "degrees of freedom", "verdict")


def run_health(
    system: Path, folder: Path, seeds: Sequence[int], stop: float, overrides: Mapping[str, Any], processes: int | None
) -> Health:
    """Simulate, in parallel, and judge; leave the runs, health.json and figures in `folder`.

    Raises
    ------
    InputError
        If the runs would end before the filter has settled, or the system is none of ours.
    """
    if not stop > 2.0 * SETTLED:
        raise InputError(
            f"--stop {stop:g}: the first {SETTLED:g} s are not judged; simulate more than {2 * SETTLED:g} s"
        )
    patterns = (*load_system(system).record, *MEASURED)
    jobs = [
        Job(
            system=system,
            folder=folder / f"seed{seed}",
            overrides={**overrides, "plant.seed": seed, "sensors.seed": seed},
            stop_time=stop,
            record=patterns,
            metrics=False,
        )
        for seed in seeds
    ]
    run_jobs(jobs, processes)
    runs = {seed: read_run(job.folder) for seed, job in zip(seeds, jobs, strict=True)}
    first = next(iter(runs.values()))
    health = analyse({seed: replay(run) for seed, run in runs.items()}, first.design)
    write_health(health, first, folder)
    return health


def write_health(health: Health, run: Run, folder: Path) -> None:
    """Leave health.json, and the figure as PNG and SVG."""
    from ...figures.drawing import save_figure
    from ...figures.health import estimator_health

    content = {
        "configuration": run.configuration,
        "seeds": list(health.seeds),
        "settled_from": SETTLED,
        "nis": {name: _plain(value) for name, value in health.innovation.items()},
        "nees": {name: _plain(value) for name, value in health.error.items()},
        "whiteness": {
            "bound": health.whiteness.bound,
            "lags_outside": health.whiteness.outside,
            "channels_coloured": health.whiteness.coloured,
        },
    }
    path = folder / RESULT
    partial = path.with_name(f".{RESULT}.partial")
    partial.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    partial.replace(path)
    title = f"{run.configuration}, seeds {health.seeds[0]} to {health.seeds[-1]}"
    save_figure(estimator_health(health, title), folder / "figures", "estimator-health")


def _plain(average: Average) -> dict[str, Any]:
    bounds = [average.low, average.high]
    return {"average": average.value, "bounds": bounds, "freedom": average.freedom, "verdict": average.verdict}


def table_rows(health: Health) -> list[tuple[str, ...]]:
    """Return the table's rows, `HEADER` its columns."""
    rows: list[tuple[str, ...]] = []
    for kind, averages in (("NIS", health.innovation), ("NEES", health.error)):
        for name, average in averages.items():
            bounds = f"{average.low:.3f} to {average.high:.3f}"
            rows.append((f"{kind} {name}", f"{average.value:.3g}", bounds, str(average.freedom), average.verdict))
    return rows


def section(run: Run) -> list[Block]:
    """Return the report's section, or where to get it."""
    heading = Heading(2, "Estimator health")
    if not recorded(run.signals()):
        text = "The measurements were not recorded; `flexsat health SYSTEM` records them, and judges several seeds."
        return [heading, Paragraph(text)]
    try:
        health = analyse({run.seed: replay(run)}, run.design)
    except InputError as error:
        return [heading, Paragraph(str(error))]
    white = health.whiteness
    text = (
        f"Of seed {run.seed}, from {SETTLED:g} s on, per degree of freedom. {100 * white.outside:.0f} % of the "
        "autocorrelations of the innovations lie beyond what white noise exceeds at 5 % of the lags."
    )
    return [heading, Paragraph(text), Table(HEADER, table_rows(health), frozenset())]
