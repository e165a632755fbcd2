"""Describe ports and units in rows of text, from the table that makes the shells and the model description."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...ports.table import ELEMENTWISE, Causality, FmiVersion, Kind, Port, PortTable, Scalar
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
TYPES: dict[FmiVersion, dict[Kind, str]] = {
    "2.0": {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"},
    "3.0": {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "string": "String"},
}
MOST_STARTS = 6  # values of an array that are all written out


@dataclass(frozen=True, slots=True, kw_only=True)
class PortRows:
    """A table of ports as plain text: a row a port, a cell a column of the header."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def port_rows(table: PortTable, causality: Causality, fmi: FmiVersion = "2.0") -> PortRows:
    """Return the rows of all ports of a causality."""
    left_out = {"input": {"depends on"}, "output": {"range", "start"}, "parameter": {"depends on"}}[causality]
    header = tuple(name for name in COLUMNS if name not in left_out)
    cells = [_cells(table, port, fmi) for port in table if port.causality == causality]
    return PortRows(header=header, rows=tuple(tuple(row[name] for name in header) for row in cells))


def name_range(table: PortTable, port: Port) -> str:
    """Return the names of a port's variables, first and last: `wheel.torque[1] … wheel.torque[33]`."""
    first = port.scalar_name(0, table.naming)
    return first if port.length == 1 else f"{first} … {port.scalar_name(port.length - 1, table.naming)}"


def port_name(table: PortTable, name: str) -> str:
    """Return a port's name without the number of an element, in the naming of the table."""
    return name.replace(".", "_") if table.naming == "flat" else name


def unit_rows(table: PortTable) -> list[tuple[str, str, str]]:
    """Return the units in use: name, base units, and display units with their factors."""
    used = {port.unit for port in table if port.kind == "real"}
    rows = []
    for name, unit in UNITS.items():
        if name in used:
            exponents = unit.exponents
            base = (
                "not in whole powers of base units, which FMI cannot express" if exponents is None else _base(exponents)
            )
            shown = ", ".join(f"1 {name} = {factor:.10g} {other}" for other, factor in unit.display.items())
            rows.append((name, base, shown))
    return rows


def _base(exponents: Mapping[str, int]) -> str:
    powers = [f"{base}^{exponents[base]}" if exponents[base] != 1 else base for base in BASE_UNITS if base in exponents]
    return " ".join(powers) or "none: a plain number"


def _cells(table: PortTable, port: Port, fmi: FmiVersion) -> dict[str, str]:
    arrays = fmi == "3.0"
    first = table.first_reference[port.kind] + table.span(port.name).start
    start = table.array_reference(port.name) if arrays else first
    last = start if arrays else start + port.length - 1
    size = "" if port.size is None else f"[{port.size}]"
    description = port.description
    if port.on_demand:
        description += "; computed when read"
    if port.period_parameter is not None:
        description += f"; changes every {port_name(table, port.period_parameter)}"
    variability = "" if port.variability == "fixed" else f", {port.variability}"
    return {
        "name": port.name if arrays else name_range(table, port),
        "value references": str(start) if start == last else f"{start}…{last}",
        "type": f"{TYPES[fmi][port.kind]}{size}{variability}",
        "unit": port.unit if port.kind == "real" else "-",
        "display": port.display_unit or "-",
        "frame": port.frame or "-",
        "range": _range(port),
        "start": _starts(port),
        "description": description,
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
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _dependencies(table: PortTable, port: Port) -> str:
    if port.causality != "output":
        return ""
    if not port.depends_on:
        return "the state alone"
    parts = []
    for name in port.depends_on:
        source = table[name.removesuffix(ELEMENTWISE)]
        parts.append(port_name(table, source.name) + (" of the same index" if name.endswith(ELEMENTWISE) else ""))
    return ", ".join(parts)
