"""Our sensors, but with one random generator left out of what a saved state restores."""

from __future__ import annotations

from ..fmu.python.sensors import Sensors


class ForgetfulSensors(Sensors):
    """Leave the generator of the noise where it is when a state is set."""

    def _set_fmu_state(self, state):
        mine = None if self.state is None else self.state.noise.bit_generator.state
        super()._set_fmu_state(state)
        if mine is not None:
            self.state.noise.bit_generator.state = mine
