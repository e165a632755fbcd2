"""Simulate a system with several seeds and judge its estimator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lockstep import InputError, System, load_system
from lockstep.plan.overrides import refuse_unknown
from lockstep.results.table_file import open_table

from ...engine.jobs import Job, run_jobs
from ...loop.fmu_choice import PrintLine, choose_fmus, silent
from ...runs.json_file import write_json
from ...runs.run_folder import read_run
from .analysis import SETTLED, Health, analyse
from .replay import MEASURED, replay
from .statistics import Average

RESULT = "health.json"
FED = "plant.external.torque"
SEEDED = ("plant.seed", "sensors.seed")
HEADER = ("quantity", "average", "95 % if consistent", "degrees of freedom", "assessment")


def run_health(
    system: Path,
    folder: Path,
    seeds: Sequence[int],
    stop: float,
    overrides: Mapping[str, Any],
    processes: int | None,
    python: bool = False,
    report: PrintLine = silent,
    inputs: Sequence[Path] = (),
) -> Health:
    """Simulate all seeds in parallel and judge them; write the runs and health.json to `folder`.

    Parameters
    ----------
    system, seeds, stop, overrides, processes : of the runs
    python : simulate the FMUs in Python; else the native ones where they are built
    report : called with the kind of the FMUs, as a line
    inputs : files of signals for inputs, in all runs the same

    Raises
    ------
    InputError
        If the runs would end before the filter has settled, or the system is not one of flexsat.
    """
    if not stop > 2.0 * SETTLED:
        raise InputError(
            f"--stop-time {stop:g}: the first {SETTLED:g} s are not judged; simulate more than {2 * SETTLED:g} s"
        )
    loaded = load_system(system)
    for name in SEEDED:
        if name in overrides:
            raise InputError(f"--set {name}={overrides[name]}: each run has a seed of its own; give --seeds N")
    refuse_unknown(overrides, loaded)
    chosen = choose_fmus([loaded], python)
    report(chosen.text)
    torque = _torque_source(loaded, inputs)
    patterns = (*loaded.record, *MEASURED, *([] if torque is None else [torque]))
    jobs = [
        Job(
            system=system,
            folder=folder / f"seed{seed}",
            overrides={**overrides, **dict.fromkeys(SEEDED, seed)},
            stop_time=stop,
            record=patterns,
            metrics=False,
            native=chosen.native,
            inputs=tuple(inputs),
        )
        for seed in seeds
    ]
    run_jobs(jobs, processes)
    runs = {seed: read_run(job.folder) for seed, job in zip(seeds, jobs, strict=True)}
    first = next(iter(runs.values()))
    health = analyse({seed: replay(run, slow=True, torque=torque) for seed, run in runs.items()}, first.design)
    write_health(health, folder, chosen.kind)
    return health


def _torque_source(system: System, inputs: Sequence[Path] = ()) -> str | None:
    """Return what gives the external torque on the plant, as component and port; None: it is constant.

    Of a file of signals it is the plant's input itself, which the run records as it was.

    Raises
    ------
    InputError
        If the controller reads from something else than the sensors: a replay of it needs what they measured.
    """
    for one in system.connections:
        if one.to_component == "controller" and one.from_component != "sensors":
            raise InputError(
                f"{system.name}: controller.{one.input} comes from {one.from_component}; the estimator is judged where"
                " sensors alone feed the controller: in environment.ssd for that of a mission"
            )
    into = "external.torque[1]"
    for one in system.connections:
        if (one.to_component, one.input) == ("plant", into):
            return f"{one.from_component}.{one.output.partition('[')[0]}"
    return FED if any(name.startswith(FED) for path in inputs for name in open_table(path).names) else None


def write_health(health: Health, folder: Path, fmus: str) -> None:
    """Write health.json to the folder; `fmus` is the kind of the runs' FMUs."""
    content = {
        "configuration": health.configuration,
        "seeds": list(health.seeds),
        "fmus": fmus,
        "settled_from": health.settled_from,
        "nis": {name: _plain(value) for name, value in health.innovation.items()},
        "nees": {name: _plain(value) for name, value in health.error.items()},
        "whiteness": {
            "bound": health.whiteness.bound,
            "lags_outside": health.whiteness.outside,
            "channels_coloured": health.whiteness.coloured,
        },
    }
    write_json(folder / RESULT, content)


def _plain(average: Average) -> dict[str, Any]:
    bounds = [average.low, average.high]
    return {"average": average.value, "bounds": bounds, "freedom": average.freedom, "verdict": average.assessment}


def table_rows(health: Health) -> list[tuple[str, ...]]:
    """Return the table's rows, `HEADER` its columns."""
    rows: list[tuple[str, ...]] = []
    for kind, averages in (("NIS", health.innovation), ("NEES", health.error)):
        for name, average in averages.items():
            bounds = f"{average.low:.3f} to {average.high:.3f}"
            rows.append((f"{kind} {name}", f"{average.value:.3g}", bounds, str(average.freedom), average.assessment))
    return rows
