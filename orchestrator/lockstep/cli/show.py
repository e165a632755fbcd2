"""The command `python -m lockstep show`."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from lockstep.cli.command import command
from lockstep.cli.options import system_argument
from lockstep.cli.outcome import keep_table, print_lines, remark
from lockstep.cli.timing_options import TimingOptions, timing_options, with_delays

if TYPE_CHECKING:
    from lockstep.system.component import Component
    from lockstep.system.system import System

_EXAMPLES = """
example:
  {program} show vendor.ssp --step-size 0.01 --step-size controller=0.1
"""


@command("show", _EXAMPLES, then="{program} run {system}", tables=True)
@system_argument
@timing_options
def show(system: Path, timing: TimingOptions) -> int:
    """Print the components of a system with their step sizes, the order of a tick, and the delays."""
    from lockstep.ssp.load import load_system

    shown = with_delays(load_system(system, timing.timing()), timing.delay)
    print_lines(describe(shown))
    remark(*(f"warning: {text}" for text in shown.warnings))
    _keep(shown)
    return 0


def _keep(system: System) -> None:
    """Keep as tables for `--json` what is shown."""
    from lockstep.ssp.native_fmu import shown_file
    from lockstep.system.clock import seconds

    keep_table(
        ("component", "step [s]", "from [s]", "kind", "FMU"),
        (
            (c.name, seconds(c.period), seconds(c.offset), c.kind, shown_file(c.source) if c.sums is None else "sum")
            for c in _ordered(system)
        ),
        "components in the order of a tick",
    )
    keep_table(
        ("from", "to", "values", "delay [ticks]"),
        ((start, end, count, delay) for (start, end, delay), count in _links(system).items()),
        "connections",
    )
    for title, names in (
        ("inputs without a value", (one.name for one in system.inputs)),
        ("left out, as no variable takes them", system.ignored),
        ("values at initialization only", system.start_values),
    ):
        keep_table(("name",), ((name,) for name in names), title)


def _ordered(system: System) -> list[Component]:
    from lockstep.plan.schedule import build_schedule

    return [system.component(task.name) for task in build_schedule(system).tasks]


def _links(system: System) -> Counter[tuple[str, str, int]]:
    return Counter((one.from_component, one.to_component, one.delay) for one in system.connections)


def describe(system: System) -> list[str]:
    """Return the system as text: tick, components in the order of a tick, and latencies."""
    from lockstep.errors import compact
    from lockstep.ssp.native_fmu import shown_file
    from lockstep.system.clock import seconds_text

    lines = [f"{system.name}: tick {seconds_text(system.tick)} s, in the order of a tick:"]
    width = max(len(component.name) for component in system.components)
    for c in _ordered(system):
        timing = f"every {seconds_text(c.period)} s from {seconds_text(c.offset)} s, {c.kind}"
        source = shown_file(c.source) if c.sums is None else "sum"
        lines.append(f"  {c.name:{width}}  {timing}, {source}")
    for (start, end, delay), count in _links(system).items():
        latency = "same tick" if delay == 0 else f"delay {delay} tick{'s' if delay > 1 else ''}"
        lines.append(f"  {start} -> {end}: {count} value{'s' if count > 1 else ''}, {latency}")
    if system.inputs:
        lines.append(f"  without a value: {compact(one.name for one in system.inputs)}; give --set NAME=VALUE")
    if system.ignored:
        lines.append(f"  left out, as no variable takes them: {compact(system.ignored)}")
    if system.start_values:
        lines.append(f"  apply at initialization only, as the inputs are connected: {compact(system.start_values)}")
    return lines
