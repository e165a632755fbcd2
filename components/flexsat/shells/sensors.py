"""FMI life cycle of sensors and wheel jitter; ports in flexsat.interfaces.sensors, models in flexsat.sensors."""

from __future__ import annotations

from collections.abc import Sequence

from .. import sensors
from ..interfaces import sensors as interface
from ..interfaces.ports import Port
from .base import SiSlave
from .matrices import MODEL_FILE, load_matrices


class Sensors(SiSlave):
    """Star tracker, gyros, accelerometers and encoders, and the jitter of the wheels."""

    description = "Sensors with noise and sampling, and the jitter that the wheels cause"
    preferred_step = 1e-3
    fixed_step = 1e-3
    stop_time = 300.0

    def ports(self) -> Sequence[Port]:
        """Return the ports; their sizes are those of the model in the resources."""
        return interface.ports(load_matrices(self.resource(MODEL_FILE), sensors.SensorMatrices))

    def start(self) -> None:
        """Sample the filter, and make the state."""
        model = load_matrices(
            self.resource(MODEL_FILE), sensors.SensorMatrices, as_published=self.value("as_published")
        )
        parameters = interface.parameters(model, self.value)
        self.fixed_step = parameters.step
        self._sensors = sensors.prepare(parameters)
        self.state = sensors.init(self._sensors)
        names = ("attitude.quaternion", "gyro_site.rate", "accelerometer_site.acceleration", "wheel.speed",
                 "wheel.angle")  # fmt: skip
        self._inputs = tuple(self.view(name) for name in names)
        reals = self.values.arrays["real"]
        first = self.table.span("jitter.force_a").start
        self._jitter = reals[first : self.table.span("jitter.torque_b").stop]
        self._samples = [
            (self.view(port), getattr(self.state.outputs, part))
            for port, part in (
                ("gyro.rate", "gyro_rate"),
                ("accelerometer.acceleration", "accelerometer"),
                ("encoder.speed", "encoder_speed"),
                ("encoder.angle", "encoder_angle"),
            )
        ]
        self._valid = self.view("star_tracker.valid")
        self._quaternion, self._mrp = self.view("star_tracker.quaternion"), self.view("star_tracker.mrp")
        self._show(everything=True)

    def advance(self, _time: float, _step: float, /) -> None:
        """Sample the inputs now; the outputs hold from now on."""
        due = self.state.count % self._sensors.parameters.fast_steps == 0
        sensors.step(self._sensors, self.state, *self._inputs)
        self._show(everything=due)

    def _show(self, everything: bool) -> None:
        outputs = self.state.outputs
        self._jitter[:] = outputs.jitter.ravel()
        if everything:
            for shown, value in self._samples:
                shown[:] = value
        if everything or outputs.star_tracker_valid or self._valid:
            self._valid[()] = outputs.star_tracker_valid
            self._quaternion[:], self._mrp[:] = outputs.star_tracker_quaternion, outputs.star_tracker_mrp
