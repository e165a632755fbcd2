"""FMI life cycle of the flight controller; ports in flexsat.ports.controller, the law in flexsat.runtime.controller."""

from __future__ import annotations

from collections.abc import Sequence

from ...parameters import RUN_DURATION
from ...ports import controller as interface
from ...ports.table import Port
from ...runtime import controller
from ...runtime.controller_parameters import ControllerMatrices
from ...runtime.periods import whole_multiple
from ...variants import PUBLISHED
from .life_cycle import ComponentSlave
from .load_matrices import MODEL_FILE, load_matrices


class Controller(ComponentSlave):
    """The LQG attitude controller with its slew guidance."""

    description = "LQG attitude controller: periodic Kalman filter, slew guidance, regulator, known delays"
    stop_time = RUN_DURATION
    equal_steps = True

    def ports(self) -> Sequence[Port]:
        """Return the ports; their sizes are those of the design in the resources."""
        design = load_matrices(self.resource(MODEL_FILE), ControllerMatrices)
        self.preferred_step = design.period
        if design.jitter_torque.any():
            return interface.ports(design)
        other = load_matrices(self.resource(MODEL_FILE), ControllerMatrices, PUBLISHED)
        return interface.ports(design, cancels=bool(other.jitter_torque.any()))

    def start(self) -> None:
        """Sample the design for the parameters, and plan the slew."""
        path = self.resource(MODEL_FILE)
        matrices = load_matrices(path, ControllerMatrices, interface.variant(self.value))
        self._controller = self.in_use(controller.prepare(matrices, interface.parameters(matrices, self.value)))
        self._rotation, self._start_time = self.view("command.rotation"), self.view("command.start_time")
        self.state = controller.init(self._controller, self._rotation.copy(), float(self._start_time))
        names = ("gyro.rate", "accelerometer.acceleration", "encoder.speed", "encoder.angle", "star_tracker.mrp",
                 "star_tracker.valid", "applied.wheel.torque", "applied.valid")  # fmt: skip
        # views: what the master writes is what the controller sees
        self._measured = controller.Measurements(*(self.view(name) for name in names))
        self._torque, self._feed_forward = self.view("wheel.torque"), self.view("reference.torque")
        reals, span = self.values.arrays["real"], self.table.span
        # the ports of reference and estimate stand in the order of the linear state
        self._reference = reals[span("reference.mrp").start : span("reference.wheel.speed").stop]
        self._estimate = reals[span("estimate.mrp").start : span("estimate.wheel.speed").stop]
        self._slow_errors = reals[span("estimate.disturbance").start : span("estimate.gyro_bias").stop]

    def first_step(self, step: float) -> None:
        """Divide the period into steps of this length."""
        try:
            self._calls = whole_multiple("period", self.preferred_step, step)
        except ValueError:
            period = self.preferred_step
            raise ValueError(
                f"a step of {step:g} s is not accepted; the controller samples every {period:g} s, which its gains were"
                f" designed for: step it with that, or with a whole fraction of it, such as {period / 5.0:g} s"
            ) from None

    def advance(self, time: float, _step: float, /) -> None:
        """If a sample is due, use the measurements at `time`; the torque holds from `time` to the next sample."""
        if not controller.is_due(self.state, self._calls):
            return
        controller.command(self._controller, self.state, time, self._rotation.copy(), float(self._start_time))
        outputs = controller.step(self._controller, self.state, time, self._measured)
        self._torque[:] = outputs.torque
        self._feed_forward[:] = outputs.reference_torque
        self._reference[:] = outputs.reference
        self._estimate[:] = outputs.estimate[: len(self._estimate)]
        self._slow_errors[:] = outputs.slow_errors
