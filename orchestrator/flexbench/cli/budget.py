"""The command `flexsat budget`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexsat.parameters import RUN_DURATION
from lockstep.cli.command import command
from lockstep.cli.given_options import refuse_given
from lockstep.cli.options import DISTINGUISHED, from_option, option_group, out_option, stop_time_option
from lockstep.cli.outcome import remark, show_table, suggest, wrote
from lockstep.cli.parameter_types import COUNT, DURATION, NUMBER, PATH, SEED
from lockstep.errors import InputError

from .options import DEFAULT_SEED, SETTLED_HELP

if TYPE_CHECKING:
    from ..studies.budget.evaluate import IndexWindows

_EXAMPLES = """
exit code: 0 all requirements pass, 1 one fails, 2 bad input

examples:
  {program} budget results/run --requirements examples/requirements.toml
  {program} budget --split fmus/distributed/fine_pointing.ssd --seed 1 --stop-time 300

requirements file, see examples/requirements.toml:
  [[requirement]]
  name = "exposure stability"
  index = "RPE"             # APE, MPE, RPE, PDE or PRE
  axis = "line_of_sight"    # x, y, z, line_of_sight or angle
  limit = 0.2
  unit = "arcsec"           # rad, mrad, urad, nrad, deg, arcmin, arcsec or mas
  level = 0.9973            # optional, as are window, separation (PDE) and observation (PRE) in seconds
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class SplitOptions:
    """Runs with one error source at a time."""

    split: Path | None
    seed: int
    stop_time: float
    out: Path | None
    python: bool
    jobs: int | None


split_options = option_group(
    "split",
    SplitOptions,
    click.option("--split", type=PATH, metavar="SYSTEM", help="simulate this system with one error source at a time"),
    click.option("--seed", type=SEED, default=DEFAULT_SEED, metavar="N",
                 help=f"with --split: seed of plant and sensors (default: {DEFAULT_SEED})"),
    stop_time_option(RUN_DURATION, "with --split: simulated time in seconds"),
    out_option("folder for results and figures (default: the run's; of several runs, one folder in it for each; "
               f"with --split: results/SYSTEM-split-seedN{DISTINGUISHED})"),
    click.option("--python", is_flag=True,
                 help="with --split: use the FMUs in Python (default: the native ones, where they are built)"),
    click.option("--jobs", type=COUNT, metavar="N", help="with --split: parallel processes (default: one a core)"),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class EvaluationOptions:
    """Windows, levels and start of the evaluation."""

    window: float
    separation: float
    observation: float
    level: tuple[float, ...]
    start: float | None

    def windows(self) -> IndexWindows:
        """Return the windows of the indices."""
        from ..studies.budget.evaluate import IndexWindows

        return IndexWindows(window=self.window, separation=self.separation, observation=self.observation)

    def levels(self) -> tuple[float, ...]:
        """Return the shares of times."""
        from ..studies.budget.evaluate import LEVELS

        return self.level or LEVELS


evaluation_options = option_group(
    "evaluation",
    EvaluationOptions,
    click.option("--window", type=DURATION, default=10.0, metavar="S",
                 help="window of the means in MPE, RPE, PDE and PRE (default: 10)"),
    click.option("--separation", type=DURATION, default=60.0, metavar="S",
                 help="time between the windows of PDE (default: 60)"),
    click.option("--observation", type=DURATION, default=50.0, metavar="S", help="duration of PRE (default: 50)"),
    click.option("--level", type=NUMBER, multiple=True, metavar="P",
                 help="share of time within the value (default: 0.95 and 0.9973)"),
    from_option(SETTLED_HELP),
)  # fmt: skip


@command(
    "budget", _EXAMPLES, then="{program} spectra {results[0]}    # at which frequencies the errors are", tables=True
)
@click.argument("results", type=PATH, nargs=-1, metavar="[RESULTS...]", help="results folders of runs")
@click.option("--requirements", type=PATH, metavar="FILE", help="TOML file of requirements to assess")
@split_options
@evaluation_options
def budget(
    results: tuple[Path, ...], requirements: Path | None, split: SplitOptions, evaluation: EvaluationOptions
) -> int:
    """Compute the pointing budget of runs after ECSS-E-ST-60-10C, or split it by error source."""
    if split.split is not None:
        if results or requirements:
            raise InputError(
                "--split: takes neither results nor --requirements; run `flexsat budget` on one of its runs"
            )
        return _split(split.split, split, evaluation)
    refuse_given({"seed", "stop_time", "python", "jobs"}, "has an effect only with --split SYSTEM; leave it out")
    if not results:
        raise InputError("RESULTS: missing; give folders of runs, or --split SYSTEM")
    return _evaluate(results, requirements, evaluation, split.out)


def _evaluate(results: Sequence[Path], file: Path | None, evaluation: EvaluationOptions, out: Path | None) -> int:
    """Print and write the budget of each run; return 1 if a requirement fails."""
    from ..figures.budget import budget_figure
    from ..figures.drawing import save_figure
    from ..runs.evaluation_folder import evaluation_folders, writing
    from ..runs.run_folder import read_run
    from ..studies.budget import tables
    from ..studies.budget.evaluate import compute_budget, steady_error
    from ..studies.budget.requirements import judge, read_requirements
    from ..studies.budget.result_file import write_budget

    requirements = read_requirements(file) if file else []
    failed = 0
    for folder, target in zip(results, evaluation_folders(results, out), strict=True):
        run = read_run(folder)
        history = steady_error(run, evaluation.start)
        found = compute_budget(history, evaluation.windows(), evaluation.levels())
        assessments = [judge(history, requirement) for requirement in requirements]
        failed += sum(not one.met for one in assessments)
        with writing(target):
            path = write_budget(found, assessments, run, target, file)
            save_figure(budget_figure(history, found), target / "figures", "budget")
        show_table(tables.header(found), tables.rows(found), f"{run.configuration}, seed {run.seed}: {folder}")
        remark(*tables.notes(found))
        if assessments:
            show_table(tables.ASSESSMENTS, tables.assessment_rows(assessments))
        wrote(path)
    if failed:
        print(f"flexsat: {failed} of {len(requirements) * len(results)} requirements fail", file=sys.stderr)
    return 1 if failed else 0


def _split(system: Path, options: SplitOptions, evaluation: EvaluationOptions) -> int:
    """Simulate each error source alone; print and write its share of the budget."""
    from lockstep.cli.run_options import folder_name
    from lockstep.ssp.load import load_system

    from ..runs.study_folder import study_folder
    from ..studies.budget import split as study
    from ..studies.budget import tables

    name = load_system(system).name
    default = f"{folder_name(name)}-split-seed{options.seed}"
    with study_folder(options.out, default) as folder:
        found = study.split_budget(
            system,
            folder,
            options.seed,
            options.stop_time,
            evaluation.windows(),
            evaluation.start,
            evaluation.levels(),
            options.jobs,
            options.python,
            partial(print, flush=True),
        )
        title = f"{name}, seed {found.seed}, {found.stop:g} s, from t = {found.start:g} s: line of sight, RMS [arcsec]"
        show_table(study.HEADER, study.rows(found), title)
        remark(tables.SPLIT)
        wrote(folder / study.RESULT)
        suggest("{program} report {path}".replace("{path}", str(folder)))
    return 0
