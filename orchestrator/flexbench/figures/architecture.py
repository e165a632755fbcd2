"""The architecture of a system: components, rates, connections and their delays, and the schedule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Rectangle

from lockstep import System
from lockstep.array_names import array_of
from lockstep.plan.schedule import Schedule, build_schedule
from lockstep.plan.timeline import timeline
from lockstep.system.clock import Time

from .drawing import STYLE, WIDTH
from .palette import PALETTE

MILLISECOND = 1_000_000  # ns
BOX, HEIGHT = 1.62, 1.7  # inch, of a component
LINE = 0.155  # inch, of text
NAMES = 1.6  # inch, of the names of ports between two components
LANE = 0.28  # inch, between a lane and the next's words
ROW = 0.42  # inch, of a component in the schedule
LEFT = 0.95  # inch, left of the schedule
MOST = 8  # ports named on a wire
TIP: dict[str, Any] = {
    "arrowstyle": "-|>,head_length=6,head_width=2.6", "mutation_scale": 1.0, "shrinkA": 0.0, "shrinkB": 0.0,
}  # fmt: skip
HALO: dict[str, Any] = {"bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.6}}  # over wires that cross
SPREAD, BETWEEN = 0.6, 0.1  # of a tick: between its steps, and between two reads of one step
CAPTION = (
    "Bar: a step. Dot: time from which its outputs hold (sampled), or at which they are true (continuous). Arrow: a"
    " read, from the value read.\nSteps of one tick are drawn next to each other, in the order of the master."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wire:
    """All connections from one component to another with the same delay; ports without their indices."""

    producer: str
    consumer: str
    delay: int  # ticks
    ports: Mapping[str, int]  # how many scalars of each
    current: bool  # a delay of one tick after a continuous step of one: the value that is true when it is read

    @property
    def count(self) -> int:
        """Number of scalars."""
        return sum(self.ports.values())


def wires(system: System) -> list[Wire]:
    """Return the connections between components, grouped by ends and delay, in the order of the system."""
    schedule = build_schedule(system)
    found: dict[tuple[str, str, int], dict[str, int]] = {}
    for connection in system.connections:
        ports = found.setdefault((connection.from_component, connection.to_component, connection.delay), {})
        port = array_of(connection.output)
        ports[port] = ports.get(port, 0) + 1
    return [
        Wire(
            producer=producer,
            consumer=consumer,
            delay=delay,
            ports=ports,
            current=delay == 1 and (task := schedule.task(producer)).continuous and task.period == 1,
        )
        for (producer, consumer, delay), ports in found.items()
    ]


def architecture_diagram(system: System, notes: Mapping[str, Sequence[str]] | None = None) -> Figure:
    """Draw the components in the order of a tick, connections between them, and the schedule below.

    Parameters
    ----------
    system : of any FMUs, as the master would run it
    notes : lines to add to a component, by name: about its inside, which the system file does not describe

    Raises
    ------
    InputError
        If the system cannot be scheduled.
    """
    schedule = build_schedule(system)
    names = [task.name for task in schedule.tasks]
    centres = _centres(names)
    room = all(centres[b] - centres[a] - BOX >= NAMES for a, b in pairwise(names))
    above, below, direct = _routes(names, wires(system), straight=room)
    up, down = sum(_lane_height(wire) for wire in above), sum(_lane_height(wire) for wire in below)
    upper = up + HEIGHT + down + 0.1
    lower = 1.0 + ROW * len(names)
    height = upper + lower + 0.3
    with matplotlib.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(WIDTH, height))
        blocks = figure.add_axes((0.0, (lower + 0.0) / height, 1.0, upper / height))
        blocks.set(xlim=(0.0, WIDTH), ylim=(-HEIGHT / 2.0 - down - 0.05, HEIGHT / 2.0 + up + 0.05))
        blocks.set_axis_off()
        figure.text(0.12 / WIDTH, 1.0 - 0.2 / height, _title(system), fontsize=9.5, fontweight="bold")
        for name in names:
            more = (notes or {}).get(name, ())
            _draw_component(blocks, system, schedule, name, centres[name], more, _colour(names, name))
        for wire in direct:
            _draw_direct(blocks, wire, centres, _colour(names, wire.producer), system.tick)
        for lanes, side in ((above, 1.0), (below, -1.0)):
            _draw_lanes(blocks, lanes, side, centres, names, system.tick)
        rows = figure.add_axes((LEFT / WIDTH, 0.5 / height, 1.0 - (LEFT + 0.25) / WIDTH, (ROW * len(names)) / height))
        _draw_schedule(rows, system, schedule, names)
    return figure


def _title(system: System) -> str:
    return f"{system.name}: {len(system.components)} FMUs, tick {_milliseconds(system.tick)}"


def _milliseconds(nanoseconds: Time) -> str:
    return f"{float(nanoseconds / MILLISECOND):g} ms"


def _colour(names: Sequence[str], name: str) -> str:
    return PALETTE[names.index(name) % len(PALETTE)]


def _centres(names: Sequence[str]) -> dict[str, float]:
    margin = 0.15 + BOX / 2.0
    if len(names) == 1:
        return {names[0]: WIDTH / 2.0}
    step = (WIDTH - 2.0 * margin) / (len(names) - 1)
    return {name: margin + k * step for k, name in enumerate(names)}


def _routes(
    names: Sequence[str], found: Sequence[Wire], *, straight: bool
) -> tuple[list[Wire], list[Wire], list[Wire]]:
    """Sort wires into lanes above (back to an earlier component), below (past one), and straight to the next."""
    above: list[Wire] = []
    below: list[Wire] = []
    direct: list[Wire] = []
    for wire in found:
        ahead = names.index(wire.consumer) - names.index(wire.producer)
        if ahead <= 0:
            above.append(wire)
        elif (
            straight and ahead == 1 and (wire.producer, wire.consumer) not in {(w.producer, w.consumer) for w in direct}
        ):
            direct.append(wire)
        else:
            below.append(wire)
    return above, below, direct


def _ports(wire: Wire) -> list[str]:
    lines = [port if count == 1 else f"{port} [{count}]" for port, count in wire.ports.items()]
    return lines if len(lines) <= MOST else [*lines[: MOST - 1], f"and {len(lines) - MOST + 1} more"]


def _heading(wire: Wire, tick: Time) -> str:
    values = f"{wire.count} value{'' if wire.count == 1 else 's'}"
    if wire.delay == 0:
        return f"{values}, same tick"
    if wire.current:
        return f"{values}, delay 1 tick: true now"
    return f"{values}, delay {wire.delay} tick{'' if wire.delay == 1 else 's'} = {_milliseconds(wire.delay * tick)}"


def _lane_lines(wire: Wire, tick: Time) -> list[str]:
    """Put the ports of a lane on as few lines as a lane is wide."""
    lines, ports = [_heading(wire, tick)], _ports(wire)
    for port in ports:
        if len(lines) > 1 and len(lines[-1]) + len(port) < 72:
            lines[-1] += f", {port}"
        else:
            lines.append(port)
    return lines


def _lane_height(wire: Wire) -> float:
    return LANE + LINE * len(_lane_lines(wire, MILLISECOND))


def _draw_component(
    axes: Axes, system: System, schedule: Schedule, name: str, x: float, notes: Sequence[str], colour: str
) -> None:
    task, component = schedule.task(name), system.component(name)
    taken = sum(connection.to_component == name for connection in system.connections)
    given = sum(connection.from_component == name for connection in system.connections)
    box = FancyBboxPatch(
        (x - BOX / 2.0, -HEIGHT / 2.0), BOX, HEIGHT, boxstyle="round,pad=0,rounding_size=0.06",
        facecolor="0.97", edgecolor=colour, linewidth=1.6, label=name,
    )  # fmt: skip
    axes.add_patch(box)
    when = f"every {_milliseconds(task.period * system.tick)}"
    if task.offset:
        when += f" from {_milliseconds(task.offset * system.tick)} on"
    lines = [
        component.source.name,
        *([when, component.kind] if task.offset else [f"{when}, {component.kind}"]),
        f"{taken} in, {given} out",
        *([""] if notes else []),
        *notes,
    ]
    axes.text(x, HEIGHT / 2.0 - 0.2, name, ha="center", va="center", fontsize=10.0, fontweight="bold", color=colour)
    axes.text(x, HEIGHT / 2.0 - 0.36, "\n".join(lines), ha="center", va="top", fontsize=7.5, linespacing=1.35)


def _draw_direct(axes: Axes, wire: Wire, centres: Mapping[str, float], colour: str, tick: Time) -> None:
    start, end = centres[wire.producer] + BOX / 2.0, centres[wire.consumer] - BOX / 2.0
    axes.annotate("", (end, 0.0), (start, 0.0), arrowprops={"color": colour, "linewidth": 1.4, **TIP})
    middle, ports = 0.5 * (start + end), _ports(wire)
    axes.text(middle, 0.06, _heading(wire, tick), ha="center", va="bottom", fontsize=8.0, color=colour)
    axes.text(middle, -0.07, "\n".join(ports), ha="center", va="top", fontsize=7.0, linespacing=1.25)


def _draw_lanes(
    axes: Axes, lanes: Sequence[Wire], side: float, centres: Mapping[str, float], names: Sequence[str], tick: Time
) -> None:
    """Draw each wire from its box along a lane to the other box."""
    level = HEIGHT / 2.0
    for number, wire in enumerate(lanes):
        level += _lane_height(wire)
        shift = 0.18 * (number + 1)
        towards = -1.0 if side > 0.0 else 1.0
        start, end = centres[wire.producer] + towards * shift, centres[wire.consumer] - towards * shift
        colour, edge, lane = _colour(names, wire.producer), side * HEIGHT / 2.0, side * (level - LANE / 2.0)
        axes.plot([start, start, end, end], [edge, lane, lane, edge], color=colour, linewidth=1.4)
        axes.annotate("", (end, edge), (end, lane), arrowprops={"color": colour, "linewidth": 1.4, **TIP})
        heading, *ports = _lane_lines(wire, tick)
        text = "\n".join(ports)
        middle = 0.5 * (start + end)
        if side > 0.0:
            axes.text(middle, lane - 0.05, heading, ha="center", va="top", fontsize=8.0, color=colour, **HALO)
            axes.text(
                middle, lane - 0.05 - 1.1 * LINE, text, ha="center", va="top", fontsize=7.0, linespacing=1.25, **HALO
            )
        else:
            axes.text(middle, lane + 0.05, text, ha="center", va="bottom", fontsize=7.0, linespacing=1.25, **HALO)
            up = lane + 0.05 + 0.9 * LINE * len(ports)
            axes.text(middle, up, heading, ha="center", va="bottom", fontsize=8.0, color=colour, **HALO)


def _draw_schedule(axes: Axes, system: System, schedule: Schedule, names: Sequence[str]) -> None:
    """Draw each step as a bar over the time that it covers, and each of its reads as an arrow."""
    ticks = 2 * schedule.hyperperiod()
    tick = float(system.tick / MILLISECOND)
    height = {name: len(names) - 1.0 - k for k, name in enumerate(names)}
    for step in timeline(system, ticks):
        start, end = float(step.start / MILLISECOND), float(step.end / MILLISECOND)
        row, colour = height[step.component], _colour(names, step.component)
        look: dict[str, Any] = {"facecolor": colour, "alpha": 0.25, "linewidth": 0.0}
        axes.add_patch(
            Rectangle((start, row - 0.2), end - start - 0.05 * tick, 0.4, label=f"{step.component}, step", **look)
        )
        true = end if step.continuous else start
        axes.plot([true], [row], marker="o", markersize=4.5, color=colour, label=f"{step.component}, true", zorder=4.0)
        turn = SPREAD * tick * names.index(step.component) / len(names)
        for number, read in enumerate(read for read in step.reads if not read.initial):
            producer, since = schedule.task(read.producer), float(read.since / MILLISECOND)
            at = start + turn + BETWEEN * tick * number
            seen = since if producer.continuous else min(at, since + producer.period * tick)  # held until then
            source = height[read.producer]
            inside = 0.2 if source > row else -0.2
            axes.annotate(
                "", (at, row + inside), (seen, source - (0.0 if producer.continuous else inside)), zorder=3.0,
                arrowprops={"color": _colour(names, read.producer), "linewidth": 1.1, **TIP},
            )  # fmt: skip
    span = ticks * tick
    axes.set(xlim=(-0.01 * span, span * 1.01), ylim=(-0.5, len(names) - 0.5), xlabel="time [ms]")
    axes.set_title(CAPTION, fontsize=7.5)
    axes.set_yticks(list(height.values()), list(height))
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0.0)
