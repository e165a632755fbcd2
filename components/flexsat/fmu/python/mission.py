"""FMI life cycle of the mission manager; ports in flexsat.ports.mission, the model in flexsat.runtime.missions."""

from __future__ import annotations

from collections.abc import Sequence

from ...parameters import MISSION_DURATION
from ...ports import mission as interface
from ...ports.table import Port
from ...runtime.missions import manager, mode_logic
from ...runtime.missions.mission_data import MissionData
from .life_cycle import ComponentSlave
from .load_matrices import MODEL_FILE, load_matrices


class Mission(ComponentSlave):
    """Modes, timeline, off-loading and failed wheels, between controller and wheels."""

    description = "Mission manager: modes, timeline, off-loading of the wheels, detection of failed wheels"
    equal_steps = True
    stop_time = MISSION_DURATION

    def ports(self) -> Sequence[Port]:
        """Return the ports; their sizes are those of the spacecraft in the resources."""
        data = load_matrices(self.resource(MODEL_FILE), MissionData)
        self.preferred_step = data.period
        return interface.ports(data)

    def start(self) -> None:
        """Prepare for any step that divides the thrusters' period, until the first says which."""
        self._manager = interface.parameters(self.value, float(self.value("thrust.period")))
        self.state = manager.init(self._manager)
        names = ("demanded.wheel.torque", "encoder.speed", "estimate.mrp", "reference.mrp", "reference.rate",
                 "reference.torque", "star_tracker.valid")  # fmt: skip
        self._inputs = manager.ManagerInputs(*(self.view(name) for name in names))
        self._show()

    def first_step(self, step: float) -> None:
        """Prepare for steps of this length."""
        self._manager = interface.parameters(self.value, step)

    def advance(self, time: float, _step: float, /) -> None:
        """Sample the inputs at `time`; the outputs hold from then on."""
        manager.step(self._manager, self.state, time, self._inputs)
        self._show()

    def _show(self) -> None:
        state = self.state
        for name, values in (
            ("wheel.torque", state.torque),
            ("applied.wheel.torque", state.applied),
            ("shown.encoder.speed", state.shown_speed),
            ("command.rotation", state.modes.rotation),
            ("thrust.command", state.off_loading.command),
            ("momentum", state.momentum),
            ("wheel.residual", state.detection.residual),
            ("wheel.status", state.detection.status),
        ):
            self.view(name)[:] = values
        for name, value in (("command.start_time", state.modes.start), ("pointing.error", state.error),
                            ("mode", state.modes.mode), ("timeline.done", state.modes.next), ("applied.valid", True),
                            ("star_tracker.outage", mode_logic.is_out(self._manager.modes, state.modes))):  # fmt: skip
            self.view(name)[()] = value
