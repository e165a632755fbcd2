"""System files of the closed loop: which FMU, how often, and what is connected to what."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexsat.closed_loop import PORTS
from flexsat.design.chain import Designs
from flexsat.parameters import ConfigurationName, Rates
from flexsat.ports.plant import JITTER
from flexsat.ports.table import Port
from lockstep import Component, Connection, System, write_ssd

from .scenarios import DURATION, SCENARIOS, ScenarioName, scalar_overrides, scenario_parameters

TICK = 1_000_000  # ns
RECORD_PERIOD = 5_000_000  # ns
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

TRUTH = ("attitude.quaternion", "wheel.speed", "gyro_site.rate", "accelerometer_site.acceleration", "wheel.angle")
MEASUREMENTS = (
    "gyro.rate",
    "accelerometer.acceleration",
    "encoder.speed",
    "encoder.angle",
    "star_tracker.mrp",
    "star_tracker.valid",
)
# (from, to, ports of the same name at both ends, delay in ticks). The plant is stepped last in a tick and its
# outputs are true at the tick's end, so that one tick of delay means: the value that is true now.
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
    found = []
    for source, target, names, delay in WIRES:
        for name in names:
            for element in scalar_names(sizes[source][name]):
                found.append(
                    Connection(from_component=source, output=element, to_component=target, input=element, delay=delay)
                )
    return tuple(found)


def scalar_names(port: Port) -> Sequence[str]:
    """Return the FMI names of a port's elements."""
    return [port.scalar_name(i) for i in range(port.length)]


def build_system(designs: Designs, scenario: ScenarioName, folder: Path) -> System:
    """Return the system of one scenario, with its FMUs in `folder`."""
    name: ConfigurationName = designs.corrected.config.name
    rates: Rates = designs.corrected.config.rates
    starts = {component: dict(ports) for component, ports in scenario_parameters(scenario).items()}
    applied = {p.name: p for p in PORTS["controller"](designs.corrected.controller)}["applied.wheel.torque"]
    # nobody else is in control; a controller that rides along as a shadow is told what was applied
    starts["controller"] |= {"applied.wheel.torque": (0.0,) * applied.length, "applied.valid": False}
    starts["plant"] |= {"external.force": (0.0, 0.0, 0.0), "external.torque": (0.0, 0.0, 0.0)}
    flat = scalar_overrides(starts)
    components = []
    for component, period, kind in (
        ("sensors", rates.sensors, "sampled"),
        ("controller", rates.controller, "sampled"),
        ("plant", rates.plant, "continuous"),
    ):
        prefix = f"{component}."
        components.append(
            Component(
                name=component,
                source=folder / f"{component}.fmu",
                period=round(period / NANOSECOND),
                kind="continuous" if kind == "continuous" else "sampled",
                parameters={key.removeprefix(prefix): value for key, value in flat.items() if key.startswith(prefix)},
            )
        )
    return System(
        name=f"{name}-{scenario.replace('_', '-')}",
        tick=TICK,
        components=tuple(components),
        connections=connections(designs),
        stop_time=round(DURATION / NANOSECOND),
        record=RECORD,
        record_period=RECORD_PERIOD,
    )


def write_systems(designs: Designs, folder: Path) -> list[Path]:
    """Write one system file a scenario beside the FMUs in `folder`; return their paths."""
    paths = []
    for scenario in SCENARIOS:
        path = folder / f"{scenario}.ssd"
        write_ssd(build_system(designs, scenario, folder), path)
        paths.append(path)
    return paths
