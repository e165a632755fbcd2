"""FMI life cycle of sensors and wheel jitter; ports in flexsat.ports.sensors, models in flexsat.runtime.sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from ...parameters import RUN_DURATION
from ...ports import sensors as interface
from ...ports.table import Port
from ...runtime import sensors
from ...runtime.sensor_parameters import SensorMatrices
from ...variants import chosen_by
from .life_cycle import ComponentSlave
from .load_matrices import MODEL_FILE, load_matrices


class Sensors(ComponentSlave):
    """Star tracker, gyros, accelerometers and encoders, and the jitter of the wheels."""

    description = "Sensors with noise and sampling, and the jitter that the wheels cause"
    step_parameter = "step_size"
    equal_steps = True
    stop_time = RUN_DURATION

    def ports(self) -> Sequence[Port]:
        """Return the ports; their sizes are those of the model in the resources."""
        model = load_matrices(self.resource(MODEL_FILE), SensorMatrices)
        self.preferred_step = model.step_size
        return interface.ports(model)

    def start(self) -> None:
        """Sample the filter for step_size, and make the state."""
        path = self.resource(MODEL_FILE)
        self._matrices = load_matrices(path, SensorMatrices, chosen_by(self.value))
        self.fixed_step = self.value("step_size") or None
        self._sensors = self.in_use(sensors.prepare(interface.parameters(self._matrices, self.value)))
        self.state = sensors.init(self._sensors)
        names = ("attitude.quaternion", "gyro_site.rate", "accelerometer_site.acceleration", "wheel.speed",
                 "wheel.angle")  # fmt: skip
        self._inputs = sensors.SensorInputs(*(self.view(name) for name in names))
        reals, first = self.values.arrays["real"], self.table.span("jitter.force_x").start
        wrench = reals[first : self.table.span("jitter.torque_z").stop]
        # the stepper writes straight into the ports
        self.state.outputs = sensors.SensorOutputs(
            star_tracker_quaternion=self._port("star_tracker.quaternion", self.state.outputs.star_tracker_quaternion),
            star_tracker_mrp=self._port("star_tracker.mrp", self.state.outputs.star_tracker_mrp),
            star_tracker_valid=self._port("star_tracker.valid", self.state.outputs.star_tracker_valid),
            gyro_rate=self._port("gyro.rate", self.state.outputs.gyro_rate),
            accelerometer=self._port("accelerometer.acceleration", self.state.outputs.accelerometer),
            encoder_speed=self._port("encoder.speed", self.state.outputs.encoder_speed),
            encoder_angle=self._port("encoder.angle", self.state.outputs.encoder_angle),
            wrench=wrench,
        )

    def first_step(self, step: float) -> None:
        """Sample the filter for steps of this length."""
        self._sensors = self.in_use(sensors.prepare(interface.parameters(self._matrices, self.value, step)))

    def advance(self, _time: float, _step: float, /) -> None:
        """Sample the inputs now; the outputs hold from now on."""
        sensors.step(self._sensors, self.state, self._inputs)

    def tuned(self) -> None:
        """Begin all noise anew, as the seed was set."""
        sensors.begin_noise(self.state, self.value("seed"))

    def _port(self, name: str, initial: NDArray[Any]) -> NDArray[Any]:
        view = self.view(name)
        view[...] = initial
        return view
