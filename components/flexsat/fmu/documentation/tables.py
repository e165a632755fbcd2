"""Tables of ports in HTML, straight from the table that the shells and the model description are made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from ...ports.table import ELEMENTWISE, Causality, Port, PortTable, Scalar
from ...ports.units import BASE_UNITS, UNITS

COLUMNS = (
    "name",
    "value references",
    "type",
    "unit",
    "display",
    "frame",
    "range",
    "start",
    "description",
    "depends on",
)
TYPES = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}
MOST_STARTS = 6  # values of an array that are all written out


def port_table(table: PortTable, causality: Causality) -> str:
    """Return an HTML table of all ports of a causality, a row each; nothing if there are none."""
    ports = [port for port in table if port.causality == causality]
    if not ports:
        return ""
    left_out = {"input": {"depends on"}, "output": {"range", "start"}, "parameter": {"depends on"}}[causality]
    rows = [_row(table, port) for port in ports]
    shown = [name for name in COLUMNS if name not in left_out]
    return html_table(shown, [[row[name] for name in shown] for row in rows])


def html_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table whose cells are HTML already."""
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "\n".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table>\n<thead><tr>{top}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>\n"


def name_range(table: PortTable, port: Port) -> str:
    """Return the names of a port's variables, first and last: `wheel.torque[1] … wheel.torque[33]`."""
    first = port.scalar_name(0, table.naming)
    return first if port.length == 1 else f"{first} … {port.scalar_name(port.length - 1, table.naming)}"


def port_name(table: PortTable, name: str) -> str:
    """Return a port's name without the number of an element, in the naming of the table."""
    return name.replace(".", "_") if table.naming == "flat" else name


def unit_table(table: PortTable) -> str:
    """Return an HTML table of the units in use: base units, and display units with their factors."""
    used = {port.unit for port in table if port.kind == "real"}
    rows = []
    for name, unit in UNITS.items():
        if name in used:
            exponents = unit.exponents
            base = "not in whole powers of base units; FMI cannot tell them" if exponents is None else _base(exponents)
            shown = ", ".join(f"1 {name} = {factor:.10g} {other}" for other, factor in unit.display.items())
            rows.append([code(name), escape(base), escape(shown)])
    return html_table(("unit", "base units", "display units"), rows)


def code(text: str) -> str:
    """Return text as it is typed."""
    return f"<code>{escape(text)}</code>"


def _base(exponents: Mapping[str, int]) -> str:
    powers = [f"{base}^{exponents[base]}" if exponents[base] != 1 else base for base in BASE_UNITS if base in exponents]
    return " ".join(powers) or "none: a plain number"


def _row(table: PortTable, port: Port) -> dict[str, str]:
    span = table.span(port.name)
    last = span.stop - 1
    size = "" if port.size is None else f"[{port.size}]"
    description = port.description
    if port.on_demand:
        description += "; computed when it is read"
    if port.period_parameter is not None:
        description += f"; changes every {port_name(table, port.period_parameter)}"
    variability = "" if port.variability == "fixed" else f", {port.variability}"
    return {
        "name": code(name_range(table, port)),
        "value references": str(span.start) if span.start == last else f"{span.start}…{last}",
        "type": f"{TYPES[port.kind]}{size}{variability}",
        "unit": escape(port.unit) if port.kind == "real" else "-",
        "display": escape(port.display_unit or "-"),
        "frame": escape(port.frame or "-"),
        "range": _range(port),
        "start": _starts(port),
        "description": escape(description),
        "depends on": _dependencies(table, port),
    }


def _range(port: Port) -> str:
    low, high = port.minimum, port.maximum
    if low is None and high is None:
        return "-"
    if low is None or high is None:
        return f"≥ {low:g}" if low is not None else f"≤ {high:g}"
    return f"{low:g} … {high:g}"


def _starts(port: Port) -> str:
    values = port.starts
    if len(set(values)) == 1:
        return _value(values[0])
    if len(values) <= MOST_STARTS:
        return ", ".join(map(_value, values))
    numbers = [float(value) for value in values]
    return f"{min(numbers):.6g} … {max(numbers):.6g}, each its own"


def _value(value: Scalar) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.9g}" if isinstance(value, float) else escape(str(value))


def _dependencies(table: PortTable, port: Port) -> str:
    if port.causality != "output":
        return ""
    if not port.depends_on:
        return "the state alone"
    parts = []
    for name in port.depends_on:
        source = table[name.removesuffix(ELEMENTWISE)]
        parts.append(port_name(table, source.name) + (" of the same number" if name.endswith(ELEMENTWISE) else ""))
    return escape(", ".join(parts))
