"""Ports and parameters of the thrusters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..runtime.missions.mission_data import MissionData
from ..runtime.missions.thrusters import ThrusterParameters
from .table import Port

# Twelve thrusters in six couples: +x, -x, +y, -y, +z, -z, each of two at an arm of 1 m. Row after row.
POSITIONS = (
    (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0),
    (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0),
    (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0),
)  # fmt: skip
DIRECTIONS = (
    (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0),
    (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0),
    (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 1.0, 0.0),
)  # fmt: skip
COUNT = len(POSITIONS)


def thruster_parameters() -> tuple[Port, ...]:
    """Return the parameters that the thrusters have, and that the manager knows of them."""
    return (
        Port(name="thruster.position", causality="parameter", unit="m", size=3 * COUNT, frame="body",
             start=tuple(x for row in POSITIONS for x in row), minimum=-1e3, maximum=1e3,
             description="place of each thruster from the body origin, one after another"),
        Port(name="thruster.direction", causality="parameter", unit="1", size=3 * COUNT, frame="body",
             start=tuple(x for row in DIRECTIONS for x in row), minimum=-1e6, maximum=1e6,
             description="direction of the force of each thruster on the spacecraft, of any length"),
        Port(name="thrust.maximum", causality="parameter", unit="N", start=0.1, minimum=0.0, maximum=1e6,
             display_unit="mN", description="thrust of an open thruster"),
        Port(name="thrust.minimum_impulse", causality="parameter", unit="N.s", start=1e-3, minimum=0.0, maximum=1e6,
             description="least impulse of a pulse: a command of less gives none"),
        Port(name="thrust.period", causality="parameter", unit="s", start=0.1, minimum=1e-3, maximum=1e3,
             description="time between pulses, a whole multiple of the step"),
        Port(name="thrust.lag", causality="parameter", unit="s", start=0.02, minimum=0.0, maximum=1e3,
             description="time constant of the thrust behind the valve; 0: none"),
    )  # fmt: skip


def ports(model: MissionData) -> tuple[Port, ...]:
    """Return the ports of the thrusters."""
    del model  # nothing of a spacecraft
    commanded = ("thrust.command",)
    return (
        Port(name="thrust.command", causality="input", unit="N", size=COUNT, minimum=0.0, maximum=1e6,
             display_unit="mN", variability="discrete",
             description="thrust of each thruster, wanted on average over a period; sampled where a period begins"),
        Port(name="disturbance.force", causality="input", unit="N", size=3, frame="body", variability="discrete",
             description="force of the environment, which is added"),
        Port(name="disturbance.torque", causality="input", unit="N.m", size=3, frame="body", variability="discrete",
             display_unit="mN.m", description="torque of the environment, which is added"),
        Port(name="external.force", causality="output", unit="N", size=3, frame="body", variability="discrete",
             depends_on=(*commanded, "disturbance.force"),
             description="force of thrusters and environment, the mean over the step"),
        Port(name="external.torque", causality="output", unit="N.m", size=3, frame="body", variability="discrete",
             depends_on=(*commanded, "disturbance.torque"), display_unit="mN.m",
             description="torque of thrusters and environment about the body origin, the mean over the step"),
        Port(name="thrust", causality="output", unit="N", size=COUNT, variability="discrete", depends_on=commanded,
             display_unit="mN", description="thrust of each thruster, the mean over the step"),
        Port(name="thrust.impulse", causality="output", unit="N.s", variability="discrete", depends_on=commanded,
             description="impulse of all thrusters since the start, as a sum without directions: the propellant"),
        Port(name="thrust.angular_impulse", causality="output", unit="N.m.s", size=3, frame="body",
             variability="discrete", depends_on=commanded,
             description="angular impulse of the thrusters since the start, the sum of torque times step in body axes"),
        Port(name="thrust.pulses", causality="output", kind="integer", size=COUNT, depends_on=commanded,
             description="pulses of each thruster since the start"),
        *thruster_parameters(),
        Port(name="thrust.noise", causality="parameter", unit="1", start=0.02, minimum=0.0, maximum=1.0,
             description="standard deviation of the thrust of a pulse, over the thrust"),
        Port(name="seed", causality="parameter", kind="integer", start=0, minimum=0,
             description="seed of the noise"),
    )  # fmt: skip


def parameters(value: Callable[[str], Any], step: float) -> ThrusterParameters:
    """Return the parameters of a run at a step [s]; `value` gives the value of a port.

    Raises
    ------
    ValueError
        For thrusters that are none, or a period that is no multiple of the step.
    """
    return ThrusterParameters(
        position=np.reshape(np.array(value("thruster.position"), np.float64), (-1, 3)),
        direction=np.reshape(np.array(value("thruster.direction"), np.float64), (-1, 3)),
        most_thrust=value("thrust.maximum"),
        minimum_impulse=value("thrust.minimum_impulse"),
        period=value("thrust.period"),
        lag=value("thrust.lag"),
        noise=value("thrust.noise"),
        seed=value("seed"),
        step=step,
    )
