"""Write the parameters of the exported controller as C: their start values, limits and places."""

from __future__ import annotations

from collections.abc import Iterator

from ...ports.table import Port, PortTable
from ..native.c_text import double_text, wrapped
from .header import CHOICES, field, parameter_ports


def parameter_source(table: PortTable, design: str) -> str:
    """Return the source parameter_table.c, which parameter_table.h describes.

    Parameters
    ----------
    design : value of the FMU's parameter `design`: the only one that is in the export
    """
    ports = parameter_ports(table)
    lines = [
        "/* Generated; see parameter_table.h. */",
        '#include "parameter_table.h"',
        "",
        "#include <float.h>",
        "",
        '#include "ports.h"',
        "",
    ]
    for port in ports:
        if port.name in CHOICES:
            listed = ", ".join(f'"{text}"' for text in CHOICES[port.name])
            lines += [f"static const char *const {field(port)}_texts[] = {{{listed}}};"]
    lines += ["", "const FlexsatParameters flexsat_default_parameters = {"]
    lines += [line for port in ports for line in _start(port)]
    lines += ["};", "", "const ParameterEntry parameter_table[] = {"]
    lines += [line for port in ports for line in _row(port)]
    reals, booleans, texts = (len(table.of_kind(kind)) for kind in ("real", "boolean", "string"))
    lines += ["};", "", f"const ValueCounts value_counts = {{{reals}, {booleans}, {texts}}};"]
    lines += [f"const int parameter_count = {len(ports)};", f'const char *const design_name = "{design}";']
    return "\n".join(lines) + "\n"


def _start(port: Port) -> Iterator[str]:
    """Yield the initialiser of a parameter."""
    if port.name in CHOICES:
        yield f"    .{field(port)} = {CHOICES[port.name].index(port.starts[0])},"
        return
    texts = [double_text(float(value)) if port.kind == "real" else str(int(value)) for value in port.starts]
    if port.size is None:
        yield f"    .{field(port)} = {texts[0]},"
    else:
        yield f"    .{field(port)} = {{"
        yield from (f"    {line}" for line in wrapped(texts))
        yield "    },"


def _row(port: Port) -> Iterator[str]:
    """Yield the entry of a parameter in the table."""
    place = f"PORT_{port.name.upper().replace('.', '_')}"
    kind, size, choices = "PARAMETER_REAL", str(port.length), "NULL"
    if port.name in CHOICES:
        kind, size, choices = "PARAMETER_CHOICE", str(len(CHOICES[port.name])), f"{field(port)}_texts"
    elif port.kind == "boolean":
        kind = "PARAMETER_BOOLEAN"
    least = "-DBL_MAX" if port.minimum is None else double_text(float(port.minimum))
    greatest = "DBL_MAX" if port.maximum is None else double_text(float(port.maximum))
    yield f'    {{"{port.name}", {kind}, offsetof(FlexsatParameters, {field(port)}), {place}, {size},'
    yield f"     {least}, {greatest}, {choices}}},"
