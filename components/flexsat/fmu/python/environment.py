"""FMI life cycle of the environment; ports in flexsat.ports.environment, models in flexsat.runtime.missions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...parameters import ENVIRONMENT_PERIOD, MISSION_DURATION
from ...ports import environment as interface
from ...ports.table import Port
from ...runtime.missions import environment
from ...runtime.missions.mission_data import MissionData
from .life_cycle import ComponentSlave
from .load_matrices import MODEL_FILE, load_matrices


class Environment(ComponentSlave):
    """Forces and torques of a circular orbit on the spacecraft."""

    description = "Environment on a circular orbit: solar pressure, gravity gradient, magnetic and constant torque"
    preferred_step = ENVIRONMENT_PERIOD
    stop_time = MISSION_DURATION

    def ports(self) -> Sequence[Port]:
        """Return the ports; area and inertia are those of the spacecraft in the resources."""
        return interface.ports(load_matrices(self.resource(MODEL_FILE), MissionData))

    def start(self) -> None:
        """Prepare the orbit, and act at the start."""
        self._environment = environment.prepare(interface.parameters(self.value))
        self.state = None
        self.advance(0.0, 0.0)

    def advance(self, time: float, _step: float, /) -> None:
        """Sample the attitude now; the outputs hold from now on."""
        found = environment.step(self._environment, time, np.array(self.view("attitude.quaternion")))
        for name, values in (("external.force", found.force), ("external.torque", found.torque),
                             ("solar.force", found.solar_force), ("solar.torque", found.solar_torque),
                             ("gravity_gradient.torque", found.gravity_torque),
                             ("magnetic.torque", found.magnetic_torque), ("orbit.position", found.position),
                             ("magnetic.field", found.field)):  # fmt: skip
            self.view(name)[:] = values
        self.view("solar.lit")[()] = found.sunlit
