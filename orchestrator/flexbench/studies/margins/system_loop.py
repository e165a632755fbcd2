"""Read the attitude control loop from a system: its design if known, delays, parameters, injection directions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexsat.arrays import Array
from flexsat.closed_loop import port_values
from flexsat.design.chain import Design
from flexsat.ports import plant as plant_ports
from flexsat.spacecraft.assembly import Spacecraft, build_spacecraft
from flexsat.spacecraft.variation import ModelErrors, dispersed, with_angles
from flexsat.variants import VARIANT_PORT, chosen_by
from lockstep import InputError, System
from lockstep.fmi.model_description import read_description
from lockstep.fmi.parameter_values import parse_value
from lockstep.system.clock import seconds
from lockstep.system.component import Value

from ...loop.loop_parts import loop_parts
from ...loop.spacecraft import designs_for
from .analysis import AXES
from .designed_loop import Delays, DesignedLoop
from .injection import loop_channels
from .real_plant import Plants

SHARE_OF_LIMIT = 0.4  # peak of the test signal over a wheel's torque limit: far above the noise, far from saturation
QUIET: Mapping[str, Value] = {
    "sensors.gyro.noise": 0.0,
    "sensors.accelerometer.noise": 0.0,
    "sensors.encoder.noise": 0.0,
    "sensors.star_tracker.noise_coarse": 0.0,
    "sensors.star_tracker.noise_fine": 0.0,
    "sensors.jitter.enabled": False,
    "plant.initial.attitude_deviation": 0.0,
}  # no noise and no disturbance from flexsat's components
QUIET_CONTROLLER: Mapping[str, Value] = {"controller.jitter.feed_forward": False}


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemLoop:
    """The loop of a system: its two ends, what is known of its design, and directions of injection."""

    system: System
    controller: str
    plant: str
    designed: DesignedLoop | None  # None unless the controller is one of flexsat; its plant is that of the run
    real: Plants | None  # the structure of the run, with all modes that its plant carries
    directions: Array  # (m, d): columns along which to inject
    makes: Array  # (d, m): makes @ directions = 1
    names: tuple[str, ...]  # (d,)
    amplitude: float | None  # peak along a direction's largest share, in the unit of the plant's inputs
    slow_period: float | None  # s
    limit: float | None  # of every input of the plant, in its unit; None if it is not known
    quiet: Mapping[str, Value]  # overrides that make a run quiet

    @property
    def period(self) -> float:
        """Period of the controller [s]."""
        return seconds(self.system.component(self.controller).period)


def weakest(design: Design) -> float:
    """Return the torque limit of the weakest wheel [N.m]."""
    return float(design.controller.torque_limit * design.controller.torque_limit_factor.min())


def read_loop(
    system: System,
    overrides: Mapping[str, Value],
    controller: str = "controller",
    plant: str = "plant",
    channels: bool = False,
) -> SystemLoop:
    """Read the loop of a system.

    Parameters
    ----------
    system, overrides : what is run, with values by `component.parameter`
    controller, plant : names of the two components
    channels : inject into one input of the plant at a time, also where body axes are known

    Raises
    ------
    InputError
        If nothing Real goes from one to the other.
    """
    wires = loop_channels(system, controller, plant)
    design = _design(system, plant, controller, overrides)
    own_controller = _model(system, controller) == f"controller_{design.config.name}" if design is not None else False
    designed = real = None
    if design is not None and own_controller:
        spacecraft, modes, gyroscopic = _flown(design, _given(system, plant, overrides))
        real = Plants(design, real=spacecraft, gyroscopic=gyroscopic)
        designed = DesignedLoop(
            design=design,
            plant=real.model(modes, ModelErrors()),
            delays=_delays(system, controller, plant, design.config.rates.controller),
            parameters=_given(system, controller, overrides),
        )
    if design is None or channels or len(wires) != design.spacecraft.wheel_count:
        one = np.eye(len(wires))
        directions, makes, names = one, one, tuple(wire.input for wire in wires)
    else:
        makes = -design.controller.wheel_axis.T
        directions, names = np.asarray(np.linalg.pinv(makes)), AXES
    return SystemLoop(
        system=system,
        controller=controller,
        plant=plant,
        designed=designed,
        real=real,
        directions=directions,
        makes=makes,
        names=names,
        amplitude=None if design is None else SHARE_OF_LIMIT * weakest(design),
        limit=None if design is None else weakest(design),
        slow_period=None if design is None else design.config.rates.star_tracker,
        quiet={} if design is None else {**QUIET, **(QUIET_CONTROLLER if own_controller else {})},
    )


def with_controller(system: System, controller: str, fmu: Path) -> System:
    """Return the system with another FMU as its controller.

    Parameters that the FMU does not have are left out, and so are connections to inputs that it does not have: a
    vendor's controller need not use every measurement. Its outputs must be there.
    """
    old = system.component(controller)
    new = replace(old, source=fmu.absolute(), archive=None, connectors=None)
    known = read_description(new).variables
    new = replace(new, parameters={name: value for name, value in old.parameters.items() if name in known})
    return replace(
        system,
        components=tuple(new if component.name == controller else component for component in system.components),
        connections=tuple(c for c in system.connections if c.to_component != controller or c.input in known),
    )


def _model(system: System, component: str) -> str:
    return read_description(system.component(component)).model.removesuffix("_flat")


def _design(system: System, plant: str, controller: str, overrides: Mapping[str, Value]) -> Design | None:
    model = _model(system, plant)
    parts = loop_parts(system)
    if parts is None or model != f"plant_{parts.configuration}":
        return None
    designs = designs_for(parts.configuration, parts.plant.source)
    of_plant, of_controller = (_given(system, part, overrides) for part in (plant, controller))
    variant = chosen_by(of_plant.get, of_controller.get("design"))
    if variant not in designs.variants:
        raise InputError(f"{plant}.{VARIANT_PORT}: nothing of {parts.configuration} was published; set it to false")
    return designs.variant(variant)


def _flown(design: Design, given: Mapping[str, Value]) -> tuple[Spacecraft, int, bool]:
    """Return the spacecraft of a run with the errors that it was given, its modelled modes, and if wheels are gyros."""
    ports = plant_ports.ports(design.plant)
    known = {port.name for port in ports if port.causality == "parameter"}
    parameters = {name: value for name, value in given.items() if name.partition("[")[0] in known}
    values = port_values("plant", ports, parameters)
    angles, structure = values.get(plant_ports.ANGLE, design.plant.turn_angle), design.structure
    if not np.array_equal(angles, design.plant.turn_angle):
        turned = with_angles(design.config, angles.tolist())
        structure = build_spacecraft(turned, turned.release_for(design.variant))
    real = dispersed(
        structure,
        values["dispersion.frequency"],
        values["dispersion.damping"],
        values["dispersion.inertia"],
        values["dispersion.participation"],
    )
    return real, int(values["modes"]) or real.mode_count, bool(values["gyroscopics"])


def _given(system: System, component: str, overrides: Mapping[str, Value]) -> dict[str, Value]:
    """Return what is set on a component, each value of its variable's type; the master refuses what it lacks."""
    known = read_description(system.component(component)).variables
    own = {name.partition(".")[2]: value for name, value in overrides.items() if name.startswith(f"{component}.")}
    given = {**system.component(component).parameters, **own}
    return {
        name: parse_value(value, known[name], f"{component}.{name}") for name, value in given.items() if name in known
    }


def _delays(system: System, controller: str, plant: str, sampling: float) -> Delays:
    """Return the delays of the connections around the loop.

    What the plant's outputs are older than the moment delays the loop as much as its input does.
    """
    tick = seconds(system.tick)
    late = {
        ends: max((c.delay for c in system.connections if (c.from_component, c.to_component) == ends), default=0)
        for ends in {(c.from_component, c.to_component) for c in system.connections}
    }
    sensed = max((ticks - 1 for ends, ticks in late.items() if ends[0] == plant), default=0)
    read = max((ticks for ends, ticks in late.items() if ends[1] == controller and ends[0] != plant), default=0)
    if (controller, plant) not in late:
        raise InputError(f"{controller} -> {plant}: no such connection")
    return Delays(
        samples=int(np.ceil(read * tick / sampling - 1e-9)),
        actuation=(late[controller, plant] + sensed) * tick,
    )
