"""FMI life cycle of the plant; its ports are flexsat.ports.plant, the physics is flexsat.runtime.plant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...parameters import RUN_DURATION
from ...ports import plant as interface
from ...ports.table import Port
from ...runtime import bearing_friction, plant
from ...runtime.named_state import NamedValues
from ...runtime.plant_parameters import PlantMatrices
from ...runtime.turning.state import turned_state
from ...variants import chosen_by
from .life_cycle import ComponentSlave
from .load_matrices import MODEL_FILE, load_matrices
from .port_values import AnyArray

STRUCTURE = "structure"  # name of a saved state's motion of body and structure
KEPT_STEPS = 8  # prepared plants, a few hundred kB each


class Plant(ComponentSlave):
    """The flexible spacecraft with its reaction wheels."""

    description = "Flexible spacecraft: rigid body, structural modes, reaction wheels"
    stop_time = RUN_DURATION

    def ports(self) -> Sequence[Port]:
        """Return the ports; their sizes are those of the model in the resources."""
        model = load_matrices(self.resource(MODEL_FILE), PlantMatrices)
        self.preferred_step = model.step_size
        return interface.ports(model)

    def start(self) -> None:
        """Draw the random initial values, and make the state."""
        path = self.resource(MODEL_FILE)
        self._matrices = interface.simulated(load_matrices(path, PlantMatrices, chosen_by(self.value)), self.value)
        self._parameters = interface.parameters(self._matrices, self.value)
        at_angles = interface.at_present_angles(self._matrices, self.value)
        self._motion = plant.prepare_motion(at_angles, self._parameters, fixed_order=self.fixed_order)
        self._plant = self.in_use(plant.at_step(self._motion, self.preferred_step))
        self._plants = {self.preferred_step: self._plant}
        self.state = plant.init(self._plant)
        self._prepare_friction()
        reals = self.values.arrays["real"]
        self._inputs = reals[self.table.run("input")]
        self._shown = reals[self.table.span("attitude.mrp").start : self.table.span("wheel.angle").stop]
        np.copyto(self._shown, self.state.outputs.flat)

    def advance(self, _time: float, step: float, /) -> None:
        """Hold the inputs over the step; the outputs are true at its end."""
        if step != self._plant.step_length:
            self._change_step(round(step, 9))  # masters that subtract times give the same step with other last digits
        outputs = plant.step(self._plant, self.state, self._inputs, self._friction)
        np.copyto(self._shown, outputs.flat)

    def _change_step(self, step: float) -> None:
        """Use the plant prepared for a step, or prepare it; keep a few, for masters that change between them."""
        if not step > 0.0:
            raise ValueError(f"a step of {step!r} s is not accepted; the shortest is 1e-9 s")
        if step not in self._plants:
            if len(self._plants) == KEPT_STEPS:
                self._plants.pop(next(iter(self._plants)))
            self._plants[step] = self.in_use(plant.at_step(self._motion, step))
        self._plant = self._plants[step]
        self._prepare_friction()

    def tuned(self) -> None:
        """Use the friction of the wheels and the angles of appendages, which may change at any time."""
        before = self._plant
        angles = self._motion.matrices.turn_angle
        turned = len(angles) > 0 and not np.array_equal(self.view(interface.ANGLE), angles)
        if turned:
            matrices = interface.at_present_angles(self._matrices, self.value)
            self._motion = plant.prepare_motion(matrices, self._parameters, fixed_order=self.fixed_order)
            self._plant = self.in_use(plant.at_step(self._motion, before.step_length))
            self._plants = {before.step_length: self._plant}
        self._prepare_friction()
        if turned:
            self.state = turned_state(before, self._plant, self.state, self._inputs, self._friction)
            np.copyto(self._shown, self.state.outputs.flat)

    def _prepare_friction(self) -> None:
        limits = self.value("wheel.friction_torque")
        self._friction = bearing_friction.prepare(self._plant, limits) if limits.any() else None

    def follow_inputs(self) -> None:
        """Compute the accelerations with the present inputs."""
        outputs = plant.feed_through(self._plant, self.state, self._inputs, self._friction)
        np.copyto(self._shown, outputs.flat)

    def saved_state(self) -> NamedValues:
        """Add the motion of the structure: the coordinates of free modes are those of this machine's linear algebra."""
        saved = super().saved_state()
        if self.state is not None:
            saved[STRUCTURE] = plant.structure_motion(self._plant, self.state)
        return saved

    def restore_state(self, saved: Mapping[str, AnyArray], /) -> None:
        """Take the coordinates if they mean the saved motion here too, otherwise compute them from it."""
        if STRUCTURE not in saved:
            raise ValueError(f"the saved state lacks {STRUCTURE}, which this component needs")
        super().restore_state({name: value for name, value in saved.items() if name != STRUCTURE})
        plant.agree(self._plant, self.state, saved[STRUCTURE])

    def evaluate(self) -> None:
        """Compute the telemetry."""
        telemetry = plant.telemetry(self._plant, self.state)
        self.view("angular_momentum")[:] = telemetry.angular_momentum
        self.view("energy")[()] = telemetry.energy
        for name, values in (
            ("modal.displacement", telemetry.modal_displacement),
            ("modal.velocity", telemetry.modal_velocity),
        ):
            shown = self.view(name)
            shown[: len(values)], shown[len(values) :] = values, 0.0
        self.view("rms_deformation")[()] = telemetry.rms_deformation
