"""Write the system files of the closed loop: components, periods and connections."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from flexsat.closed_loop import PORTS
from flexsat.design.chain import Designs
from flexsat.parameters import ConfigurationName
from flexsat.ports.plant import JITTER
from flexsat.ports.sensors import MEASUREMENTS, TRUTH
from flexsat.ports.table import Port
from lockstep import Component, Connection, System, write_ssd

from .scenarios import DURATION, SCENARIOS, ScenarioName, scalar_overrides, scenario_parameters

NANOSECOND = 1e-9

# What metrics and figures need; about 250 signals for the distributed configuration
RECORD = (
    "plant.attitude.mrp",
    "plant.rate",
    "plant.modal.displacement",
    "plant.modal.velocity",
    "plant.wheel.speed",
    "plant.rms_deformation",
    "controller.wheel.torque",
    "controller.reference.*",
)

# (from, to, ports of the same name at both ends, delay in steps of the producer, which are ticks with the stock rates).
# The plant is stepped last in a tick and its outputs are true at the end of its step, so that one step of delay means:
# the value that is true now.
WIRES = (
    ("plant", "sensors", TRUTH, 1),
    ("sensors", "controller", MEASUREMENTS, 0),
    ("sensors", "plant", JITTER, 0),
    ("controller", "plant", ("wheel.torque",), 0),
)


def connections(designs: Designs) -> tuple[Connection, ...]:
    """Return every scalar connection of the loop."""
    sizes = {
        component: {port.name: port for port in ports(getattr(designs.corrected, component))}
        for component, ports in PORTS.items()
    }
    periods, tick = component_periods(designs), base_tick(designs)
    found = []
    for source, target, names, steps in WIRES:
        delay = steps * periods[source] // tick
        for name in names:
            for element in scalar_names(sizes[source][name]):
                found.append(
                    Connection(from_component=source, output=element, to_component=target, input=element, delay=delay)
                )
    return tuple(found)


def component_periods(designs: Designs) -> dict[str, int]:
    """Return the period of each component [ns], in the order in which they are stepped."""
    rates = designs.corrected.config.rates
    return {
        component: round(getattr(rates, component) / NANOSECOND) for component in ("sensors", "controller", "plant")
    }


def base_tick(designs: Designs) -> int:
    """Return the longest tick that divides the period of each component [ns]."""
    return math.gcd(*component_periods(designs).values())


def scalar_names(port: Port) -> Sequence[str]:
    """Return the FMI names of a port's elements."""
    return [port.scalar_name(i) for i in range(port.length)]


def build_system(designs: Designs, scenario: ScenarioName, folder: Path) -> System:
    """Return the system of one scenario, with its FMUs in `folder`."""
    name: ConfigurationName = designs.corrected.config.name
    parameters = scenario_parameters(scenario, slew=designs.corrected.config.slew)
    starts = {component: dict(ports) for component, ports in parameters.items()}
    applied = {p.name: p for p in PORTS["controller"](designs.corrected.controller)}["applied.wheel.torque"]
    # this controller acts itself; a shadow controller gets the torque that was applied
    starts["controller"] |= {"applied.wheel.torque": (0.0,) * applied.length, "applied.valid": False}
    starts["plant"] |= {"external.force": (0.0, 0.0, 0.0), "external.torque": (0.0, 0.0, 0.0)}
    flat = scalar_overrides(starts)
    periods = component_periods(designs)
    components = []
    for component, period in periods.items():
        prefix = f"{component}."
        components.append(
            Component(
                name=component,
                source=folder / f"{component}.fmu",
                period=period,
                kind="continuous" if component == "plant" else "sampled",
                parameters={key.removeprefix(prefix): value for key, value in flat.items() if key.startswith(prefix)},
            )
        )
    return System(
        name=f"{name}-{scenario.replace('_', '-')}",
        tick=base_tick(designs),
        components=tuple(components),
        connections=connections(designs),
        stop_time=round(DURATION / NANOSECOND),
        record=RECORD,
        record_period=periods["controller"],  # the samples that the cost is summed over
        strict_inputs=True,
    )


def write_systems(designs: Designs, folder: Path) -> list[Path]:
    """Write one system file for each scenario to the folder of the FMUs; return their paths."""
    paths = []
    for scenario in SCENARIOS:
        path = folder / f"{scenario}.ssd"
        write_ssd(build_system(designs, scenario, folder), path)
        paths.append(path)
    return paths
