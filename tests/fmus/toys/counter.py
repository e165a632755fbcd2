"""A toy with everything a component can have: a filter with noise, an energy on demand, switches and names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fmu.python.life_cycle import ComponentSlave
from ..ports.table import Port

GAIN = 2.0  # tests change this line to make another build


@dataclass(slots=True, kw_only=True)
class State:
    """State of a run."""

    level: np.ndarray
    generator: np.random.Generator
    recent: np.ndarray
    steps: int


class Counter(ComponentSlave):
    """Add noisy torque to levels; fail when asked to."""

    description = "Toy component of the tests"
    preferred_step = 1e-2
    evaluations = 0

    def ports(self):
        return (
            Port(name="gain", causality="parameter", unit="1/s", description="growth", start=1.0, minimum=0.0),
            Port(name="seed", causality="parameter", kind="integer", description="random seed", start=7),
            Port(name="label", causality="parameter", kind="string", description="a name", start="toy"),
            Port(name="wheel.torque", causality="input", unit="N.m", description="torque", size=3, frame="body"),
            Port(name="explode", causality="input", kind="boolean", description="raise in the next step"),
            Port(name="poison", causality="input", description="1 to give a non-finite output"),
            Port(
                name="level",
                causality="output",
                unit="N.m.s",
                description="sum of the torque",
                size=3,
                depends_on=("wheel.torque[i]",),
            ),
            Port(name="angle", causality="output", unit="rad", description="an angle", display_unit="arcsec"),
            Port(name="energy", causality="output", unit="J", description="costly", on_demand=True),
            Port(name="evaluations", causality="output", kind="integer", description="how often energy was computed"),
            Port(name="valid", causality="output", kind="boolean", description="true after the first step"),
            Port(name="greeting", causality="output", kind="string", description="label and steps"),
        )

    def start(self):
        if self.value("label") == "refuse":
            raise ValueError("label must not be 'refuse'")
        self.state = State(
            level=np.full(3, self.value("gain")),
            generator=np.random.default_rng(self.value("seed")),
            recent=np.zeros(4),
            steps=0,
        )
        self.view("level")[:] = self.state.level

    def advance(self, time, step):
        state = self.state
        if self.view("explode"):
            raise RuntimeError(f"asked to at 100% of {time} s")
        state.recent[state.steps % 4] = state.generator.normal()
        state.level += step * (GAIN * self.view("wheel.torque") + self.value("gain") * np.mean(state.recent))
        state.steps += 1
        self.view("level")[:] = state.level
        self.view("angle")[()] = np.nan if self.view("poison") else time + step
        self.view("valid")[()] = True
        self.values.put("greeting", f"{self.value('label')} {state.steps}")

    def evaluate(self):
        self.evaluations += 1
        self.view("energy")[()] = self.state.level @ self.state.level
        self.view("evaluations")[()] = self.evaluations
