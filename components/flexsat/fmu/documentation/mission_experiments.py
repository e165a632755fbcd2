"""Experiments of the FMUs of missions, which travel with their reference results."""

from __future__ import annotations

import numpy as np

from ...arrays import Array
from ...ports.table import PortTable
from .experiments import Experiment


def _turn(table: PortTable, time: Array) -> dict[str, Array]:
    del table
    half = 0.5 * 2e-3 * time[:, None]
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    return {"attitude.quaternion": np.round(np.hstack([np.sin(half) * axis, np.cos(half)]), 12)}


def _fire(table: PortTable, time: Array) -> dict[str, Array]:
    places = np.arange(table["thrust.command"].length)
    return {
        "thrust.command": np.round(0.05 * (1.0 + np.sin(7.0 * time[:, None] + places)), 4),
        "disturbance.torque": np.outer(np.round(np.sin(time), 4), [1e-3, 2e-3, -1e-3]),
    }


def _fail_and_slew(table: PortTable, time: Array) -> dict[str, Array]:
    nominal = np.array(table["encoder.speed"].starts)
    speed = np.round(nominal + 0.2 * np.sin(3.0 * time[:, None] + np.arange(len(nominal))) * 1e-3, 6)
    speed[:, 0] = np.where(time > 2.0, 0.0, speed[:, 0])  # seized
    moving = ((time > 0.5) & (time < 1.0)).astype(np.float64)
    return {
        "encoder.speed": speed + np.outer(np.full(len(time), 0.5), np.arange(len(nominal)) == 1),
        "demanded.wheel.torque": np.round(0.01 * np.sin(5.0 * time[:, None] + np.arange(len(nominal))), 4),
        "reference.rate": np.outer(moving, [1e-4, 0.0, 0.0]),
        "star_tracker.valid": (np.arange(len(time)) % 20 == 0).astype(np.float64),
    }


MISSION_EXPERIMENTS: dict[str, tuple[Experiment, ...]] = {
    "environment": (
        Experiment(
            name="orbit",
            description="a low orbit with its shadow, turning slowly",
            step=50.0,
            stop_time=6000.0,
            record_every=2,
            parameters={"orbit.radius": 7.0e6, "solar.sun_direction": (1.0, 0.2, 0.1)},
            stimuli=_turn,
        ),
    ),
    "thrusters": (
        Experiment(
            name="pulses",
            description="all thrusters fire, some commands below the minimum impulse, beside a moving disturbance",
            step=5e-3,
            stop_time=1.0,
            record_every=4,
            parameters={"seed": 4},
            stimuli=_fire,
        ),
    ),
    "mission": (
        Experiment(
            name="slew-failure-off-loading",
            description="a slew, a wheel that seizes, and an off-loading",
            step=5e-3,
            stop_time=4.0,
            record_every=10,
            parameters={
                "timeline.time": (0.2, 2.5, *[0.0] * 46),
                "timeline.action": (1, 2, *[0] * 46),
                "timeline.rotation": (0.01, *[0.0] * 143),
                "settle.dwell": 0.1,
                "off_loading.duration": 1.0,
            },
            stimuli=_fail_and_slew,
        ),
    ),
}
