"""The command `flexsat robustness`."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, jobs_option, out_option, stop_time_option
from lockstep.cli.outcome import remark, show_table, suggest, wrote
from lockstep.cli.parameter_types import COUNT, NUMBER, OneOf, Several
from lockstep.errors import InputError

from .options import SCENARIOS, fmus_option, python_option, seeds, seeds_option, spacecraft_option

if TYPE_CHECKING:
    from flexsat.parameters import ControllerDesign

    from ..loop.chosen_spacecraft import Chosen
    from ..loop.scenarios import ScenarioName

DESIGNS = ("robust", "published")  # as in the parameters
VARIED = ("frequency", "damping", "inertia", "participation", "modes")  # as in the study, which help does not wait for
_OPTION = {"frequency": "levels"}
_EXAMPLES = """
exit code: 0 all runs are stable, 1 one is not, 2 bad input

example:
  {program} robustness --levels 1 2 5 --seeds 2 --stop-time 100
  {program} robustness --configuration my.toml --vary frequency damping
  {program} robustness --controller-design published --vary modes --modes 25 28
  {program} robustness --vary damping modes --damping 30 60 --modes 28 60
"""


@command(
    "robustness",
    _EXAMPLES,
    then="{program} margins SYSTEM    # the margins of the loop",
    tables=True,
)
@spacecraft_option
@click.option("--scenario", type=OneOf(SCENARIOS[:2]), default="fine_pointing", metavar="NAME",
              help="slew or fine_pointing (default: fine_pointing)")  # fmt: skip
@click.option("--controller-design", type=OneOf(DESIGNS), default=DESIGNS[0], metavar="NAME",
              help=f"{' or '.join(DESIGNS)} (default: {DESIGNS[0]})")  # fmt: skip
@click.option("--levels", type=Several(NUMBER), metavar="PERCENT...",
              help="relative errors of the frequencies (default: 1 2 5)")  # fmt: skip
@click.option("--vary", type=Several(OneOf(VARIED)), metavar="WHAT...",
              help="frequency, damping, inertia, participation, modes (default: all)")  # fmt: skip
@click.option("--damping", type=Several(NUMBER), metavar="PERCENT...",
              help="relative errors of the modal damping (default: 50)")  # fmt: skip
@click.option("--inertia", type=Several(NUMBER), metavar="PERCENT...",
              help="relative errors of the moments of inertia (default: 10)")  # fmt: skip
@click.option("--participation", type=Several(NUMBER), metavar="PERCENT...",
              help="reductions of the modes' coupling to the rigid body (default: 10)")  # fmt: skip
@click.option("--modes", type=Several(COUNT), metavar="N...",
              help="mode counts of the plant, in addition to all modes (default: 25 40 100)")  # fmt: skip
@seeds_option(1)
@stop_time_option(100.0)
@out_option(f"results folder (default: results/robustness{DISTINGUISHED})")
@fmus_option
@python_option
@jobs_option
def robustness(
    configuration: tuple[str, ...],
    scenario: str,
    controller_design: str,
    levels: tuple[float, ...] | None,
    vary: tuple[str, ...] | None,
    damping: tuple[float, ...] | None,
    inertia: tuple[float, ...] | None,
    participation: tuple[float, ...] | None,
    modes: tuple[int, ...] | None,
    seed_count: int,
    stop_time: float,
    out: Path | None,
    fmus: Path,
    python: bool,
    jobs: int | None,
) -> int:
    """Simulate plants with model errors and other mode counts that the controller does not know."""
    from ..loop.chosen_spacecraft import build_missing, choose
    from ..runs.study_folder import study_folder
    from ..studies.robustness import model_errors as errors

    numbers, chosen, spacecraft = seeds(seed_count), vary or VARIED, choose(configuration, fmus)
    given = {"frequency": levels, "damping": damping, "inertia": inertia, "participation": participation}
    for what, values in (*given.items(), ("modes", modes)):
        if values is not None and what not in chosen:
            raise InputError(f"--{_OPTION.get(what, what)}: has no effect without --vary {what}")
    carried = _common(spacecraft)
    plan = errors.VariationPlan(
        levels={
            what: errors.LEVELS[what] if values is None else tuple(value / 100.0 for value in values)
            for what, values in given.items()
            if what in chosen
        },
        modes=(modes or errors.fewer_than(carried)) if "modes" in chosen else (),
    )
    plan.check(stop_time, carried)  # before anything is built
    build_missing(spacecraft, scenario)
    with study_folder(out, "robustness") as folder:
        outcomes = errors.run_robustness(
            spacecraft[0].root,
            folder,
            [one.name for one in spacecraft],
            cast("ScenarioName", scenario),
            plan,
            numbers,
            stop_time,
            carried,
            jobs,
            cast("ControllerDesign", controller_design),
            python,
            partial(print, flush=True),
        )
    show_table(errors.HEADER, errors.table_rows(outcomes))
    unstable = sum(not outcome.stable for outcome in outcomes)
    of_seeds = (
        f"seed {numbers[0]}" if len(numbers) == 1 else f"worst of seeds {numbers[0]} to {numbers[-1]} in each row"
    )
    remark(f"{unstable} of {len(outcomes)} runs unstable; {of_seeds}")
    wrote(folder)
    last = spacecraft[-1]
    suggest(
        f"{{program}} margins {shlex.quote(str(last.root / last.name))}/{scenario}.ssd    # the margins of the loop"
    )
    if unstable:
        print("flexsat: the loop is not robust to these errors of the plant", file=sys.stderr)
    return 1 if unstable else 0


def _common(spacecraft: Sequence[Chosen]) -> int:
    """Return the number of modes of spacecraft; InputError if they have different ones, or are in different folders."""
    modes, roots = {one.modes for one in spacecraft}, {one.root for one in spacecraft}
    if len(modes) > 1 or len(roots) > 1:
        raise InputError(
            f"--configuration {' '.join(one.name for one in spacecraft)}: of different numbers of modes, or in"
            " different folders of FMUs; simulate one at a time"
        )
    return modes.pop()
