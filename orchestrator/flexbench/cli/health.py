"""The command `flexsat health`."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import (
    DISTINGUISHED,
    assignments,
    input_option,
    jobs_option,
    out_option,
    set_option,
    stop_time_option,
)
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import PATH

from .options import python_option, seeds, seeds_option

_EXAMPLES = """
example:
  {program} health fmus/distributed/fine_pointing.ssd --seeds 4 --stop-time 100
  {program} health fmus/distributed/fine_pointing.ssd --set controller.design=published --set plant.modes=25
  {program} health fmus/centralised/fine_pointing.ssd --set controller.filter.gyro_bias=true --stop-time 300
"""


@command("health", _EXAMPLES, then="open {path}    # consistency over time", tables=True)
@click.argument("system", type=PATH, metavar="SYSTEM", help="a system file of `flexsat build`")
@seeds_option(2)
@stop_time_option(100.0)
@set_option
@input_option
@out_option(f"results folder (default: results/health{DISTINGUISHED})")
@python_option
@jobs_option
def health(
    system: Path,
    seed_count: int,
    stop_time: float,
    settings: tuple[str, ...],
    inputs: tuple[Path, ...],
    out: Path | None,
    python: bool,
    jobs: int | None,
) -> int:
    """Test the consistency of the estimator: NIS and NEES with bounds, whiteness of the innovations.

    Of torque and biases that are estimated (controller.filter.*) the NEES is shown too, once their filter has settled.
    """
    from ..figures.drawing import save_figure
    from ..figures.health import estimator_health
    from ..runs.study_folder import study_folder
    from ..studies.health.study import HEADER, RESULT, run_health, table_rows

    numbers, overrides = seeds(seed_count), assignments(settings)
    with study_folder(out, "health") as folder:
        say = partial(print, flush=True)
        found = run_health(system, folder, numbers, stop_time, overrides, jobs, python, say, inputs)
        paths = save_figure(estimator_health(found), folder / "figures", "estimator-health")
        show_table(HEADER, table_rows(found))
        outside = 100 * found.whiteness.outside
        remark(f"innovations of seed {numbers[0]}: {outside:.1f} % of the lags beyond the 95 % bound of white noise")
        if found.needs is not None:
            text = f"settles; simulate more than {math.ceil(found.needs)} s"
            remark(f"estimated torque and biases are not judged: the runs end before their filter {text}")
        wrote(*paths, folder / RESULT)
    return 0
