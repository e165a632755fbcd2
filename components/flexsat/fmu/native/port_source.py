"""Write the port table of a component as C: places for its own code, and the table that the FMI layer checks with."""

from __future__ import annotations

import json
from collections.abc import Iterator

from ...ports.table import KINDS, Port, PortTable
from .c_text import double_text, wrapped


def port_places(table: PortTable) -> str:
    """Return the header ports.h: where a component finds its ports.

    For a port `wheel.torque` it has `PORT_WHEEL_TORQUE`, the place of its first scalar among those of its kind, and
    `PORT_WHEEL_TORQUE_SIZE`, their number.
    """
    lines = [
        "/* Generated: places of the ports among the scalars of their kind, and how many each has. */",
        "#ifndef FLEXSAT_PORTS_H",
        "#define FLEXSAT_PORTS_H",
        "",
    ]
    for port in table:
        name = f"PORT_{port.name.upper().replace('.', '_')}"
        lines += [f"#define {name} {table.span(port.name).start}", f"#define {name}_SIZE {port.length}"]
    return "\n".join([*lines, "", "#endif"]) + "\n"


def differentiable(table: PortTable) -> bool:
    """Return whether a component gives directional derivatives: those of real outputs that follow inputs."""
    return any(port.follows_inputs and port.kind == "real" for port in table)


def port_table(table: PortTable) -> str:
    """Return the source ports.c: the ports by kind and place, with limits and start values, as port_table.h describes.

    Raises
    ------
    ValueError
        If the elements of a string start with different texts.
    """
    ordered = [port for kind in KINDS for port in table if port.kind == kind]
    arrays: list[str] = []
    rows: list[str] = []
    for number, port in enumerate(ordered):
        starts = port.starts
        differ = any(start != starts[0] for start in starts)
        if differ:
            if port.kind == "string":
                raise ValueError(f"port {port.name}: its elements start with different texts")
            words = [double_text(float(start)) for start in starts]
            arrays += [f"static const double starts_{number}[{len(words)}] = {{", *wrapped(words), "};", ""]
        rows += _row(table, port, f"starts_{number}" if differ else "NULL")
    owners = [str(number) for number, port in enumerate(ordered) for _ in range(port.length)]
    lines = ["/* Generated; see port_table.h. */", '#include "port_table.h"', "", "#include <float.h>"]
    lines += ["#include <stddef.h>", "", *_summary(table), "", *arrays]
    lines += ["const Port ports[] = {", *rows, "};", ""]
    lines += ["const unsigned short port_of_reference[] = {", *wrapped(owners), "};"]
    return "\n".join(lines) + "\n"


def _summary(table: PortTable) -> Iterator[str]:
    """Yield the lines of the structure of what holds for all ports."""
    counts = ", ".join(str(len(table.of_kind(kind))) for kind in KINDS)
    outputs = table.run("output")
    ends = [table.span(port.name).stop for port in table
            if port.causality == "output" and port.kind == "real" and not port.on_demand]  # fmt: skip
    stepped = max(ends, default=outputs.start) - outputs.start
    feeds = int(any(port.on_demand and port.depends_on for port in table))
    element = "%s[%d]" if table.naming == "structured" else "%s_%d"
    derivatives = differentiable(table)
    if derivatives:
        yield "int component_differentiate(struct Component *component, const double *seed, double *change);"
        yield ""
    yield "const PortTable port_table = {"
    yield f"    {{{counts}}}, {len(table.variables)}, {len(table.ports)},"
    yield f'    {outputs.start}, {outputs.stop - outputs.start}, {stepped}, {feeds}, "{element}",'
    yield f"    {'component_differentiate' if derivatives else 'NULL'},"
    yield "};"


def _row(table: PortTable, port: Port, starts: str) -> Iterator[str]:
    """Yield the lines of a port."""
    name = port.name if table.naming == "structured" else port.name.replace(".", "_")
    limits = []
    for limit, none in ((port.minimum, "-DBL_MAX"), (port.maximum, "DBL_MAX")):
        limits.append((none, "NULL") if limit is None else (double_text(float(limit)), f'"{limit!r}"'))
    (least, lower), (greatest, upper) = limits
    text = json.dumps(port.starts[0]) if port.kind == "string" else "NULL"
    start = "0.0" if port.kind == "string" else double_text(float(port.starts[0]))
    yield f'    {{"{name}", {port.kind.upper()}, {_flags(table, port)}, {table.span(port.name).start}, {port.length},'
    yield f"     {least}, {greatest}, {lower}, {upper}, {start}, {starts}, {text}}},"


def _flags(table: PortTable, port: Port) -> str:
    flags = [port.causality.upper()]
    flags += ["TUNABLE"] * (port.variability == "tunable") + ["ARRAY"] * (port.size is not None)
    flags += ["ON_DEMAND"] * port.on_demand + ["FOLLOWS_INPUTS"] * port.follows_inputs
    return " | ".join(flags + ["STARTS"] * table.starts_from(port))
