"""Robustness to modal-frequency errors: the plant's modes are shifted, the controller's model is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND, ConfigurationName
from lockstep import InputError, Signals

from ...loop.scenarios import ScenarioName, scalar_overrides, scenario_parameters
from ...runs import histories
from ...runs.jobs import Job, run_jobs
from ...runs.json_file import write_json
from ...runs.metrics import root_mean_square
from ...runs.run_folder import Run, read_run

LEVELS = (0.01, 0.02, 0.05)
LIMIT_CYCLE = 5.0  # N.m, RMS of the sum of |torque|: PHYSICS section 6, a loop beyond its margin reaches more
GROWTH = 2.0  # of the torque from the third quarter of a run to the fourth: beyond it the loop has not settled
RESULT = "robustness.json"
KINDS = ("all higher", "all lower", "random")
_STREAM = 5  # of the draws, apart from those of plant and sensors


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What one run shows in its last quarter, and its growth from the third."""

    configuration: str
    kind: str  # nominal, all higher, all lower, or random
    level: float  # relative error of the frequencies: of each mode, or its standard deviation
    seed: int
    torque: float  # N.m, RMS of the sum over the wheels
    growth: float  # of it, from the third quarter
    pointing_error: float  # rad
    deformation: float  # m
    stable: bool


def frequency_errors(kind: str, level: float, seed: int, modes: int) -> Array:
    """Return the relative error of each modal frequency, (modes,).

    `all higher` and `all lower` shift every mode by the level; `random` draws each from a normal distribution.
    """
    if kind == "random":
        return np.asarray(np.random.default_rng([seed, _STREAM]).normal(0.0, level, modes))
    shift = {"nominal": 0.0, "all higher": level, "all lower": -level}
    if kind not in shift:
        raise InputError(f"{kind!r}: no such kind of error; there are {', '.join(shift)}, random")
    return np.full(modes, shift[kind])


def check_plan(levels: Sequence[float], stop: float) -> None:
    """Raise InputError for levels or a stop time that cannot be simulated."""
    for level in levels:
        if not 0.0 < level < 0.5:
            raise InputError(f"--levels {100 * level:g}: must be a percentage from 0 to 50, zero excluded")
    if not stop >= 4.0:
        raise InputError(f"--stop-time {stop:g}: quarters of the run are compared; simulate 4 s or more")


def run_robustness(
    fmus: Path,
    folder: Path,
    names: Sequence[ConfigurationName],
    scenario: ScenarioName,
    levels: Sequence[float],
    seeds: Sequence[int],
    stop: float,
    modes: int,
    processes: int | None = None,
) -> list[Outcome]:
    """Simulate every level with every seed, in parallel; write the runs and robustness.json to `folder`.

    Parameters
    ----------
    levels : relative errors, such as 0.05; each is simulated with all modes higher, with all lower, and at random
    modes : of the plant
    """
    check_plan(levels, stop)
    plan: dict[tuple[ConfigurationName, str, float, int], Job] = {}
    for name in names:
        for seed in seeds:
            for kind, level in (("nominal", 0.0), *((kind, level) for level in levels for kind in KINDS)):
                parameters = scenario_parameters(scenario, seed=seed)
                parameters["plant"]["dispersion.frequency"] = tuple(frequency_errors(kind, level, seed, modes).tolist())
                title = f"{name}-{kind.replace(' ', '-')}-{100 * level:g}-seed{seed}"
                plan[name, kind, level, seed] = Job(
                    system=fmus / name / f"{scenario}.ssd",
                    folder=folder / title,
                    overrides=scalar_overrides(parameters),
                    stop_time=stop,
                    metrics=False,
                )
    run_jobs(list(plan.values()), processes)
    runs = [(kind, level, read_run(job.folder)) for (_, kind, level, _), job in plan.items()]
    outcomes = [judge(run, run.samples(), kind, level) for kind, level, run in runs]
    write_json(folder / RESULT, [asdict(outcome) for outcome in outcomes])
    return outcomes


def judge(run: Run, signals: Signals, kind: str, level: float) -> Outcome:
    """Judge a run: stable if the torque at its end is below a limit cycle's and no longer grows.

    Parameters
    ----------
    run : that made the signals
    signals : of it
    kind, level : error of the modal frequencies
    """
    quarter = len(signals.time) // 4
    third, fourth = slice(2 * quarter, 3 * quarter), slice(3 * quarter, None)
    torque = histories.torque_norm(signals)
    before, after = root_mean_square(torque[third]), root_mean_square(torque[fourth])
    growth = after / before if before > 0.0 else np.inf
    return Outcome(
        configuration=run.configuration,
        kind=kind,
        level=level,
        seed=run.seed,
        torque=after,
        growth=float(growth),
        pointing_error=root_mean_square(histories.pointing_error(signals)[fourth]),
        deformation=root_mean_square(histories.deformation(signals)[fourth]),
        stable=bool(after < LIMIT_CYCLE and growth < GROWTH),
    )


HEADER = ("configuration", "error", "runs", "unstable", "torque [N.m]", "pointing error [arcsec]", "deformation [um]")


def table_rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """Return a row for each configuration and error: the worst of its seeds."""
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in outcomes:
        error = outcome.kind if outcome.kind == "nominal" else f"{outcome.kind}, {100 * outcome.level:g} %"
        groups.setdefault((outcome.configuration, error), []).append(outcome)
    return [
        (
            name,
            error,
            str(len(group)),
            str(sum(not outcome.stable for outcome in group)),
            f"{max(outcome.torque for outcome in group):.3g}",
            f"{max(outcome.pointing_error for outcome in group) / ARCSECOND:.3g}",
            f"{1e6 * max(outcome.deformation for outcome in group):.3g}",
        )
        for (name, error), group in groups.items()
    ]
