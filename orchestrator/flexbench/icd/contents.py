"""Compose the interface document: conventions, files, timing, ports, array elements, units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from flexsat.closed_loop import PORTS
from flexsat.design.chain import Design, Designs
from flexsat.fmu.documentation.device_rows import DEVICE_COLUMNS, WHEEL_COLUMNS, device_rows
from flexsat.parameters import ConfigurationName
from flexsat.ports.table import Port
from flexsat.ports.units import UNITS
from lockstep import System
from lockstep.plan.timeline import timeline_lines
from lockstep.plan.timeline_svg import timeline_svg

from ..html.document import Block, Heading, Listing, Paragraph, Picture, Table
from .rows import PortRow, Wire, port_rows

TIMELINE_FILE = "ICD-timeline.svg"
TIMELINE_TICKS = 6  # one controller period and the first tick of the next

_ROLES = {
    "plant": "The flexible spacecraft: rigid body, structural modes, reaction wheels. Continuous: its step holds the "
    "inputs, and its outputs are true at the step's end. Any communication step.",
    "sensors": "Star tracker, gyros, accelerometers, encoders, and the jitter of the wheels. Sampled: reads its inputs "
    "at the step's start, and its outputs hold from there. All steps have the "
    "length of the first one, or of the parameter step_size.",
    "controller": "The LQG attitude controller with its slew guidance. Sampled at its period, and stepped with that "
    "or a whole fraction of it. A controller that replaces it needs this interface.",
}
_HEADER = ("port", "size", "type", "unit (shown)", "frame", "every", "range", "start")

_CONVENTIONS = (
    "Names follow the structured convention of FMI 2.0; arrays are numbered from 1. All values are SI; a display "
    "unit is given where another one is usual.",
    "Body axes: origin at the centre of mass at rest, which is the centre of the aperture if the bus has no mass; x "
    "and y in the plane of the aperture, z along its normal. Quaternions are scalar "
    "last and, like modified Rodrigues parameters (MRP), turn inertial components into body components; MRP are those "
    "of the short rotation.",
    "Where the two configurations differ a cell reads centralised / distributed.",
    "Ranges of inputs and outputs are the values in the closed loop, not limits: an input beyond its range is accepted "
    "(the plant limits wheel torque to wheel.torque_limit). Ranges of parameters are enforced.",
)


def icd_blocks(
    designs: Mapping[ConfigurationName, Designs],
    wires: Sequence[Wire],
    system: System,
    identities: Sequence[tuple[str, str, str]],
) -> list[Block]:
    """Return the interface document.

    Parameters
    ----------
    designs : of both configurations
    wires : connections of the loop, the same in every system
    system : one flexsat system, for the timeline; all have the same schedule
    identities : file, GUID and SHA-256 of each FMU
    """
    blocks: list[Block] = [
        Heading(1, "flexsat: interface control document"),
        Paragraph(
            f"Written by `flexsat build`, flexsat {version('flexsat')}, from the port tables that also define the FMUs."
        ),
        Heading(2, "Conventions"),
        *(Paragraph(text) for text in _CONVENTIONS),
        Heading(2, "FMUs"),
        Table(("file", "GUID", "SHA-256"), identities, frozenset({0, 1, 2})),
        Heading(2, "Timing"),
        Paragraph(
            "In a tick the components run in the order sensors, controller, plant. `same tick`: the consumer reads the "
            "value that the producer computed in this tick. `1 tick`: the consumer reads the plant's outputs that are "
            "true at the time of this tick."
        ),
        Table(("from", "to", "ports", "latency"), [_wire(*wire) for wire in wires]),
        Picture(timeline_svg(system, TIMELINE_TICKS), TIMELINE_FILE, "timeline of steps and connections"),
        Listing("\n".join(timeline_lines(system, TIMELINE_TICKS))),
    ]
    for component, role in _ROLES.items():
        blocks += component_blocks(component, role, port_rows(designs, wires, component))
    for name, both in designs.items():
        blocks += [Heading(2, f"Elements of the arrays: {name}"), *_elements(both.corrected)]
    design = next(iter(designs.values())).corrected
    ports = [port for component, table in PORTS.items() for port in table(getattr(design, component))]
    return [*blocks, Heading(2, "Units"), units_table(ports)]


def component_blocks(component: str, role: str, rows: Sequence[PortRow]) -> list[Block]:
    """Return what the document says of a component: its role, and a table each of inputs, outputs and parameters."""
    blocks: list[Block] = [Heading(2, component.capitalize()), Paragraph(role)]
    for causality, title, partner in (
        ("input", "Inputs", "source"),
        ("output", "Outputs", "destination"),
        ("parameter", "Parameters", ""),
    ):
        chosen = [row for row in rows if row.causality == causality]
        blocks += [Heading(3, f"{title} of the {component}"), _ports(chosen, partner)]
    return blocks


def _wire(source: str, target: str, names: Sequence[str], delay: int) -> tuple[str, str, str, str]:
    return source, target, ", ".join(names), "same tick" if delay == 0 else f"{delay} tick"


def _ports(chosen: Sequence[PortRow], partner: str) -> Table:
    header = [*_HEADER, *([partner] if partner else []), "meaning"]
    cells = []
    for row in chosen:
        line = [row.name, row.size, row.kind, row.unit, row.frame, row.period, row.range, row.start]
        cells.append([*line, *([row.partner] if partner else []), row.description])
    return Table(header, cells)


def _elements(design: Design) -> list[Block]:
    """Return tables of the mount, wheel, sensor or mode that each array element belongs to."""
    craft, devices = design.spacecraft, device_rows(design)
    mounts = [[str(i), *_numbers(p)] for i, p in enumerate(craft.mounts.position, 1)]
    modes = [[str(i), f"{f / (2.0 * np.pi):.4f}"] for i, f in enumerate(craft.frequency, 1)]
    position = ("x [m]", "y [m]", "z [m]")
    return [
        Paragraph(devices.mass),
        Paragraph("Mounts, elements of jitter.force_* and jitter.torque_*:"),
        Table(("mount", *position), mounts, frozenset()),
        Paragraph("Wheels, elements of every wheel.*, encoder.* and *.torque:"),
        Table(WHEEL_COLUMNS, devices.wheels, frozenset()),
        Paragraph("Gyros, elements of gyro_site.rate and gyro.rate:"),
        Table(DEVICE_COLUMNS, devices.gyros, frozenset()),
        Paragraph("Accelerometers, elements of accelerometer_site.acceleration and accelerometer.acceleration:"),
        Table(DEVICE_COLUMNS, devices.accelerometers, frozenset()),
        Paragraph("Modes with the bus clamped, elements of modal.*:"),
        Table(("mode", "frequency [Hz]"), modes, frozenset()),
    ]


def _numbers(values: NDArray[np.float64]) -> list[str]:
    return [f"{value + 0.0:.4g}" for value in np.round(values, 12)]  # no -0


def units_table(ports: Sequence[Port]) -> Table:
    """Return the units of ports, by base units."""
    used = {port.unit for port in ports if port.kind == "real"}
    lines = []
    for name, unit in UNITS.items():
        if name in used:
            base = "not in whole powers" if unit.exponents is None else " ".join(
                symbol if power == 1 else f"{symbol}^{power}" for symbol, power in unit.exponents.items()
            )  # fmt: skip
            shown = ", ".join(f"1 {name} = {factor:.6g} {other}" for other, factor in unit.display.items())
            lines.append((name, base or "dimensionless", shown))
    return Table(("unit", "base units", "shown as"), lines)
