"""Numbers of a spacecraft with six wheels, two along each axis, for tests of missions."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from flexsat.ports.table import Port
from flexsat.runtime.missions.mission_data import MissionData

_TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
MISSION_DATA = MissionData(  # the principal axes of inertia are none of the body's
    inertia=_TURN @ np.diag([2.2e5, 2.5e5, 4.3e5]) @ _TURN.T,
    area=623.5,
    wheel_axis=np.vstack([np.eye(3), -np.eye(3)]),
    wheel_inertia=np.full(6, 4.62),
    torque_limit=np.full(6, 4.4),
    nominal_speed=np.array([36.0, 36.0, 23.0, 36.0, 36.0, 23.0]),
    speed_band=2.6,
    period=5e-3,
)


def values_of(ports: Sequence[Port], given: Mapping[str, Any]) -> Callable[[str], Any]:
    """Return what gives the value of each input and parameter: its start value, or the one given (dots as `__`)."""
    known: dict[str, Any] = {port.name: port.start for port in ports if port.causality != "output"}
    changes = {name.replace("__", "."): value for name, value in given.items()}
    assert changes.keys() <= known.keys()
    return (known | changes).__getitem__
