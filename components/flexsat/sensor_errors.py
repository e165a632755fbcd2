"""Run-time errors of sensors beside white noise: biases that walk, scale, misalignment, blinding. numpy alone.

What is random has a stream of its own, so that the white noise of a seed is the same with these errors and without.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .arrays import Array, make_read_only

SOURCES = ("sun", "earth")  # that blind the star tracker


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorParameters:
    """Errors of one run. Deviations are those of what is drawn from the seed at the start."""

    gyro_bias: Array  # (g,) [rad/s]
    gyro_bias_deviation: float  # rad/s
    gyro_bias_walk: float  # rad/s^1.5
    gyro_scale_error: Array  # (g,)
    gyro_scale_error_deviation: float
    gyro_misalignment_deviation: float  # rad, of the rotation of each gyro about each body axis
    accelerometer_bias: Array  # (k,) [m/s2]
    accelerometer_bias_deviation: float  # m/s2
    misalignment: Array  # (3,) [rad], rotation of the star tracker in the body
    low_frequency_error: float  # rad, deviation of a first-order Gauss-Markov process about each axis
    low_frequency_time: float  # s, its correlation time
    boresight: Array  # (3,) of the star tracker, body
    roll_factor: float  # noise about the boresight over that across it
    sources: Array  # (2, 3) directions that blind the star tracker, inertial
    half_angles: Array  # (2,) [rad]; 0: it does not
    gyro_mounting: Array | float = 0.0  # (3, g) [rad], rotation of each gyro about each body axis

    def __post_init__(self) -> None:
        # named as the ports are: the messages reach those who set them
        for name, value in (("gyro.bias_deviation", self.gyro_bias_deviation),
                            ("gyro.bias_walk", self.gyro_bias_walk),
                            ("gyro.scale_error_deviation", self.gyro_scale_error_deviation),
                            ("gyro.misalignment_deviation", self.gyro_misalignment_deviation),
                            ("accelerometer.bias_deviation", self.accelerometer_bias_deviation),
                            ("star_tracker.low_frequency_error", self.low_frequency_error),
                            ("star_tracker.roll_factor", self.roll_factor)):  # fmt: skip
            if not value >= 0.0:
                raise ValueError(f"{name} must be >= 0, got {value!r}")
        if not self.low_frequency_time > 0.0:
            raise ValueError(f"star_tracker.low_frequency_time must be > 0 s, got {self.low_frequency_time!r}")
        if not float(self.boresight @ self.boresight) > 0.0:
            raise ValueError("star_tracker.boresight must have a direction, got zeros")
        for name, half_angle, direction in zip(SOURCES, self.half_angles.tolist(), self.sources, strict=True):
            if half_angle > 0.0 and not float(direction @ direction) > 0.0:
                raise ValueError(f"star_tracker.{name}.direction must have a direction, got zeros")
        make_read_only(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedErrors:
    """What a step uses of the errors, and their parameters."""

    parameters: ErrorParameters
    gyro_axis: Array  # (g, 3)
    rate_of_gyros: Array  # (3, g): the body's rate of true rates about the gyros' axes
    walk: float  # rad/s, deviation of the change of a bias from one sample of a gyro to the next
    memory: float  # of the low-frequency error, from one sample of the star tracker to the next
    renewal: float  # rad, deviation of what is new in it
    boresight: Array  # (3,) unit vector, body
    sources: Array  # (2, 3) unit vectors, inertial
    cosines: Array  # (2,) of the half-angles; 2, which no cosine reaches, for none
    of_gyros: bool  # some gyro errors there are
    walks: bool
    drifts: bool
    rolls: bool
    blinds: bool

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(slots=True, kw_only=True)
class ErrorState:
    """The errors that a run has drawn; the biases and the low-frequency error change."""

    random: np.random.Generator
    gyro_bias: Array  # (g,) [rad/s]
    gyro_scale: Array  # (g,)
    gyro_tilt: Array  # (g, 3): what a misaligned gyro's axis has beside its own
    accelerometer_bias: Array  # (k,) [m/s2]
    low_frequency: Array  # (3,) [rad]


def prepare_errors(
    parameters: ErrorParameters, gyro_axis: Array, rate_of_gyros: Array, fast: float, slow: float
) -> PreparedErrors:
    """Sample the random processes for the periods of the gyros and of the star tracker [s]."""
    memory = math.exp(-slow / parameters.low_frequency_time)
    return PreparedErrors(
        parameters=parameters,
        gyro_axis=gyro_axis,
        rate_of_gyros=rate_of_gyros,
        walk=parameters.gyro_bias_walk * math.sqrt(fast),
        memory=memory,
        renewal=parameters.low_frequency_error * math.sqrt(1.0 - memory**2),
        boresight=_unit(parameters.boresight),
        sources=np.array([_unit(source) for source in parameters.sources]),
        cosines=np.array([math.cos(angle) if angle > 0.0 else 2.0 for angle in parameters.half_angles.tolist()]),
        of_gyros=bool(
            parameters.gyro_bias.any() or parameters.gyro_scale_error.any() or parameters.gyro_bias_deviation
            or parameters.gyro_scale_error_deviation or parameters.gyro_misalignment_deviation
            or parameters.gyro_bias_walk or np.any(parameters.gyro_mounting)
        ),
        walks=parameters.gyro_bias_walk > 0.0,
        drifts=parameters.low_frequency_error > 0.0,
        rolls=parameters.roll_factor != 1.0,
        blinds=bool((parameters.half_angles > 0.0).any()),
    )  # fmt: skip


def init_errors(prepared: PreparedErrors, random: np.random.Generator) -> ErrorState:
    """Draw what a run begins with: biases, scale errors, tilts about x, y and z, low-frequency error, in this order."""
    given, gyros = prepared.parameters, len(prepared.gyro_axis)
    bias = given.gyro_bias + given.gyro_bias_deviation * random.standard_normal(gyros)
    scale = given.gyro_scale_error + given.gyro_scale_error_deviation * random.standard_normal(gyros)
    turned = given.gyro_mounting + given.gyro_misalignment_deviation * random.standard_normal((3, gyros))
    accelerometers = len(given.accelerometer_bias)
    return ErrorState(
        random=random,
        gyro_bias=bias,
        gyro_scale=scale,
        gyro_tilt=np.cross(turned.T, prepared.gyro_axis),
        accelerometer_bias=given.accelerometer_bias
        + given.accelerometer_bias_deviation * random.standard_normal(accelerometers),
        low_frequency=given.low_frequency_error * random.standard_normal(3),
    )


def add_fast_errors(
    prepared: PreparedErrors, state: ErrorState, first: bool, rate: Array, gyro_rate: Array, accelerometer: Array
) -> None:
    """Add the errors of a sample to what gyros and accelerometers measure, in place.

    Parameters
    ----------
    first : the first sample, before which no bias has walked
    rate : (g,) true rates [rad/s]
    """
    if prepared.walks and not first:
        state.gyro_bias += prepared.walk * state.random.standard_normal(len(state.gyro_bias))
    if prepared.of_gyros:
        body = prepared.rate_of_gyros @ rate
        gyro_rate += state.gyro_bias + state.gyro_scale * rate + state.gyro_tilt @ body
    accelerometer += state.accelerometer_bias


def star_tracker_error(prepared: PreparedErrors, state: ErrorState, first: bool, noise: list[float]) -> list[float]:
    """Return the rotation [rad] of a sample in the body: noise, low-frequency error, misalignment."""
    if prepared.drifts and not first:
        state.low_frequency *= prepared.memory
        state.low_frequency += prepared.renewal * state.random.standard_normal(3)
    error = np.array(noise)
    if prepared.rolls:
        error += (prepared.parameters.roll_factor - 1.0) * float(error @ prepared.boresight) * prepared.boresight
    found: list[float] = (error + state.low_frequency + prepared.parameters.misalignment).tolist()
    return found


def is_blinded(prepared: PreparedErrors, body_from_inertial: Array) -> bool:
    """Return whether a source stands within its half-angle of the boresight; `body_from_inertial` is (4,)."""
    if not prepared.blinds:
        return False
    vector, scalar = body_from_inertial[:3], float(body_from_inertial[3])
    # the boresight in inertial axes: turned back
    twice = 2.0 * np.cross(vector, prepared.boresight)
    seen = prepared.boresight + scalar * twice + np.cross(vector, twice)
    return bool(np.any(prepared.sources @ seen >= prepared.cosines))


def _unit(vector: Array) -> Array:
    length = math.sqrt(float(vector @ vector))
    return vector / length if length > 0.0 else np.array(vector)
