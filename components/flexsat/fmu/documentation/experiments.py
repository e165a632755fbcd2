"""Experiments that travel with reference results: short runs with parameters and stimuli of their own.

Stimuli are smooth or stepped functions of time, rounded so that their text is short and exact. None of them is physics:
they only have to move everything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ...arrays import Array
from ...ports.plant import JITTER
from ...ports.table import PortTable, Scalar

Stimuli = Callable[[PortTable, Array], dict[str, Array]]

DIGITS = 4  # of a stimulus
SLEW, SLEW_START = "slew", 0.3  # s
BEFORE = 0.02  # s of a slew that known delays take, and more


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """One run.

    Attributes
    ----------
    name : of its files, too
    step, stop_time : [s]; a whole number of steps
    record_every : steps between rows of the reference results
    parameters : by port: one value, for all elements of an array, or one each
    stimuli : from the component's ports and the times of the steps (k,) to inputs by port, (k,) or (k, size) each;
        inputs that are not among them stay at their start values. None: no input is ever set
    """

    name: str
    description: str
    step: float
    stop_time: float
    record_every: int
    parameters: Mapping[str, Scalar | tuple[Scalar, ...]] = field(default_factory=dict)
    stimuli: Stimuli | None = None

    @property
    def steps(self) -> int:
        """Number of steps."""
        return round(self.stop_time / self.step)

    def time(self, step: int) -> float:
        """Return the time at the beginning of a step [s], without the rounding of a product."""
        return round(step * self.step, 9)


def _waves(time: Array, size: int, amplitude: float, slowest: float) -> Array:
    """Return one sine a column, (k, size), each with its own frequency from `slowest` [Hz] up and its own phase."""
    column = np.arange(size)
    waves = np.sin(2.0 * np.pi * slowest * (1.0 + 0.17 * column) * time[:, None] + 0.7 * column)
    return np.asarray(amplitude * np.round(waves, DIGITS))


def _turning(time: Array) -> Array:
    """Return unit quaternions of a slow turn about (1, 2, 2)/3, scalar last, (k, 4)."""
    half = 0.5 * 1e-3 * time[:, None]
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    return np.asarray(np.round(np.hstack([np.sin(half) * axis, np.cos(half)]), 12))


def _starts(table: PortTable, name: str) -> Array:
    return np.array(table[name].starts, dtype=np.float64)


def _drive_plant(table: PortTable, time: Array) -> dict[str, Array]:
    pulse = np.where((time >= 0.1) & (time < 0.3), 1.0, 0.0)[:, None]
    driven = {"wheel.torque": _waves(time, table["wheel.torque"].length, 0.25, 2.0)}
    for i, name in enumerate(JITTER):
        driven[name] = _waves(time + 0.01 * i, table[name].length, 1e-3, 5.0)
    driven["external.force"] = pulse * np.array([2.0, -1.0, 0.5])
    driven["external.torque"] = pulse * np.array([5.0, 10.0, -20.0])
    return driven


def _drive_sensors(table: PortTable, time: Array) -> dict[str, Array]:
    speed = np.linspace(25.0, 60.0, table["wheel.speed"].length).round(1)
    return {
        "attitude.quaternion": _turning(time),
        "wheel.speed": speed + _waves(time, len(speed), 0.1, 1.0),
        "gyro_site.rate": _waves(time, table["gyro_site.rate"].length, 1e-4, 3.0),
        "accelerometer_site.acceleration": _waves(time, table["accelerometer_site.acceleration"].length, 1e-3, 20.0),
        "wheel.angle": np.round(speed * time[:, None] + np.arange(len(speed)), 6),
    }


def _measure(table: PortTable, time: Array) -> dict[str, Array]:
    nominal = _starts(table, "encoder.speed")
    valid = (np.arange(len(time)) % 20 == 0).astype(np.float64)
    return {
        "gyro.rate": _waves(time, table["gyro.rate"].length, 1e-7, 1.0),
        "accelerometer.acceleration": _waves(time, table["accelerometer.acceleration"].length, 1e-5, 2.0),
        "encoder.speed": nominal + _waves(time, len(nominal), 1e-3, 1.0),
        "encoder.angle": np.round(nominal * time[:, None], 6),
        "star_tracker.mrp": _waves(time, 3, 1e-7, 0.5),
        "applied.wheel.torque": _waves(time, len(nominal), 1e-2, 1.0),
        "star_tracker.valid": valid,
        "applied.valid": (time > 0.5 * time[-1]).astype(np.float64),  # at first its own torque, then another's
    }


def _command_a_slew(table: PortTable, time: Array, start: float = SLEW_START) -> dict[str, Array]:
    still = np.ones((len(time), 1))
    return {
        "encoder.speed": still * _starts(table, "encoder.speed"),
        "command.rotation": still * np.array([0.008, 0.0, -0.001]),
        "command.start_time": still[:, 0] * start,
        "star_tracker.valid": (np.arange(len(time)) % 20 == 0).astype(np.float64),
    }


EXPERIMENTS: dict[str, tuple[Experiment, ...]] = {
    "plant": (
        Experiment(
            name="free-response",
            description="no input: turning, drifting, vibrating from the start, wheels at their nominal speeds",
            step=1e-3,
            stop_time=0.5,
            record_every=10,
            parameters={
                "initial.random_wheel_phases": False,
                "initial.mrp": (1e-3, -2e-3, 5e-4),
                "initial.rate": (1e-3, 2e-3, -1e-3),
                "initial.velocity": (1e-3, 0.0, -2e-3),
                "initial.modal.displacement": 1e-4,
                "initial.modal.velocity": -2e-4,
                "initial.wheel.angle": 0.5,
            },
        ),
        Experiment(
            name="driven",
            description="every input moves; dispersed modes, wheel phases and attitude from the seed, torque limited",
            step=1e-3,
            stop_time=0.5,
            record_every=10,
            parameters={
                "seed": 3,
                "initial.attitude_deviation": 1e-6,
                "wheel.torque_limit": 0.2,
                "dispersion.frequency": 0.02,
                "dispersion.damping": -0.1,
                "dispersion.inertia": (0.01, 0.005, 0.02),
            },
            stimuli=_drive_plant,
        ),
    ),
    "sensors": (
        Experiment(
            name="at-rest",
            description="no input, no jitter: noise of the instruments with the coarse star tracker",
            step=1e-3,
            stop_time=0.25,
            record_every=5,
            parameters={"seed": 1, "jitter.enabled": False},
        ),
        Experiment(
            name="turning",
            description="every input moves; fine guidance sensor, jitter, faster sampling",
            step=1e-3,
            stop_time=0.25,
            record_every=5,
            parameters={"seed": 2, "star_tracker.fine": True, "fast_period": 2e-3, "star_tracker.period": 0.05},
            stimuli=_drive_sensors,
        ),
    ),
    "controller": (
        Experiment(
            name="hold",
            description="measurements move a little; fine guidance sensor, nothing commanded",
            step=5e-3,
            stop_time=1.0,
            record_every=4,
            parameters={"star_tracker.fine": True},
            stimuli=_measure,
        ),
        Experiment(
            name=SLEW,
            description="a slew with known delays, while the measurements stay at rest: torque up to its limits",
            step=5e-3,
            stop_time=1.0,
            record_every=4,
            parameters={"delay.measurement": 5e-3, "delay.actuation": 3e-3},
            stimuli=_command_a_slew,
        ),
    ),
}


def experiments_of(component: str, step: float, spacing: float) -> tuple[Experiment, ...]:
    """Return the experiments of a component of one spacecraft, at its own steps [s].

    The torque of a slew begins `spacing` [s] before it, half of the input shaper's length: of a soft structure the slew
    is commanded later.
    """
    start = max(SLEW_START, math.ceil(10.0 * (spacing + BEFORE)) / 10.0)
    found = []
    for experiment in EXPERIMENTS[component]:
        own = replace(experiment, step=step)
        if experiment.name == SLEW and start > SLEW_START:
            stop = round(experiment.stop_time + start - SLEW_START, 1)
            own = replace(own, stimuli=partial(_command_a_slew, start=start), stop_time=stop)
        found.append(own)
    return tuple(found)
