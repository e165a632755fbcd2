"""Run the whole closed loop in one plain Python loop, the monolith: no FMI, no files, no master.

The same steppers as in the FMUs, called in the order of a tick: sensors, controller, plant. It is the reference that
the co-simulation must reproduce, and the lower bound that its speed is compared with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from .arrays import Array
from .design.chain import Designs
from .ports import controller as controller_ports
from .ports import plant as plant_ports
from .ports import sensors as sensor_ports
from .ports.table import Port
from .runtime import bearing_friction, controller, plant, sensors
from .runtime.periods import whole_multiple
from .slow_errors import TORQUES
from .variants import chosen_by

Parameters = Mapping[str, Mapping[str, Any]]  # component, then port (or `port[i]`), to value

PORTS: dict[str, Callable[[Any], tuple[Port, ...]]] = {
    "plant": plant_ports.ports,
    "sensors": sensor_ports.ports,
    "controller": controller_ports.ports,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Signals by `component.port`: (rows,) or (rows, size). A row holds what is true at its time."""

    time: Array  # (rows,) [s]
    signals: Mapping[str, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A slew commanded during a run: values of the controller's command inputs from a time on."""

    time: float  # s
    rotation: tuple[float, float, float]  # rad
    start: float  # s


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
    """The closed loop of one configuration, prepared; it may run several times, each from rest."""

    def __init__(self, designs: Designs, parameters: Parameters) -> None:
        """Prepare all three components as their FMUs do.

        Raises
        ------
        ValueError
            For an unknown component or parameter, or a value that a component refuses.
        """
        for component in parameters:
            if component not in PORTS:
                raise ValueError(f"{component}: no such component; there are {', '.join(PORTS)}")
        self.values, models = {}, {}
        for name, ports in PORTS.items():
            declared = ports(getattr(designs.corrected, name))
            values = self.values[name] = port_values(name, declared, parameters.get(name, {}))
            choose = controller_ports.variant if name == "controller" else chosen_by
            models[name] = getattr(designs.variant(choose(values.__getitem__)), name)
        models["plant"] = plant_ports.simulated(models["plant"], self.values["plant"].__getitem__)
        models["plant"] = plant_ports.at_present_angles(models["plant"], self.values["plant"].__getitem__)
        self.modal_size = designs.corrected.plant.modes  # of the plant's ports
        self.known_modes = models["controller"].modes
        rates = designs.corrected.config.rates
        self.step = rates.plant
        self.controller_ticks = whole_multiple("controller period", rates.controller, self.step)
        if self.values["sensors"]["step_size"] not in (0.0, self.step):
            raise ValueError(f"sensors.step_size must be {self.step} s in the monolith: it has one tick")
        self.mounts = models["plant"].mounts
        self.plant_inputs = [port.name for port in plant_ports.ports(models["plant"]) if port.causality == "input"]
        self.plant = plant.prepare(
            models["plant"], plant_ports.parameters(models["plant"], self.values["plant"].__getitem__), self.step
        )
        self.sensors = sensors.prepare(
            sensor_ports.parameters(models["sensors"], self.values["sensors"].__getitem__, self.step)
        )
        self.controller = controller.prepare(
            models["controller"],
            controller_ports.parameters(models["controller"], self.values["controller"].__getitem__),
        )
        limits = self.values["plant"]["wheel.friction_torque"]
        self.friction = bearing_friction.prepare(self.plant, limits) if limits.any() else None

    def run(
        self, stop: float, record: Sequence[str], record_ticks: int = 5, commands: Sequence[Command] = ()
    ) -> Recording:
        """Run from rest to `stop` [s], recording ports named `component.port` every `record_ticks` ticks.

        The row at the stop time holds the samples that sensors and controller take there. `commands`, in the order of
        their times, change the controller's command inputs during the run.
        """
        ticks = whole_multiple("stop time", stop, self.step)
        step = Fraction(self.step).limit_denominator(10**9)  # whole nanoseconds, or 1/1200 s: times are nearest doubles
        given = self.values["controller"]
        rotation, start = given["command.rotation"], given["command.start_time"]
        plant_state, sensor_state = plant.init(self.plant), sensors.init(self.sensors)
        controller_state = controller.init(self.controller, rotation, start)
        waiting = list(commands)

        # the outputs are buffers of the states: these inputs follow them
        true, sensed, torque = plant_state.outputs, sensor_state.outputs, controller_state.outputs.torque
        sensor_inputs = sensors.SensorInputs(
            true.quaternion,
            true.gyro_site_rate,
            true.accelerometer_site_acceleration,
            true.wheel_speed,
            true.wheel_angle,
        )
        measured = controller.Measurements(
            sensed.gyro_rate,
            sensed.accelerometer,
            sensed.encoder_speed,
            sensed.encoder_angle,
            sensed.star_tracker_mrp,
            sensed.star_tracker_valid,
        )
        n = self.plant.wheels
        inputs = np.concatenate([self.values["plant"][name] for name in self.plant_inputs])
        wrench = inputs[n : n + len(sensed.wrench)]
        plant.feed_through(self.plant, plant_state, inputs, self.friction)

        known, on_demand = self._readers(plant_state, sensed, controller_state.outputs), self._on_demand()
        for name in record:
            if name not in known and name not in on_demand:
                raise ValueError(f"{name}: the monolith has no such output")
        rows = ticks // record_ticks + 1
        readers = {name: known[name] for name in record if name in known}
        demanded = {name: on_demand[name] for name in record if name in on_demand}
        signals = {name: np.empty((rows, *np.shape(read()))) for name, read in readers.items()}
        if demanded:
            first = plant.telemetry(self.plant, plant_state)
            signals |= {name: np.empty((rows, *np.shape(part(first)))) for name, part in demanded.items()}
        for tick in range((rows - 1) * record_ticks + 1):
            time = tick * step.numerator / step.denominator
            sensors.step(self.sensors, sensor_state, sensor_inputs)
            if tick % self.controller_ticks == 0:
                while waiting and waiting[0].time <= time:
                    rotation, start = np.array(waiting[0].rotation), waiting.pop(0).start
                controller.command(self.controller, controller_state, time, rotation, start)
                controller.step(self.controller, controller_state, time, measured)
                inputs[:n] = torque
            if tick % record_ticks == 0:
                row = tick // record_ticks
                for name, read in readers.items():
                    signals[name][row] = read()
                if demanded:
                    present = plant.telemetry(self.plant, plant_state)
                    for name, part in demanded.items():
                        signals[name][row] = part(present)
            wrench[:] = sensed.wrench
            plant.step(self.plant, plant_state, inputs, self.friction)
        times = np.array([row * record_ticks * step.numerator / step.denominator for row in range(rows)])
        return Recording(time=times, signals=signals)

    def _readers(
        self, state: plant.PlantState, sensed: sensors.SensorOutputs, commanded: controller.ControllerOutputs
    ) -> dict[str, Callable[[], Any]]:
        """Return a function for each output, `component.port`, that gives its present value."""
        true, modes, n = state.outputs, self.known_modes, self.plant.wheels
        buffers = {
            "plant.attitude.mrp": true.mrp,
            "plant.attitude.quaternion": true.quaternion,
            "plant.rate": true.rate,
            "plant.velocity": true.velocity,
            "plant.wheel.speed": true.wheel_speed,
            "plant.wheel.angle": true.wheel_angle,
            "plant.gyro_site.rate": true.gyro_site_rate,
            "plant.accelerometer_site.acceleration": true.accelerometer_site_acceleration,
            "sensors.gyro.rate": sensed.gyro_rate,
            "sensors.accelerometer.acceleration": sensed.accelerometer,
            "sensors.encoder.speed": sensed.encoder_speed,
            "sensors.encoder.angle": sensed.encoder_angle,
            "sensors.star_tracker.quaternion": sensed.star_tracker_quaternion,
            "sensors.star_tracker.mrp": sensed.star_tracker_mrp,
            "sensors.star_tracker.valid": sensed.star_tracker_valid,
            "controller.wheel.torque": commanded.torque,
            "controller.reference.torque": commanded.reference_torque,
        }
        buffers["controller.estimate.disturbance"] = commanded.slow_errors[:TORQUES]
        buffers["controller.estimate.gyro_bias"] = commanded.slow_errors[TORQUES:]
        for k, name in enumerate(plant_ports.JITTER):
            buffers[f"sensors.{name}"] = sensed.wrench[k * self.mounts : (k + 1) * self.mounts]
        parts = {
            "mrp": slice(0, 3),
            "modal.displacement": slice(3, 3 + modes),
            "rate": slice(3 + modes, 6 + modes),
            "modal.velocity": slice(6 + modes, 6 + 2 * modes),
            "wheel.speed": slice(6 + 2 * modes, 6 + 2 * modes + n),
        }
        for name, part in parts.items():
            buffers[f"controller.reference.{name}"] = commanded.reference[part]
            buffers[f"controller.estimate.{name}"] = commanded.estimate[part]
        return {name: buffer.view for name, buffer in buffers.items()}

    def _on_demand(self) -> dict[str, Callable[[plant.Telemetry], Any]]:
        """Return a function for each output of the plant's that is computed on demand."""
        parts: dict[str, Callable[[plant.Telemetry], Any]] = {
            f"plant.{port}": attrgetter(port) for port in ("angular_momentum", "energy", "rms_deformation")
        }
        for port in ("modal.displacement", "modal.velocity"):
            parts[f"plant.{port}"] = partial(self._of_all_modes, attrgetter(port.replace(".", "_")))
        return parts

    def _of_all_modes(self, read: Callable[[plant.Telemetry], Array], present: plant.Telemetry) -> Array:
        """Return modal values as the plant's ports show them: 0 for modes that are not simulated."""
        values = np.zeros(self.modal_size)
        values[: self.plant.modes] = read(present)
        return values
