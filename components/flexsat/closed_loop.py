"""The whole closed loop in one plain Python loop: no FMI, no files, no master.

The same steppers as in the FMUs, called in the order of a tick: sensors, controller, plant. It is the reference that
the co-simulation must reproduce, and the floor that its speed is measured against.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from .arrays import Array
from .design.chain import Designs
from .ports import controller as controller_interface
from .ports import plant as plant_interface
from .ports import sensors as sensor_interface
from .ports.table import Port
from .runtime import controller, plant, sensors
from .runtime.bearing_friction import Bearings
from .runtime.periods import whole_multiple

T = TypeVar("T")
Parameters = Mapping[str, Mapping[str, Any]]  # component, then port (or `port[i]`), to value

PORTS: dict[str, Callable[[Any], tuple[Port, ...]]] = {
    "plant": plant_interface.ports,
    "sensors": sensor_interface.ports,
    "controller": controller_interface.ports,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Signals by `component.port`: (rows,) or (rows, size). A row holds what is true at its time."""

    time: Array  # (rows,) [s]
    signals: Mapping[str, Array]


def port_values(component: str, ports: Sequence[Port], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return every input's and parameter's value: the start value, or what is given for the port or an element.

    Raises
    ------
    ValueError
        For a name that is no parameter or input.
    """
    values: dict[str, Any] = {}
    for port in ports:
        if port.causality != "output":
            values[port.name] = np.array(port.start) if port.size is not None else port.start
    for name, value in given.items():
        base, bracket, element = name.partition("[")
        if base not in values:
            raise ValueError(f"{component}.{name}: no such parameter or input")
        if bracket:
            values[base][int(element.rstrip("]")) - 1] = value
        elif np.ndim(values[base]):
            values[base][:] = value
        else:
            values[base] = value
    return values


class ClosedLoop:
    """The closed loop of one configuration, ready to run once."""

    def __init__(self, designs: Designs, parameters: Parameters) -> None:
        """Prepare all three components as their FMUs would.

        Raises
        ------
        ValueError
            For an unknown component or parameter, or a value that a component refuses.
        """
        for component in parameters:
            if component not in PORTS:
                raise ValueError(f"{component}: no such component; there are {', '.join(PORTS)}")
        self.values = {}
        models = {}
        for name, ports in PORTS.items():
            declared = ports(getattr(designs.corrected, name))
            values = self.values[name] = port_values(name, declared, parameters.get(name, {}))
            models[name] = getattr(designs.as_published if values["as_published"] else designs.corrected, name)
        rates = designs.corrected.config.rates
        self.step = rates.plant
        self.controller_ticks = whole_multiple("controller period", rates.controller, self.step)
        if self.values["sensors"]["step_size"] != self.step:
            raise ValueError(f"sensors.step_size must be {self.step} s in the monolith: it has one tick")
        self.plant = plant.Plant(
            models["plant"], plant_interface.parameters(models["plant"], self.values["plant"].__getitem__), self.step
        )
        self.sensors = sensors.prepare(
            sensor_interface.parameters(models["sensors"], self.values["sensors"].__getitem__)
        )
        self.controller = controller.Controller(
            models["controller"],
            controller_interface.parameters(models["controller"], self.values["controller"].__getitem__),
        )

    def run(self, stop: float, record: Sequence[str], record_ticks: int = 5) -> Recording:
        """Run from rest to `stop` [s], recording ports named `component.port` every `record_ticks` ticks."""
        ticks = whole_multiple("stop time", stop, self.step)
        tick_ns = round(self.step * 1e9)  # whole nanoseconds, so that times are the nearest doubles
        command = self.values["controller"]
        rotation, start = command["command.rotation"], command["command.start_time"]
        plant_state, sensor_state = plant.init(self.plant), sensors.init(self.sensors)
        controller_state = controller.init(self.controller, rotation, start)
        seen, measured = plant.observe(self.plant, plant_state), sensor_state.outputs
        commanded = controller.ControllerOutputs.at_rest(self.controller)

        n = self.plant.wheels
        inputs = np.concatenate(
            [self.values["plant"][p.name] for p in PORTS["plant"](self.plant.matrices) if p.causality == "input"]
        )
        friction = self.values["plant"]["wheel.friction_torque"]
        bearings = Bearings(self.plant, friction) if friction.any() else None
        rows = -(-ticks // record_ticks)
        readers = {name: self._reader(name, plant_state) for name in record}
        signals = {name: np.empty((rows, *np.shape(read(seen, measured, commanded)))) for name, read in readers.items()}
        for tick in range(ticks):
            time = tick * tick_ns / 1e9
            _, measured = sensors.step(
                self.sensors,
                sensor_state,
                seen.quaternion,
                seen.gyro_site_rate,
                seen.accelerometer_site_acceleration,
                seen.wheel_speed,
                seen.wheel_angle,
            )
            if tick % self.controller_ticks == 0:
                controller.command(self.controller, controller_state, time, rotation, start)
                _, commanded = controller.step(
                    self.controller,
                    controller_state,
                    time,
                    controller.Measurements(
                        measured.gyro_rate,
                        measured.accelerometer,
                        measured.encoder_speed,
                        measured.encoder_angle,
                        measured.star_tracker_mrp,
                        measured.star_tracker_valid,
                    ),
                )
                inputs[:n] = commanded.torque
            if tick % record_ticks == 0:
                row = tick // record_ticks
                for name, read in readers.items():
                    signals[name][row] = read(seen, measured, commanded)
            inputs[n : n + len(measured.wrench)] = measured.wrench
            _, seen = plant.step(self.plant, plant_state, inputs, bearings)
        times = np.array([row * record_ticks * tick_ns / 1e9 for row in range(rows)])
        return Recording(time=times, signals=signals)

    def _reader(self, name: str, state: plant.PlantState) -> Callable[..., Any]:
        """Return a function of the three outputs that gives a port's value."""
        component, _, port = name.partition(".")
        modes, n = self.plant.modes, self.plant.wheels
        parts = {
            "mrp": slice(0, 3),
            "modal.displacement": slice(3, 3 + modes),
            "rate": slice(3 + modes, 6 + modes),
            "modal.velocity": slice(6 + modes, 6 + 2 * modes),
            "wheel.speed": slice(6 + 2 * modes, 6 + 2 * modes + n),
        }
        kind, _, rest = port.partition(".")
        if component == "controller" and kind in ("reference", "estimate") and rest in parts:
            part = parts[rest]
            return lambda _seen, _measured, commanded: getattr(commanded, kind)[part]
        readers: dict[str, Callable[..., Any]] = {
            "controller.wheel.torque": lambda _seen, _measured, commanded: commanded.torque,
            "controller.reference.torque": lambda _seen, _measured, commanded: commanded.reference_torque,
            "plant.attitude.mrp": lambda seen, _measured, _commanded: seen.mrp,
            "plant.attitude.quaternion": lambda seen, _measured, _commanded: seen.quaternion,
            "plant.rate": lambda seen, _measured, _commanded: seen.rate,
            "plant.velocity": lambda seen, _measured, _commanded: seen.velocity,
            "plant.modal.displacement": lambda seen, _measured, _commanded: seen.modal_displacement,
            "plant.modal.velocity": lambda seen, _measured, _commanded: seen.modal_velocity,
            "plant.wheel.speed": lambda seen, _measured, _commanded: seen.wheel_speed,
            "plant.wheel.angle": lambda seen, _measured, _commanded: seen.wheel_angle,
            "plant.gyro_site.rate": lambda seen, _measured, _commanded: seen.gyro_site_rate,
            "plant.accelerometer_site.acceleration": (
                lambda seen, _measured, _commanded: seen.accelerometer_site_acceleration
            ),
            "plant.rms_deformation": lambda seen, _measured, _commanded: seen.rms_deformation[0],
            "plant.angular_momentum": lambda *_: plant.telemetry(self.plant, state).angular_momentum,
            "plant.energy": lambda *_: plant.telemetry(self.plant, state).energy,
            "sensors.gyro.rate": lambda _seen, measured, _commanded: measured.gyro_rate,
            "sensors.accelerometer.acceleration": lambda _seen, measured, _commanded: measured.accelerometer,
            "sensors.encoder.speed": lambda _seen, measured, _commanded: measured.encoder_speed,
            "sensors.encoder.angle": lambda _seen, measured, _commanded: measured.encoder_angle,
            "sensors.star_tracker.quaternion": (lambda _seen, measured, _commanded: measured.star_tracker_quaternion),
            "sensors.star_tracker.mrp": lambda _seen, measured, _commanded: measured.star_tracker_mrp,
            "sensors.star_tracker.valid": lambda _seen, measured, _commanded: measured.star_tracker_valid,
        }
        mounts = self.plant.matrices.mounts
        for k, jitter in enumerate(plant_interface.JITTER):
            part = slice(k * mounts, (k + 1) * mounts)
            readers[f"sensors.{jitter}"] = lambda _seen, measured, _commanded, part=part: measured.wrench[part]
        if name not in readers:
            raise ValueError(f"{name}: the monolith has no such output")
        return readers[name]
