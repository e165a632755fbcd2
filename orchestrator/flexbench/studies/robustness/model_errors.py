"""Robustness to model errors: the plant differs from what the controller was designed on, which does not know."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ARCSECOND, DEFAULT_DESIGN, ConfigurationName, ControllerDesign
from lockstep import InputError, Signals, load_system

from ...engine.jobs import Job, run_jobs
from ...loop.chosen_spacecraft import slew_of
from ...loop.fmu_choice import PrintLine, choose_fmus, silent
from ...loop.scenarios import ScenarioName, Value, scalar_overrides, scenario_parameters
from ...loop.spacecraft import designs_for
from ...runs import histories
from ...runs.json_file import write_json
from ...runs.metrics import root_mean_square
from ...runs.run_folder import Run, read_run

LIMIT_CYCLE = 5.0  # N.m, RMS of the sum of |torque|: PHYSICS section 6, a loop beyond its margin reaches more
PAPER_TORQUE = 26.4  # N.m: sum of the torque limits of the paper's wheels; of others the limit is the same share
GROWTH = 2.0  # of the torque from the third quarter of a run to the fourth: beyond it the loop has not settled
RESULT = "robustness.json"
NOMINAL = "nominal"
MODES = "modes"
KINDS = {
    "frequency": ("all higher", "all lower", "random"),
    "damping": ("all higher", "all lower", "random"),
    "inertia": ("all higher", "all lower", "random"),
    "participation": ("all lower", "random lower"),  # the modes carry nearly all of the mass: they cannot carry more
}
LEVELS: dict[str, tuple[float, ...]] = {
    "frequency": (0.01, 0.02, 0.05),
    "damping": (0.5,),
    "inertia": (0.1,),
    "participation": (0.1,),
}
MOST = {"frequency": 0.5, "damping": 1.0, "inertia": 0.5, "participation": 0.5}  # relative
MODE_COUNTS = (25, 40, 100)  # and all that the plant has, which is the nominal one
VARIED = (*LEVELS, MODES)
_STREAM = 5  # of the draws, apart from those of plant and sensors


@dataclass(frozen=True, slots=True, kw_only=True)
class Variation:
    """One error of the plant."""

    what: str = NOMINAL  # of VARIED, or nominal
    kind: str = ""  # of KINDS
    level: float = 0.0  # relative error, or its standard deviation; the number of modes

    @property
    def title(self) -> str:
        """The error in words."""
        if self.what == NOMINAL:
            return NOMINAL
        if self.what == MODES:
            return f"{self.level:g} modes"
        return f"{self.what} {self.kind}, {100 * self.level:g} %"

    def parameters(self, seed: int, modes: int) -> dict[str, Value | tuple[float, ...]]:
        """Return parameters of the plant, which has so many modes; `random` draws from a normal distribution.

        With less inertia the modes must carry less of it.
        """
        if self.what == NOMINAL:
            return {}
        if self.what == MODES:
            return {"modes": int(self.level)}
        count = 3 if self.what == "inertia" else modes
        drawn = np.random.default_rng([seed, _STREAM]).normal(0.0, self.level, count)
        errors = {
            "all higher": np.full(count, self.level),
            "all lower": np.full(count, -self.level),
            "random": drawn,
            "random lower": -np.abs(drawn),
        }[self.kind]
        errors = np.maximum(errors, -LARGEST[self.what])  # a draw far out would turn a sign
        given: dict[str, Value | tuple[float, ...]] = {f"dispersion.{self.what}": tuple(errors.tolist())}
        if self.what == "inertia" and errors.min() < 0.0:
            given["dispersion.participation"] = (float(np.sqrt(1.0 + errors.min()) - 1.0),) * modes
        return given


LARGEST = {"frequency": 0.9, "damping": 1.0, "inertia": 0.9, "participation": 1.0}  # downwards


@dataclass(frozen=True, slots=True, kw_only=True)
class VariationPlan:
    """What is varied, and by how much."""

    levels: dict[str, tuple[float, ...]] = field(default_factory=lambda: dict(LEVELS))  # relative errors
    modes: tuple[int, ...] = MODE_COUNTS

    def variations(self) -> Iterator[Variation]:
        """Yield the nominal plant first, then every error."""
        yield Variation()
        for what, levels in self.levels.items():
            yield from (Variation(what=what, kind=kind, level=level) for level in levels for kind in KINDS[what])
        yield from (Variation(what=MODES, level=count) for count in self.modes)

    def check(self, stop: float, carried: int) -> None:
        """Raise InputError for levels, mode counts or a stop time that cannot be simulated.

        `carried` is the number of modes that the plant has.
        """
        for what, levels in self.levels.items():
            option, most = "levels" if what == "frequency" else what, MOST[what]
            for level in levels:
                if not 0.0 < level <= most:
                    raise InputError(
                        f"--{option} {100 * level:g}: must be a percentage above 0, at most {100 * most:g}"
                    )
        for count in self.modes:
            if not 1 <= count <= carried:
                raise InputError(f"--modes {count}: must be from 1 to {carried}, what the plant has")
        if not stop >= 4.0:
            raise InputError(f"--stop-time {stop:g}: quarters of the run are compared; simulate 4 s or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class VariedRun:
    """What one run shows in its last quarter, and its growth from the third."""

    configuration: str
    what: str  # frequency, damping, inertia, participation, modes, or nominal
    kind: str  # all higher, all lower, or random
    level: float  # relative error of each, or its standard deviation; the number of modes
    seed: int
    torque: float  # N.m, RMS of the sum over the wheels
    growth: float  # of it, from the third quarter
    pointing_error: float  # rad
    deformation: float  # m
    stable: bool


def run_robustness(
    fmus: Path,
    folder: Path,
    names: Sequence[ConfigurationName],
    scenario: ScenarioName,
    plan: VariationPlan,
    seeds: Sequence[int],
    stop: float,
    modes: int,
    processes: int | None = None,
    controller_design: ControllerDesign = DEFAULT_DESIGN,
    python: bool = False,
    report: PrintLine = silent,
) -> list[VariedRun]:
    """Simulate every error with every seed, in parallel; write the runs and robustness.json to `folder`.

    Parameters
    ----------
    plan : what is varied
    modes : of the plant
    controller_design : of the controller in every run
    python : simulate the FMUs in Python; else the native ones where they are built
    report : called with the kind of the FMUs, as a line
    """
    plan.check(stop, modes)
    chosen = choose_fmus([load_system(fmus / name / f"{scenario}.ssd") for name in names], python)
    report(chosen.text)
    jobs: dict[tuple[ConfigurationName, Variation, int], Job] = {}
    for name in names:
        slew = slew_of(name, fmus / name / "plant.fmu")
        for seed in seeds:
            for variation in plan.variations():
                parameters = scenario_parameters(scenario, seed=seed, slew=slew)
                parameters["plant"] |= variation.parameters(seed, modes)
                title = variation.title.replace(", ", "-").replace(" %", "").replace(" ", "-")
                jobs[name, variation, seed] = Job(
                    system=fmus / name / f"{scenario}.ssd",
                    folder=folder / f"{name}-{title}-seed{seed}",
                    overrides={**scalar_overrides(parameters), "controller.design": controller_design},
                    stop_time=stop,
                    metrics=False,
                    native=chosen.native,
                )
    run_jobs(list(jobs.values()), processes)
    limits = {name: limit_cycle(name, fmus / name / "plant.fmu") for name in names}
    runs = [(variation, read_run(job.folder)) for (_, variation, _), job in jobs.items()]
    outcomes = [judge(run, run.samples(), variation, limits[run.configuration]) for variation, run in runs]
    write_json(folder / RESULT, [{**asdict(outcome), "fmus": chosen.kind} for outcome in outcomes])
    return outcomes


def limit_cycle(name: ConfigurationName, plant: Path) -> float:
    """Return the torque of a limit cycle [N.m]: the share of what the wheels can give that 5 N.m is of the paper's."""
    if name in CONFIGURATIONS:
        return LIMIT_CYCLE
    matrices = designs_for(name, plant).corrected.plant
    return LIMIT_CYCLE / PAPER_TORQUE * float(np.sum(np.broadcast_to(matrices.torque_limit, len(matrices.wheel_axis))))


def fewer_than(modes: int) -> tuple[int, ...]:
    """Return the default mode counts that are less than what a plant has."""
    return tuple(count for count in MODE_COUNTS if count < modes)


def judge(run: Run, signals: Signals, variation: Variation, limit: float = LIMIT_CYCLE) -> VariedRun:
    """Judge a run: stable if the torque at its end is below a limit cycle's and no longer grows.

    Parameters
    ----------
    run : that made the signals
    signals : of it
    variation : error of its plant
    limit : torque of a limit cycle [N.m], RMS of the sum over the wheels
    """
    quarter = len(signals.time) // 4
    third, fourth = slice(2 * quarter, 3 * quarter), slice(3 * quarter, None)
    torque = histories.torque_norm(signals)
    before, after = root_mean_square(torque[third]), root_mean_square(torque[fourth])
    growth = after / before if before > 0.0 else np.inf
    return VariedRun(
        configuration=run.configuration,
        what=variation.what,
        kind=variation.kind,
        level=variation.level,
        seed=run.seed,
        torque=after,
        growth=float(growth),
        pointing_error=root_mean_square(histories.pointing_error(signals)[fourth]),
        deformation=root_mean_square(histories.deformation(signals)[fourth]),
        stable=bool(after < limit and growth < GROWTH),
    )


HEADER = ("configuration", "error", "runs", "unstable", "torque [N.m]", "pointing error [arcsec]", "deformation [µm]")


def table_rows(outcomes: Sequence[VariedRun]) -> list[tuple[str, ...]]:
    """Return a row for each configuration and error: the worst of its seeds."""
    groups: dict[tuple[str, str], list[VariedRun]] = {}
    for outcome in outcomes:
        error = Variation(what=outcome.what, kind=outcome.kind, level=outcome.level).title
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
