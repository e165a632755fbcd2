"""Run-time sensors and wheel jitter: noise, anti-aliasing filter, sampling at their own rates. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, make_read_only
from ..sensor_errors import (
    ErrorState,
    PreparedErrors,
    add_fast_errors,
    init_errors,
    is_blinded,
    star_tracker_error,
)
from . import rotations
from . import wheel_jitter as jitter
from .sensor_parameters import SensorParameters
from .wheel_jitter import Harmonics
from .zero_order_hold import matrix_exponential

STREAM = 2  # a component's own random streams: plant and sensors may be given the same seed


@dataclass(frozen=True, slots=True)
class SensorInputs:
    """True values at the time of a step. A shell gives views that the master writes into."""

    quaternion: Array  # (4,) attitude, scalar last, body from inertial
    rate: Array  # (g,) at the gyros [rad/s]
    acceleration: Array  # (k,) at the accelerometers [m/s2]
    speed: Array  # (n,) of the wheels [rad/s]
    angle: Array  # (n,) of the wheels [rad]


@dataclass(slots=True)
class SensorOutputs:
    """Hold from the sampling time on. Buffers that the stepper writes into; a shell may put its own in their place."""

    star_tracker_quaternion: Array  # (4,) scalar last, body from inertial
    star_tracker_mrp: Array  # (3,)
    star_tracker_valid: NDArray[np.bool_]  # (): the star tracker's sample is as new as the gyros'; until their next
    gyro_rate: Array  # (g,) [rad/s]
    accelerometer: Array  # (k,) [m/s2]
    encoder_speed: Array  # (n,) [rad/s]
    encoder_angle: Array  # (n,) [rad]
    wrench: Array  # (6 s,): force x, y, z [N], torque x, y, z [N.m], each over the mounts, body axes


@dataclass(slots=True)
class SensorState:
    """What the sensors remember between steps, their held outputs included; `step` works in place."""

    count: int  # steps done
    filter: Array  # (4, k) [m/s2]: output, its rate over the corner frequency, last input, new input
    jitter: Array  # (4, n): force a, force b [N], torque a, torque b [N.m] of each wheel
    broadband: Array  # (4, n), its noise part
    noise: np.random.Generator
    disturbance: np.random.Generator
    errors: ErrorState | None  # beside white noise
    outputs: SensorOutputs


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedSensors:
    """The filter sampled for one step length, and the numbers of one run; no step changes them."""

    seed: int
    wheels: int
    gyros: int
    accelerometers: int
    step: float  # s
    fast_steps: int
    star_tracker_steps: int
    star_tracker_noise: float  # rad, each axis
    jitter: bool
    imbalance_force: Array  # (n,) [N.s2/rad2]
    imbalance_torque: Array  # (n,) [N.m.s2/rad2]
    harmonics: Harmonics | None
    errors: PreparedErrors | None  # beside white noise
    transition: Array  # (2, 4): from the four rows of the filter to its next output and rate
    deviation: Array  # (g + k + n,): noise of gyros, accelerometers, encoders
    broadband_deviation: Array  # (4, n)
    wrench_of_jitter: Array  # (6 s, 4 n)
    nominal_speed: Array  # (n,) [rad/s]

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare(parameters: SensorParameters) -> PreparedSensors:
    """Sample the anti-aliasing filter, with its input taken as linear between steps."""
    corner = 2.0 * np.pi * parameters.filter_frequency
    h = parameters.step
    # states, input, input slope: the exponential of the chain gives the first-order hold exactly
    chain = np.zeros((4, 4))
    chain[0, 1], chain[1, 0], chain[1, 1], chain[1, 2] = corner, -corner, -np.sqrt(2.0) * corner, corner
    chain[2, 3] = 1.0 / h
    sampled = matrix_exponential(chain * h)
    new, ones = sampled[:2, 3:], np.ones(parameters.wheels)
    accelerometer_noise = (
        parameters.gyro_noise if parameters.accelerometer_noise_is_gyros else parameters.accelerometer_noise
    )
    return PreparedSensors(
        seed=parameters.seed,
        wheels=parameters.wheels,
        gyros=parameters.gyros,
        accelerometers=parameters.accelerometers,
        step=h,
        fast_steps=parameters.fast_steps,
        star_tracker_steps=parameters.star_tracker_steps,
        star_tracker_noise=parameters.star_tracker_noise,
        jitter=parameters.jitter,
        imbalance_force=ones * parameters.imbalance_force,
        imbalance_torque=ones * parameters.imbalance_torque,
        harmonics=parameters.harmonics,
        errors=parameters.errors,
        transition=np.hstack([sampled[:2, :2], sampled[:2, 2:3] - new, new]),
        deviation=np.concatenate(
            [
                np.full(parameters.gyros, parameters.gyro_noise) * parameters.gyro_noise_factor,
                np.full(parameters.accelerometers, accelerometer_noise),
                np.full(parameters.wheels, parameters.encoder_noise),
            ]
        ),
        broadband_deviation=np.array(
            [ones * parameters.broadband_force] * 2 + [ones * parameters.broadband_torque] * 2
        ),
        wrench_of_jitter=parameters.wrench_of_jitter,
        nominal_speed=parameters.nominal_speed,
    )


def init(prepared: PreparedSensors) -> SensorState:
    """Return the state before the first sample: instruments at rest, encoders at the nominal speeds."""
    noise, disturbance, slow = _streams(prepared.seed)
    return SensorState(
        count=0,
        filter=np.zeros((4, prepared.accelerometers)),
        jitter=np.zeros((4, prepared.wheels)),
        broadband=np.zeros((4, prepared.wheels)),
        noise=noise,
        disturbance=disturbance,
        errors=None if prepared.errors is None else init_errors(prepared.errors, slow),
        outputs=SensorOutputs(
            star_tracker_quaternion=np.array([0.0, 0.0, 0.0, 1.0]),
            star_tracker_mrp=np.zeros(3),
            star_tracker_valid=np.array(False),
            gyro_rate=np.zeros(prepared.gyros),
            accelerometer=np.zeros(prepared.accelerometers),
            encoder_speed=prepared.nominal_speed.copy(),
            encoder_angle=np.zeros(prepared.wheels),
            wrench=np.zeros(len(prepared.wrench_of_jitter)),
        ),
    )


def _streams(seed: int) -> tuple[np.random.Generator, np.random.Generator, np.random.Generator]:
    """Return the noise of instruments, of wheels, and of what else is random in the instruments."""
    noise, disturbance, slow = np.random.SeedSequence([seed, STREAM]).spawn(3)
    return np.random.default_rng(noise), np.random.default_rng(disturbance), np.random.default_rng(slow)


def begin_noise(state: SensorState, seed: int) -> None:
    """Begin all noise anew; what was drawn before, such as biases, stays.

    Raises
    ------
    ValueError
        If the seed is below 0.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    state.noise, state.disturbance, slow = _streams(seed)
    if state.errors is not None:
        state.errors.random = slow


def step(prepared: PreparedSensors, state: SensorState, inputs: SensorInputs) -> SensorOutputs:
    """Sample what is due now; the outputs, which the state owns, hold from now on.

    Parameters
    ----------
    prepared : for the run of the state
    state : updated in place
    inputs : true values at the time of this call
    """
    outputs = state.outputs
    state.filter[3] = inputs.acceleration
    if state.count:  # the filter starts at rest, with its first input as its last
        state.filter[:2] = prepared.transition @ state.filter
    state.filter[2] = inputs.acceleration
    if state.count % prepared.fast_steps == 0:
        draw = state.noise.standard_normal(len(prepared.deviation))
        draw *= prepared.deviation
        first, second = prepared.gyros, prepared.gyros + prepared.accelerometers
        np.add(inputs.rate, draw[:first], out=outputs.gyro_rate)
        np.add(state.filter[0], draw[first:second], out=outputs.accelerometer)
        np.add(inputs.speed, draw[second:], out=outputs.encoder_speed)
        outputs.encoder_angle[:] = inputs.angle
        if prepared.errors is not None and state.errors is not None:
            add_fast_errors(
                prepared.errors, state.errors, not state.count, inputs.rate, outputs.gyro_rate, outputs.accelerometer
            )
        outputs.star_tracker_valid[()] = False
        if prepared.jitter:
            np.multiply(
                state.disturbance.standard_normal((4, prepared.wheels)),
                prepared.broadband_deviation,
                out=state.broadband,
            )
    if state.count % prepared.star_tracker_steps == 0:
        error, blinded = (prepared.star_tracker_noise * state.noise.standard_normal(3)).tolist(), False
        if prepared.errors is not None and state.errors is not None:
            error = star_tracker_error(prepared.errors, state.errors, not state.count, error)
            blinded = is_blinded(prepared.errors, inputs.quaternion)
        if not blinded:
            outputs.star_tracker_valid[()] = True
            turned = rotations.quaternion_from_rotation_vector(error)
            seen = rotations.compose_quaternions(turned, inputs.quaternion.tolist())
            outputs.star_tracker_quaternion[:] = seen
            outputs.star_tracker_mrp[:] = rotations.mrp_from_quaternion(seen)
    if prepared.jitter:
        jitter.harmonic(
            inputs.speed,
            inputs.angle,
            prepared.step,
            prepared.imbalance_force,
            prepared.imbalance_torque,
            state.jitter,
        )
        if prepared.harmonics is not None:
            jitter.add_harmonics(prepared.harmonics, inputs.speed, inputs.angle, prepared.step, state.jitter)
        state.jitter += state.broadband
        prepared.wrench_of_jitter.dot(state.jitter.ravel(), out=outputs.wrench)
    state.count += 1
    return outputs
