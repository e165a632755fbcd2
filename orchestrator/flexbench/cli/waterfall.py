"""The command `flexsat waterfall`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lockstep.cli.command import command
from lockstep.cli.options import DISTINGUISHED, jobs_option, out_option, stop_time_option
from lockstep.cli.outcome import remark, show_table, wrote
from lockstep.cli.parameter_types import COUNT, NUMBER, PATH

from .options import DEFAULT_SEED, python_option, seed_option, variant_option

if TYPE_CHECKING:
    from flexsat.variants import Variant

_EXAMPLES = """
example:
  {program} waterfall fmus/distributed/fine_pointing_open_loop.ssd --points 24 --stop-time 20
"""


@command("waterfall", _EXAMPLES, then="open {path}    # the deformation over the Campbell diagram", tables=True)
@click.argument("system", type=PATH, metavar="SYSTEM",
                help="a system file of `flexsat build`; its loop is opened")  # fmt: skip
@click.option("--points", type=COUNT, default=24, metavar="N", help="number of speeds (default: 24)")
@stop_time_option(20.0, "simulated time of each run in seconds")
@click.option("--speed-range", type=NUMBER, nargs=2, metavar="LOW HIGH",
              help="speeds in rpm (default: all modes and bands)")  # fmt: skip
@variant_option("sweep the plant as published: 25 modes, speeds chosen on them")
@seed_option
@out_option(f"results folder (default: results/CONFIGURATION-waterfall{DISTINGUISHED})")
@python_option
@jobs_option
def waterfall(
    system: Path,
    points: int,
    stop_time: float,
    speed_range: tuple[float, float] | None,
    variant: Variant,
    seed: int | None,
    out: Path | None,
    python: bool,
    jobs: int | None,
) -> int:
    """Sweep the wheel speed in short runs, and draw the deformation with the Campbell diagram."""
    from flexsat.parameters import RPM

    from ..figures.drawing import save_figure
    from ..figures.waterfall import waterfall_figure
    from ..runs.study_folder import study_folder
    from ..studies.waterfall.sweep import RESULT, design_of, read_waterfall, sweep
    from ..studies.waterfall.tables import HEADER, flagged_rows, summary

    span = None if speed_range is None else (speed_range[0] * RPM, speed_range[1] * RPM)
    design = design_of(system, variant)
    marks = variant.mark + ("" if seed is None else f"-seed{seed}")
    default = f"{design.config.name}-waterfall{marks}"
    number = DEFAULT_SEED if seed is None else seed
    with study_folder(out, default) as folder:
        result = sweep(
            system, design, folder, points, stop_time, number, span, jobs, python, partial(print, flush=True)
        )
        paths = save_figure(waterfall_figure(result, design), folder / "figures", "waterfall")
        content = read_waterfall(folder)
        if content is not None:
            remark(summary(content))
            if flagged := flagged_rows(content):
                show_table(HEADER, flagged)
        wrote(*paths, folder / RESULT)
    return 0
