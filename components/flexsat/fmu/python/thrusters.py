"""FMI life cycle of the thrusters; ports in flexsat.ports.thrusters, the model in flexsat.runtime.missions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...parameters import MISSION_DURATION
from ...ports import thrusters as interface
from ...ports.table import Port
from ...runtime.missions import thrusters
from ...runtime.missions.mission_data import MissionData
from .life_cycle import ComponentSlave
from .load_matrices import MODEL_FILE, load_matrices


class Thrusters(ComponentSlave):
    """Thrusters that act beside the environment."""

    description = "Thrusters with minimum impulse, rate, noise and lag, beside the torque of an environment"
    equal_steps = True
    stop_time = MISSION_DURATION

    def ports(self) -> Sequence[Port]:
        """Return the ports; the step is that of the controller."""
        data = load_matrices(self.resource(MODEL_FILE), MissionData)
        self.preferred_step = data.period
        return interface.ports(data)

    def start(self) -> None:
        """Close all thrusters; the environment acts."""
        self._thrusters = thrusters.prepare(interface.parameters(self.value, float(self.value("thrust.period"))))
        self.state = thrusters.init(self._thrusters)
        self._show(np.zeros(interface.COUNT))

    def first_step(self, step: float) -> None:
        """Divide the period into steps of this length."""
        self._thrusters = thrusters.prepare(interface.parameters(self.value, step))

    def advance(self, _time: float, _step: float, /) -> None:
        """Sample the commands where a period begins; the outputs are means from now over the step."""
        self._show(thrusters.step(self._thrusters, self.state, self.view("thrust.command")))

    def _show(self, thrust: np.ndarray) -> None:
        wrench = self._thrusters.wrench @ thrust
        self.view("external.force")[:] = self.view("disturbance.force") + wrench[:3]
        self.view("external.torque")[:] = self.view("disturbance.torque") + wrench[3:]
        self.view("thrust")[:] = thrust
        self.view("thrust.impulse")[()] = self.state.impulse
        self.view("thrust.angular_impulse")[:] = self.state.angular_impulse
        self.view("thrust.pulses")[:] = self.state.pulses
