"""A system of four cells at periods of their own, in a loop."""

from __future__ import annotations

from pathlib import Path

from lockstep import Component, Connection, System
from lockstep.system.system import SystemPort

MS = 1_000_000  # [ns]


def wire(start: str, end: str, delay: int, **more: float) -> Connection:
    """Return a connection between two variables, written as component.variable."""
    (from_component, _, output), (to_component, _, target) = start.partition("."), end.partition(".")
    ends = {"from_component": from_component, "output": output, "to_component": to_component, "input": target}
    return Connection(**ends, delay=delay, **more)


def four_cells(cell: Path) -> System:
    """Return sampled and continuous cells: periods of 1, 5, 1 and 2 ticks, an offset, delays of 0 to 3 ticks, units
    that are converted, a factor, and all types that are transferred.
    """

    def part(name: str, period: int, kind: str, **more: object) -> Component:
        return Component(name=name, source=cell, period=period * MS, kind=kind, **more)

    return System(
        name="four cells",
        tick=MS,
        stop_time=40 * MS,
        components=(
            part("fast", 1, "sampled", parameters={"gain": 1.5, "label": "quick"}),
            part("slow", 5, "sampled", offset=2 * MS, parameters={"trim": 0.25, "u[2]": 2.0}),
            part("body", 1, "continuous", parameters={"gain": 40.0, "u[3]": -0.0}),
            part("arm", 2, "continuous", parameters={"b": True}),
        ),
        connections=(
            wire("body.y[1]", "fast.u[1]", 1),
            wire("fast.y[1]", "slow.u[1]", 0, factor=2.5, offset=0.125),
            wire("slow.y[1]", "body.u[1]", 0, convert_units=False),
            wire("slow.y[2]", "body.u[2]", 0, convert_units=False),
            wire("slow.n", "body.k", 0),
            wire("fast.flag", "slow.b", 0),
            wire("body.n", "arm.k", 3),
            wire("body.y[1]", "arm.u[1]", 2),
            wire("arm.y[1]", "fast.u[2]", 1),
            wire("arm.flag", "body.b", 1),
        ),
        ports=(
            SystemPort(name="push", kind="input", component="arm", variable="u[3]"),
            SystemPort(name="order", kind="input", component="slow", variable="u[3]"),
            SystemPort(name="number", kind="input", component="fast", variable="k"),
            SystemPort(name="angle", kind="output", component="arm", variable="y[3]"),
            SystemPort(name="reply", kind="output", component="slow", variable="y[3]"),
            SystemPort(name="count", kind="output", component="fast", variable="n"),
        ),
    )  # fmt: skip
