"""The command `flexsat branch`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import (
    DISTINGUISHED,
    assignments,
    jobs_option,
    out_option,
    record_option,
    reinitialise_option,
    set_option,
    stop_time_option,
)
from lockstep.cli.outcome import show_table, wrote
from lockstep.cli.parameter_types import PATH, Several

_EXAMPLES = """
example:
  {program} branch results/slew/checkpoints/t=100.ckpt --vary plant.wheel.friction_torque[3] 0 0.01 0.05
"""


@command("branch", _EXAMPLES, then="{program} report {path}    # all runs on one page", tables=True)
@click.argument("checkpoint", type=PATH, metavar="CHECKPOINT", help="a .ckpt file of a run with --checkpoint")
@click.option("--vary", type=Several(), multiple=True, required=True, metavar="C.P V...",
              help="values of an input or tunable parameter; several times: all combinations")  # fmt: skip
@set_option
@reinitialise_option
@stop_time_option(None, "stop time in seconds (default: that of the checkpointed run)")
@record_option
@out_option(f"folder for the folders of the runs (default: results/branch{DISTINGUISHED})")
@jobs_option
def branch(
    checkpoint: Path,
    vary: tuple[tuple[str, ...], ...],
    settings: tuple[str, ...],
    reinitialise: tuple[str, ...],
    stop_time: float | None,
    record: tuple[str, ...],
    out: Path | None,
    jobs: int | None,
) -> int:
    """Restart one checkpoint several times in parallel, with different values."""
    from lockstep.checkpoint.file import read_checkpoint
    from lockstep.system.clock import seconds

    from ..engine.branches import run_branches, varied
    from ..runs.study_folder import study_folder

    with study_folder(out, "branch") as folder:
        finished = run_branches(
            checkpoint,
            varied(vary, assignments(settings)),
            folder,
            stop_time=stop_time,
            reinitialised=reinitialise,
            record=list(record) or None,
            processes=jobs,
        )
    start = seconds(read_checkpoint(checkpoint).time)
    show_table(
        ("run", "from [s]", "to [s]", "wall time [s]"),
        ((one.job.folder.name, f"{start:g}", f"{one.simulated_time:g}", f"{one.wall_time:.1f}") for one in finished),
    )
    wrote(folder)
    return 0
