"""The native plant and the Python stepper side by side, with the same parameters and inputs."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.ports import plant as interface
from flexsat.runtime import bearing_friction, plant
from flexsat.runtime.plant_parameters import PlantMatrices
from flexsat.runtime.prepared_plant import Motion
from flexsat.runtime.turning.state import turned_state
from flexsat.variants import chosen_by
from fmus.native.twin import Twin

TYPES = {"real": float, "integer": int, "boolean": bool}


class PlantPair:
    """Both start with the given values of ports, whose dots are written as two underscores."""

    def __init__(self, library: Path, variants: Mapping[str, PlantMatrices], step: float = 1e-3, **values: Any) -> None:
        self.ports = interface.ports(variants["corrected"])
        self.native = Twin(library, self.ports, **values)
        matrices = variants[chosen_by(self.value).name]
        self.matrices = interface.simulated(matrices, self.value)
        self.parameters = interface.parameters(self.matrices, self.value)
        self.motion = self.at_angles()
        self.change_step(step)
        self.state = plant.init(self.plant)
        self.native.start()
        table = self.native.table
        self.inputs = self.native.arrays["real"][table.run("input")]
        self.shown = slice(table.span("attitude.mrp").start, table.span("wheel.angle").stop)
        self.time = 0.0

    def value(self, name: str) -> Any:
        """Return the value of a port as the Python component reads it."""
        port, values = self.native.table[name], self.native.view(name)
        return values.copy() if port.size is not None else TYPES[port.kind](values[0])

    def at_angles(self) -> Motion:
        """Return the motion with appendages at their present angles."""
        return plant.prepare_motion(interface.at_present_angles(self.matrices, self.value), self.parameters)

    def turn(self, *angles: float) -> None:
        """Set the angles of the appendages that turn [rad] in both."""
        self.native.view("appendage.angle")[:] = angles
        before, self.motion = self.plant, self.at_angles()
        self.change_step(before.step_length)
        self.state = turned_state(before, self.plant, self.state, self.inputs, self.friction)
        self.native.tuned()

    def change_step(self, step: float) -> None:
        """Use steps of another length [s]; reads the friction of the wheels anew."""
        self.plant = plant.at_step(self.motion, step)
        limits = self.value("wheel.friction_torque")
        self.friction = bearing_friction.prepare(self.plant, limits) if limits.any() else None

    def excite(self, random: np.random.Generator) -> None:
        """Set random inputs: torques beyond their limit now and then, jitter, external loads."""
        n, wrenches = self.matrices.wheels, 6 * self.matrices.mounts
        self.inputs[:n] = 1.2 * self.matrices.torque_limit * random.uniform(-1.0, 1.0, n)
        self.inputs[n : n + wrenches] = 1e-2 * random.standard_normal(wrenches)
        self.inputs[n + wrenches :] = 0.1 * random.standard_normal(6)

    def advance(self) -> None:
        """Make a step in both."""
        plant.step(self.plant, self.state, self.inputs, self.friction)
        self.native.advance(self.time, self.plant.step_length)
        self.time += self.plant.step_length

    def run(self, steps: int, random: np.random.Generator) -> None:
        """Make steps with inputs that change every fifth of them."""
        for k in range(steps):
            if k % 5 == 0:
                self.excite(random)
            self.advance()

    def differences(self) -> dict[str, float]:
        """Return the largest difference of each output between the two, relative to its largest value."""
        names = {"modal.displacement": "modal_displacement", "modal.velocity": "modal_velocity", "energy": "energy",
                "angular_momentum": "angular_momentum", "rms_deformation": "rms_deformation"}  # fmt: skip
        telemetry = plant.telemetry(self.plant, self.state)
        self.native.evaluate()
        found = {}
        for port in self.ports:
            if port.causality != "output":
                continue
            native = self.native.view(port.name)
            if port.on_demand:
                expected = np.zeros(len(native))
                values = np.atleast_1d(getattr(telemetry, names[port.name]))
                expected[: len(values)] = values
            else:
                span = self.native.table.span(port.name)
                expected = self.state.outputs.flat[span.start - self.shown.start : span.stop - self.shown.start]
            size = max(np.abs(expected).max(), np.finfo(float).tiny)
            found[port.name] = float(np.abs(native - expected).max() / size)
        return found
