"""The command `flexsat timeline`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import system_argument
from lockstep.cli.outcome import wrote
from lockstep.cli.parameter_types import COUNT, PATH
from lockstep.cli.timing_options import TimingOptions, timing_options, with_delays

_EXAMPLES = """
example:
  {program} timeline fmus/distributed/slew.ssd --ticks 6 --svg timeline.svg
"""


@command("timeline", _EXAMPLES, then="{program} run {system}")
@system_argument
@timing_options
@click.option("--ticks", type=COUNT, default=6, metavar="N", help="ticks to show (default: 6)")
@click.option("--svg", type=PATH, metavar="FILE", help="also draw it")
def timeline(system: Path, timing: TimingOptions, ticks: int, svg: Path | None) -> int:
    """Show which component is stepped when, and which values are transferred between them."""
    from flexsat.fmu.reproducible_zip import write_atomically
    from lockstep.plan.timeline import timeline_lines
    from lockstep.plan.timeline_svg import timeline_svg
    from lockstep.ssp.load import load_system

    loaded = with_delays(load_system(system, timing.timing()), timing.delay)
    print("\n".join(timeline_lines(loaded, ticks)))
    if svg is not None:
        write_atomically(svg, timeline_svg(loaded, ticks).encode())
        wrote(svg)
    return 0
