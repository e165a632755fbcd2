"""Describe each port in one row for both configurations: size, unit, frame, period, range, start, partner."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from flexsat.closed_loop import PORTS
from flexsat.design.chain import Designs
from flexsat.parameters import ConfigurationName
from flexsat.ports.table import Port, Scalar
from lockstep.errors import InputError

from .ranges import Range, range_text, signal_ranges

Wire = tuple[str, str, Sequence[str], int]  # from, to, ports of the same name at both ends, delay in ticks


@dataclass(frozen=True, slots=True, kw_only=True)
class PortRow:
    """One port. Texts that differ between the configurations read `centralised / distributed`."""

    name: str
    causality: str
    kind: str
    size: str
    unit: str
    frame: str
    period: str
    range: str
    start: str
    partner: str  # where an input comes from, where an output goes to
    description: str


def port_rows(designs: Mapping[ConfigurationName, Designs], wires: Sequence[Wire], component: str) -> list[PortRow]:
    """Return a row for each port of a component, in the order of its port table."""
    tables = {name: PORTS[component](getattr(both.corrected, component)) for name, both in designs.items()}
    ranges = {name: signal_ranges(both.corrected) for name, both in designs.items()}
    rates = next(iter(designs.values())).corrected.config.rates
    return rows_of(component, tables, ranges, getattr(rates, component), lambda port: _partner(component, port, wires))


def rows_of(
    component: str,
    tables: Mapping[ConfigurationName, tuple[Port, ...]],
    ranges: Mapping[ConfigurationName, dict[str, Range]],
    seconds: float,
    partner: Callable[[Port], str],
) -> list[PortRow]:
    """Return a row for each port of a component, in the order of its tables.

    Parameters
    ----------
    tables, ranges : by configuration
    seconds : period of the component
    partner : gives the other ends of a port
    """
    found = []
    for ports in zip(*tables.values(), strict=True):
        first = ports[0]
        if any(port.name != first.name for port in ports):
            raise InputError(f"{component}: the configurations order their ports differently, at {first.name}")
        found.append(
            PortRow(
                name=first.name,
                causality=first.causality,
                kind=str(first.kind).capitalize(),
                size=_joined(["1" if port.size is None else str(port.size) for port in ports]),
                unit=_unit(first),
                frame=first.frame or "",
                period=_period(first, tables, seconds),
                range=_joined([range_text(port, ranges[name]) for name, port in zip(tables, ports, strict=True)]),
                start=_joined([_start(port) for port in ports]),
                partner=partner(first),
                description=first.description,
            )
        )
    return found


def _unit(port: Port) -> str:
    if port.kind != "real":
        return ""
    return port.unit if port.display_unit is None else f"{port.unit} ({port.display_unit})"


def _joined(texts: list[str]) -> str:
    return texts[0] if len(set(texts)) == 1 else " / ".join(texts)


def _start(port: Port) -> str:
    if port.causality == "output":
        return ""
    texts = [_text(value) for value in port.starts]
    if len(set(texts)) == 1:
        return texts[0]
    if len(texts) <= 4 or port.kind == "string":
        return ", ".join(texts)
    return f"{min(port.starts):.4g} to {max(port.starts):.4g}"


def _text(value: Scalar) -> str:
    if isinstance(value, str):
        return value
    return str(value).lower() if isinstance(value, bool) else f"{value:.6g}"


def _period(port: Port, tables: Mapping[ConfigurationName, tuple[Port, ...]], seconds: float) -> str:
    """Return how often a signal changes, in ms."""
    if port.causality == "parameter":
        return "fixed"
    if port.on_demand:
        return "when read"
    if port.period_parameter is not None:
        parameter = next(p for table in tables.values() for p in table if p.name == port.period_parameter)
        seconds = float(parameter.starts[0])
    return f"{1e3 * seconds:g} ms"


def _partner(component: str, port: Port, wires: Sequence[Wire]) -> str:
    """Return the other ends of a port in the flexsat systems, with their latency."""
    ends = []
    for source, target, names, delay in wires:
        if port.name not in names:
            continue
        latency = "same tick" if delay == 0 else f"{delay} tick"
        if port.causality == "input" and target == component:
            ends.append(f"{source}.{port.name} ({latency})")
        elif port.causality == "output" and source == component:
            ends.append(f"{target}.{port.name} ({latency})")
    if ends or port.causality == "parameter":
        return "; ".join(ends)
    return "set by the scenario" if port.causality == "input" else "recording"
