"""Compose the interface document of the components of missions: environment, thrusters and mission manager."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from importlib.metadata import version

import numpy as np

from flexsat.design.chain import Design
from flexsat.fmu.documentation.component_text import ComponentText
from flexsat.fmu.documentation.content import TEXTS
from flexsat.fmu.documentation.device_rows import WHEEL_COLUMNS, device_rows
from flexsat.ports.table import Port
from flexsat.ports.thrusters import DIRECTIONS, POSITIONS
from flexsat.runtime.missions.mode_logic import ACTIONS, MODES
from lockstep import System
from lockstep.array_names import stem
from lockstep.plan.timeline import timeline_lines
from lockstep.plan.timeline_svg import timeline_svg
from lockstep.system.clock import seconds

from ..html.document import Block, Heading, Listing, Paragraph, Picture, Table
from .contents import TIMELINE_FILE, TIMELINE_TICKS, component_blocks, units_table
from .ranges import Range, signal_ranges
from .rows import rows_of

# Signals whose range is that of the same name in the loop without a mission manager; wheel speeds are not: in a mission
# a wheel may take over what another held.
_AS_IN_THE_LOOP = ("attitude.quaternion", "estimate.mrp", "reference.mrp", "reference.torque", "wheel.torque")
_POSITIVE = ("thrust", "thrust.command", "thrust.impulse", "thrust.pulses", "pointing.error", "command.start_time")


def mission_icd_blocks(
    design: Design,
    tables: Mapping[str, tuple[Port, ...]],
    system: System,
    identities: Sequence[tuple[str, str, str]],
) -> list[Block]:
    """Return the interface document of the components of missions of one spacecraft.

    Parameters
    ----------
    tables : ports by component
    system : with all of the components
    identities : file, GUID and SHA-256 of each of their FMUs
    """
    order = ", ".join(component.name for component in system.components)
    blocks: list[Block] = [
        Heading(1, f"flexsat: interface control document of missions, {design.config.name}"),
        Paragraph(
            f"Written by `flexsat build --missions`, flexsat {version('flexsat')}, from the port tables that also"
            " define the FMUs. Plant, sensors and controller have a document of their own; its conventions hold here."
        ),
        Heading(2, "FMUs"),
        Table(("file", "GUID", "SHA-256"), identities, frozenset({0, 1, 2})),
        Heading(2, "Timing"),
        Paragraph(
            f"In a tick the components run in the order {order}. `same tick`: the consumer reads the value that the"
            " producer computed in this tick."
        ),
        Table(("from", "to", "ports", "latency"), _wires(system, frozenset(tables))),
        Picture(timeline_svg(system, TIMELINE_TICKS), TIMELINE_FILE, "timeline of steps and connections"),
        Listing("\n".join(timeline_lines(system, TIMELINE_TICKS))),
    ]
    ranges = {design.config.name: _ranges(design)}
    for component, ports in tables.items():
        step = next(seconds(one.period) for one in system.components if one.name == component)
        rows = rows_of(component, {design.config.name: ports}, ranges, step, partial(_partner, system, component))
        blocks += component_blocks(component, _role(TEXTS[component]), rows)
    wheels = [row[: len(WHEEL_COLUMNS)] for row in device_rows(design).wheels]
    thrusters = [[str(k), *(f"{x:g}" for x in (*place, *along))]
                 for k, (place, along) in enumerate(zip(POSITIONS, DIRECTIONS, strict=True), 1)]  # fmt: skip
    return [
        *blocks,
        Heading(2, "Elements of the arrays"),
        Paragraph("Wheels, elements of every wheel.*, encoder.* and *.torque:"),
        Table(WHEEL_COLUMNS, wheels, frozenset()),
        Paragraph("Thrusters, elements of thrust, thrust.command and thrust.pulses, as the parameters begin:"),
        Table(("thruster", "x [m]", "y [m]", "z [m]", "along x", "along y", "along z"), thrusters, frozenset()),
        Heading(2, "Units"),
        units_table([port for ports in tables.values() for port in ports]),
    ]


def _role(text: ComponentText) -> str:
    return " ".join((text.summary, *text.timing))


def _ranges(design: Design) -> dict[str, Range]:
    known = signal_ranges(design)
    most = float(np.max(design.config.wheel_set.torque_limit))
    return {
        **{name: known[name] for name in _AS_IN_THE_LOOP},
        **dict.fromkeys(("demanded.wheel.torque", "applied.wheel.torque"), (-most, most)),
        **dict.fromkeys(_POSITIVE, (0.0, None)),
        "mode": (0.0, len(MODES) - 1.0),
        "timeline.action": (0.0, len(ACTIONS) - 1.0),
        "wheel.status": (0.0, 2.0),
    }


def _latency(delay: int) -> str:
    return "same tick" if delay == 0 else f"{delay} tick{'s' if delay > 1 else ''}"


def _wires(system: System, components: frozenset[str]) -> list[tuple[str, str, str, str]]:
    """Return the connections to and from components, a row for each pair and latency."""
    found: dict[tuple[str, str, int], dict[str, None]] = {}
    for one in system.connections:
        if components & {one.from_component, one.to_component}:
            output, into = stem(one.output), stem(one.input)
            pair = found.setdefault((one.from_component, one.to_component, one.delay), {})
            pair[output if output == into else f"{output} to {into}"] = None
    return [(source, target, ", ".join(names), _latency(delay)) for (source, target, delay), names in found.items()]


def _partner(system: System, component: str, port: Port) -> str:
    ends: dict[str, None] = {}
    for one in system.connections:
        if port.causality == "input" and (one.to_component, stem(one.input)) == (component, port.name):
            ends[f"{one.from_component}.{stem(one.output)} ({_latency(one.delay)})"] = None
        if port.causality == "output" and (one.from_component, stem(one.output)) == (component, port.name):
            ends[f"{one.to_component}.{stem(one.input)} ({_latency(one.delay)})"] = None
    return "; ".join(ends) or {"input": "set by the user", "output": "recording"}.get(port.causality, "")
