"""The command `flexsat timeline`."""

from __future__ import annotations

from pathlib import Path

import click

from lockstep.cli.command import command
from lockstep.cli.options import system_argument
from lockstep.cli.outcome import keep_table, print_lines, wrote
from lockstep.cli.parameter_types import COUNT, PATH
from lockstep.cli.timing_options import TimingOptions, timing_options, with_delays

_EXAMPLES = """
example:
  {program} timeline fmus/distributed/slew.ssd --ticks 6 --svg timeline.svg
"""


@command("timeline", _EXAMPLES, then="{program} run {system}", tables=True)
@system_argument
@timing_options
@click.option("--ticks", type=COUNT, default=6, metavar="N", help="ticks to show (default: 6)")
@click.option("--svg", type=PATH, metavar="FILE", help="also draw the timeline")
def timeline(system: Path, timing: TimingOptions, ticks: int, svg: Path | None) -> int:
    """Show which component is stepped when, and which values are transferred between them."""
    from lockstep.plan.timeline import routes, timeline_lines
    from lockstep.plan.timeline import timeline as steps_of
    from lockstep.plan.timeline_svg import timeline_svg
    from lockstep.ssp.load import load_system
    from lockstep.system.clock import seconds
    from lockstep.whole_file import write_whole

    loaded = with_delays(load_system(system, timing.timing()), timing.delay)
    print_lines(timeline_lines(loaded, ticks))
    steps = steps_of(loaded, ticks)
    keep_table(
        ("tick", "component", "from [s]", "to [s]", "outputs true at [s]"),
        (
            (one.tick, one.component, *map(seconds, (one.start, one.end, one.end if one.continuous else one.start)))
            for one in steps
        ),
        "steps",
    )
    keep_table(
        ("tick", "component", "producer", "values", "delay [ticks]", "since [s]", "initial"),
        (
            (one.tick, one.component, read.producer, read.count, read.delay, seconds(read.since), read.initial)
            for one in steps
            for read in one.reads
        ),
        "values read",
    )
    keep_table(
        ("producer", "consumer", "delay [ticks]", "ports"),
        ((one.producer, one.consumer, one.delay, ", ".join(one.ports)) for one in routes(loaded)),
        "connections",
    )
    if svg is not None:
        write_whole(svg, timeline_svg(loaded, ticks).encode())
        wrote(svg)
    return 0
