"""The command `flexsat robustness`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, jobs_option, out_option, stop_time_option
from lockstep.cli.parameter_types import NUMBER, OneOf, Several

from .options import SCENARIOS, configuration_option, configurations, fmus_option, seeds, seeds_option
from .print_table import print_table

if TYPE_CHECKING:
    from ..loop.scenarios import ScenarioName

_EXAMPLES = """
exit code: 0 all runs are stable, 1 one is not, 2 bad input

example:
  {program} robustness --levels 1 2 5 --seeds 2 --stop-time 100
"""


@command("robustness", _EXAMPLES)
@configuration_option
@click.option("--scenario", type=OneOf(SCENARIOS[:2]), default="fine_pointing", metavar="NAME",
              help="slew or fine_pointing (default: fine_pointing)")  # fmt: skip
@click.option("--levels", type=Several(NUMBER), metavar="PERCENT...",
              help="relative errors of the frequencies (default: 1 2 5)")  # fmt: skip
@seeds_option(1)
@stop_time_option(100.0)
@out_option(f"results folder (default: results/robustness{DISTINGUISHED})")
@fmus_option
@jobs_option
def robustness(
    configuration: tuple[str, ...],
    scenario: str,
    levels: tuple[float, ...] | None,
    seed_count: int,
    stop_time: float,
    out: Path | None,
    fmus: Path,
    jobs: int | None,
) -> int:
    """Simulate errors of the modal frequencies that the controller does not know."""
    from flexsat.parameters import configuration as parameters_of

    from ..loop.build import build_all
    from ..runs.study_folder import study_folder
    from ..studies.robustness import frequency_errors as frequency

    names, numbers = configurations(configuration), seeds(seed_count)
    shares = tuple(level / 100.0 for level in levels or (100.0 * each for each in frequency.LEVELS))
    frequency.check_plan(shares, stop_time)  # before anything is built
    missing = tuple(name for name in names if not (fmus / name / f"{scenario}.ssd").is_file())
    if missing:
        build_all(missing, fmus)
    modes = parameters_of(names[0]).plate.plant_modes
    with study_folder(out, "robustness") as folder:
        outcomes = frequency.run_robustness(
            fmus, folder, names, cast("ScenarioName", scenario), shares, numbers, stop_time, modes, jobs
        )
    print_table(frequency.HEADER, frequency.table_rows(outcomes), 120)
    unstable = sum(not outcome.stable for outcome in outcomes)
    print(f"{unstable} of {len(outcomes)} runs unstable; worst of seeds {numbers[0]} to {numbers[-1]} in each row")
    if unstable:
        print("flexsat: the loop is not robust to these frequency errors", file=sys.stderr)
    return 1 if unstable else 0
