"""Write the system files of the closed loop: components, periods and connections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from flexsat.closed_loop import PORTS
from flexsat.design.chain import Designs
from flexsat.parameters import RUN_DURATION, ConfigurationName
from flexsat.ports.plant import JITTER
from flexsat.ports.sensors import MEASUREMENTS, TRUTH
from flexsat.ports.table import Naming, Port
from lockstep import Component, Connection, System, write_ssd
from lockstep.system.clock import Time, common_divisor, nanoseconds
from lockstep.system.system import SystemPort

from .scenarios import SCENARIOS, ScenarioName, scalar_overrides, scenario_parameters

NANOSECOND = 1e-9
CLOSED = "closed"  # folder of the systems without connectors to the outside

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


# (kind, component, ports): connectors of the whole system: commands and disturbances in, attitude, pointing and torque
# out. Their names are flat in every system, as OMSimulator takes identifiers alone: command_rotation_1.
OUTSIDE = (
    ("input", "controller", ("command.rotation", "command.start_time")),
    ("input", "plant", ("external.force", "external.torque")),
    ("output", "plant", ("attitude.mrp", "attitude.quaternion", "rate", "wheel.speed", "rms_deformation")),
    ("output", "controller", ("wheel.torque", "reference.mrp")),
)


def connections(designs: Designs, naming: Naming = "structured") -> tuple[Connection, ...]:
    """Return every scalar connection of the loop."""
    known = ports_of(designs)
    periods, tick = component_periods(designs), base_tick(designs)
    found = []
    for source, target, names, steps in WIRES:
        delay = steps * periods[source] // tick
        for name in names:
            for element in scalar_names(known[source][name], naming):
                found.append(
                    Connection(from_component=source, output=element, to_component=target, input=element, delay=delay)
                )
    return tuple(found)


@lru_cache(maxsize=2)  # a build asks for them once for each scenario and each kind of FMU
def ports_of(designs: Designs) -> Mapping[str, Mapping[str, Port]]:
    """Return the ports of each component by name."""
    return {
        component: {port.name: port for port in ports(getattr(designs.corrected, component))}
        for component, ports in PORTS.items()
    }


def outside(designs: Designs, naming: Naming = "structured") -> tuple[SystemPort, ...]:
    """Return the connectors of the whole system, to variables in a naming."""
    known = ports_of(designs)
    return tuple(
        SystemPort(name=outer, kind=kind, component=component, variable=inner)
        for kind, component, names in OUTSIDE
        for name in names
        for outer, inner in zip(
            scalar_names(known[component][name], "flat"), scalar_names(known[component][name], naming), strict=True
        )
    )


def recorded(designs: Designs, naming: Naming = "structured") -> tuple[str, ...]:
    """Return the patterns of what is recorded."""
    return RECORD if naming == "structured" else tuple(_flat_pattern(pattern, designs) for pattern in RECORD)


def _flat_pattern(pattern: str, designs: Designs) -> str:
    component, _, name = pattern.partition(".")
    port = ports_of(designs)[component].get(name)
    array = "_*" if port is not None and port.size is not None else ""
    return f"{component}.{name.replace('.', '_')}{array}"


def component_periods(designs: Designs) -> dict[str, Time]:
    """Return the period of each component [ns], in the order in which they are stepped."""
    rates = designs.corrected.config.rates
    return {
        component: _exact(getattr(rates, component), f"Rates.{component}")
        for component in ("sensors", "controller", "plant")
    }


def _exact(period: float, what: str) -> Time:
    """Return a period [ns]: a whole number, or a fraction such as 1/1200 s."""
    whole = round(period / NANOSECOND)
    return whole if abs(whole * NANOSECOND - period) <= 1e-12 * period else nanoseconds(period, what)


def base_tick(designs: Designs) -> Time:
    """Return the longest tick that divides the period of each component [ns]."""
    return common_divisor(*component_periods(designs).values())


def scalar_names(port: Port, naming: Naming = "structured") -> Sequence[str]:
    """Return the FMI names of a port's elements."""
    return [port.scalar_name(i, naming) for i in range(port.length)]


def build_system(designs: Designs, scenario: ScenarioName, folder: Path, naming: Naming = "structured") -> System:
    """Return the system of one scenario, with its FMUs, whose names are as `naming` says, in `folder`."""
    name: ConfigurationName = designs.corrected.config.name
    parameters = scenario_parameters(scenario, slew=designs.corrected.config.slew)
    starts = {component: dict(ports) for component, ports in parameters.items()}
    applied = ports_of(designs)["controller"]["applied.wheel.torque"]
    # this controller acts itself; a shadow controller gets the torque that was applied
    starts["controller"] |= {"applied.wheel.torque": (0.0,) * applied.length, "applied.valid": False}
    starts["plant"] |= {"external.force": (0.0, 0.0, 0.0), "external.torque": (0.0, 0.0, 0.0)}
    values = scalar_overrides(starts)
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
                parameters={
                    _variable(key.removeprefix(prefix), naming): value
                    for key, value in values.items()
                    if key.startswith(prefix)
                },
            )
        )
    return System(
        name=f"{name}-{scenario.replace('_', '-')}",
        tick=base_tick(designs),
        components=tuple(components),
        connections=connections(designs, naming),
        stop_time=round(RUN_DURATION / NANOSECOND),
        record=recorded(designs, naming),
        record_period=periods["controller"],  # the samples that the cost is summed over
        strict_inputs=True,
        ports=outside(designs, naming),
    )


def _variable(name: str, naming: Naming) -> str:
    """Return the name of a variable, given as `wheel.torque[1]`, in a naming."""
    return name if naming == "structured" else name.replace(".", "_").replace("[", "_").rstrip("]")


def write_systems(designs: Designs, folder: Path, naming: Naming = "structured") -> list[Path]:
    """Write one system file for each scenario to the folder of the FMUs; return their paths."""
    paths = []
    for scenario in SCENARIOS:
        path = folder / f"{scenario}.ssd"
        write_ssd(build_system(designs, scenario, folder, naming), path)
        paths.append(path)
    return paths


def write_closed_systems(designs: Designs, folder: Path) -> list[Path]:
    """Write the same systems without connectors to the outside, into a folder in that of the FMUs; return their paths.

    libcosim and ecos refuse a system with such connectors: they know connections between components alone.
    """
    (folder / CLOSED).mkdir(exist_ok=True)
    paths = []
    for scenario in SCENARIOS:
        path = folder / CLOSED / f"{scenario}.ssd"
        write_ssd(replace(build_system(designs, scenario, folder), ports=()), path)
        paths.append(path)
    return paths
