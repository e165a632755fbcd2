"""Ports of the errors of sensors beside white noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..parameters import SensorErrors
from ..runtime.sensor_parameters import SensorMatrices
from ..sensor_errors import SOURCES, ErrorParameters
from .declared import known_error_port, parameter_port
from .table import Port


def ports(model: SensorMatrices) -> tuple[Port, ...]:
    """Return the parameters of sensors of these sizes."""
    g, k = model.gyros, model.accelerometers
    drawn = "standard deviation, drawn from the seed"
    return (
        known_error_port(SensorErrors, "gyro_bias", name="gyro.bias", size=g, start=0.0, display_unit="deg/s",
                         description="bias of each gyro at the start, beside what is drawn"),
        parameter_port(SensorErrors, "gyro_bias", name="gyro.bias_deviation", start=model.gyro_bias,
                       display_unit="deg/s", description=f"bias of a gyro at the start: {drawn}"),
        parameter_port(SensorErrors, "gyro_bias_walk", name="gyro.bias_walk", start=model.gyro_bias_walk,
                       description="random walk of the bias of a gyro"),
        known_error_port(SensorErrors, "gyro_scale_error", name="gyro.scale_error", size=g, start=0.0,
                         description="scale factor of each gyro less 1, beside what is drawn"),
        parameter_port(SensorErrors, "gyro_scale_error", name="gyro.scale_error_deviation",
                       start=model.gyro_scale_error, description=f"scale factor of a gyro less 1: {drawn}"),
        parameter_port(SensorErrors, "gyro_misalignment", name="gyro.misalignment_deviation", display_unit="arcsec",
                       start=model.gyro_misalignment,
                       description=f"rotation of each gyro about each body axis: {drawn}"),
        *(known_error_port(SensorErrors, "gyro_misalignment", name=f"gyro.mounting_error_{axis}", size=g,
                           start=tuple(values.tolist()), display_unit="arcsec", frame="body",
                           description=f"rotation of each gyro about {axis}, beside what is drawn")
          for axis, values in zip("xyz", model.gyro_mounting_error, strict=True)),
        known_error_port(SensorErrors, "accelerometer_bias", name="accelerometer.bias", size=k, start=0.0,
                         description="bias of each accelerometer, beside what is drawn"),
        parameter_port(SensorErrors, "accelerometer_bias", name="accelerometer.bias_deviation",
                       start=model.accelerometer_bias, description=f"bias of an accelerometer: {drawn}"),
        parameter_port(SensorErrors, "star_tracker_misalignment", name="star_tracker.misalignment", size=3,
                       display_unit="arcsec", start=tuple(model.star_tracker_misalignment.tolist()), frame="body",
                       description="rotation of the star tracker in the body that nobody knows of"),
        parameter_port(SensorErrors, "low_frequency_error", name="star_tracker.low_frequency_error",
                       start=model.low_frequency_error, display_unit="arcsec",
                       description="standard deviation, each axis, of a first-order Gauss-Markov error"),
        parameter_port(SensorErrors, "low_frequency_time", name="star_tracker.low_frequency_time",
                       start=model.low_frequency_time, description="correlation time of that error"),
        parameter_port(SensorErrors, "boresight", name="star_tracker.boresight", size=3,
                       start=tuple(model.boresight.tolist()), frame="body", description="axis of the star tracker"),
        parameter_port(SensorErrors, "roll_factor", name="star_tracker.roll_factor", start=model.roll_factor,
                       description="noise about the boresight over that across it"),
        *(port for name in SOURCES for port in (
            Port(name=f"star_tracker.{name}.direction", causality="parameter", unit="1", size=3, start=0.0,
                 minimum=-1.0, maximum=1.0, frame="inertial", description=f"direction to the {name}"),
            Port(name=f"star_tracker.{name}.half_angle", causality="parameter", unit="rad", start=0.0, minimum=0.0,
                 maximum=math.pi, display_unit="deg",
                 description=f"angle between boresight and {name} within which there are no samples; 0: none"),
        )),
    )  # fmt: skip


def parameters(value: Callable[[str], Any]) -> ErrorParameters:
    """Return the errors of a run; `value` gives the value of a port."""
    return ErrorParameters(
        gyro_bias=np.array(value("gyro.bias")),
        gyro_bias_deviation=value("gyro.bias_deviation"),
        gyro_bias_walk=value("gyro.bias_walk"),
        gyro_scale_error=np.array(value("gyro.scale_error")),
        gyro_scale_error_deviation=value("gyro.scale_error_deviation"),
        gyro_misalignment_deviation=value("gyro.misalignment_deviation"),
        gyro_mounting=np.array([value(f"gyro.mounting_error_{axis}") for axis in "xyz"]),
        accelerometer_bias=np.array(value("accelerometer.bias")),
        accelerometer_bias_deviation=value("accelerometer.bias_deviation"),
        misalignment=np.array(value("star_tracker.misalignment")),
        low_frequency_error=value("star_tracker.low_frequency_error"),
        low_frequency_time=value("star_tracker.low_frequency_time"),
        boresight=np.array(value("star_tracker.boresight")),
        roll_factor=value("star_tracker.roll_factor"),
        sources=np.array([value(f"star_tracker.{name}.direction") for name in SOURCES]),
        half_angles=np.array([value(f"star_tracker.{name}.half_angle") for name in SOURCES], np.float64),
    )
