"""Run-time sensors and wheel jitter: noise, anti-aliasing filter, sampling at their own rates. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from . import rotations
from . import wheel_jitter as jitter
from .zero_order_hold import matrix_exponential

STREAM = 2  # a component's own random streams: plant and sensors may be given the same seed


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorMatrices:
    """What the sensors carry of a design: sizes, and nominal values of the parameters of the same names."""

    nominal_speed: Array  # (n,) [rad/s]
    wrench_of_jitter: Array  # (6 s, 4 n): from the jitter of the wheels to the wrenches on their mounts
    gyros: int
    accelerometers: int
    gyro_noise: float  # rad/s
    accelerometer_noise: float  # m/s2
    encoder_noise: float  # rad/s
    star_tracker_coarse: float  # rad
    star_tracker_fine: float  # rad
    filter_frequency: float  # Hz
    imbalance_force: float  # N.s2
    imbalance_torque: float  # N.m.s2
    broadband_force: float  # N
    broadband_torque: float  # N.m


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorParameters:
    """Parameters of one run. Deviations are standard deviations of one sample."""

    seed: int
    gyro_noise: float  # rad/s
    accelerometer_noise: float  # m/s2
    accelerometer_noise_is_gyros: bool = False  # slip of the release: the gyros' number, read in m/s2
    encoder_noise: float  # rad/s
    star_tracker_noise: float  # rad, each axis
    filter_frequency: float  # Hz, of the accelerometers' Butterworth filter
    step: float  # s
    fast_steps: int  # steps between samples of gyros, accelerometers and encoders
    star_tracker_steps: int  # steps between samples of the star tracker
    jitter: bool
    imbalance_force: float  # N.s2
    imbalance_torque: float  # N.m.s2
    broadband_force: float  # N, held over fast_steps
    broadband_torque: float  # N.m
    wheels: int
    gyros: int
    accelerometers: int
    wrench_of_jitter: Array  # (6 s, 4 wheels)
    nominal_speed: Array  # (wheels,) [rad/s]: what the encoders show before their first sample

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ValueError(f"seed must be >= 0, got {self.seed}")
        for name in ("gyro_noise", "accelerometer_noise", "encoder_noise", "star_tracker_noise"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must be >= 0, got {getattr(self, name)!r}")
        if not self.filter_frequency > 0.0:
            raise ValueError(f"filter_frequency must be > 0 Hz, got {self.filter_frequency!r}")
        for name in ("fast_steps", "star_tracker_steps"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)}")


@dataclass(slots=True)
class SensorOutputs:
    """Hold from the sampling time on. Buffers that the stepper writes into; a shell may hand in its own."""

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
    """Everything the sensors remember between steps."""

    count: int  # steps done
    filter: Array  # (4, k) [m/s2]: output, its rate over the corner frequency, last input, new input
    jitter: Array  # (4, n): force a, force b [N], torque a, torque b [N.m] of each wheel
    broadband: Array  # (4, n), its noise part
    noise: np.random.Generator
    disturbance: np.random.Generator
    outputs: SensorOutputs


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensors:
    """The filter sampled for one step length, and the parameters."""

    parameters: SensorParameters
    transition: Array  # (2, 4): from the four rows of the filter to its next output and rate
    deviation: Array  # noise of gyros, accelerometers, encoders in one vector
    broadband_deviation: Array  # (4, 1)


def prepare(parameters: SensorParameters) -> Sensors:
    """Sample the anti-aliasing filter, with its input taken as linear between steps."""
    corner = 2.0 * np.pi * parameters.filter_frequency
    h = parameters.step
    # states, input, input slope: the exponential of the chain gives the first-order hold exactly
    chain = np.zeros((4, 4))
    chain[0, 1], chain[1, 0], chain[1, 1], chain[1, 2] = corner, -corner, -np.sqrt(2.0) * corner, corner
    chain[2, 3] = 1.0 / h
    sampled = matrix_exponential(chain * h)
    new = sampled[:2, 3:]
    accelerometer_noise = (
        parameters.gyro_noise if parameters.accelerometer_noise_is_gyros else parameters.accelerometer_noise
    )
    return Sensors(
        parameters=parameters,
        transition=np.hstack([sampled[:2, :2], sampled[:2, 2:3] - new, new]),
        deviation=np.concatenate(
            [
                np.full(parameters.gyros, parameters.gyro_noise),
                np.full(parameters.accelerometers, accelerometer_noise),
                np.full(parameters.wheels, parameters.encoder_noise),
            ]
        ),
        broadband_deviation=np.array([[parameters.broadband_force]] * 2 + [[parameters.broadband_torque]] * 2),
    )


def init(sensors: Sensors) -> SensorState:
    """Return the state before the first sample: instruments at rest, encoders at the nominal speeds."""
    p = sensors.parameters
    noise, disturbance = (np.random.default_rng(s) for s in np.random.SeedSequence([p.seed, STREAM]).spawn(2))
    return SensorState(
        count=0,
        filter=np.zeros((4, p.accelerometers)),
        jitter=np.zeros((4, p.wheels)),
        broadband=np.zeros((4, p.wheels)),
        noise=noise,
        disturbance=disturbance,
        outputs=SensorOutputs(
            star_tracker_quaternion=np.array([0.0, 0.0, 0.0, 1.0]),
            star_tracker_mrp=np.zeros(3),
            star_tracker_valid=np.array(False),
            gyro_rate=np.zeros(p.gyros),
            accelerometer=np.zeros(p.accelerometers),
            encoder_speed=p.nominal_speed.copy(),
            encoder_angle=np.zeros(p.wheels),
            wrench=np.zeros(len(p.wrench_of_jitter)),
        ),
    )


def step(
    sensors: Sensors,
    state: SensorState,
    quaternion: Array,
    rate: Array,
    acceleration: Array,
    speed: Array,
    angle: Array,
) -> tuple[SensorState, SensorOutputs]:
    """Sample what is due now.

    Parameters
    ----------
    sensors : the prepared model
    state : updated in place
    quaternion : (4,) true attitude, scalar last, body from inertial
    rate : (g,) true rates at the gyros [rad/s]
    acceleration : (k,) true accelerations at the accelerometers [m/s2]
    speed, angle : (n,) true wheel speeds [rad/s] and angles [rad]

    Returns
    -------
    state, outputs
        Hold from the time of this call on.
    """
    p, outputs = sensors.parameters, state.outputs
    state.filter[3] = acceleration
    if state.count:  # the filter starts at rest, with its first input as its last
        state.filter[:2] = sensors.transition @ state.filter
    state.filter[2] = acceleration
    if state.count % p.fast_steps == 0:
        draw = state.noise.standard_normal(len(sensors.deviation))
        draw *= sensors.deviation
        first, second = p.gyros, p.gyros + p.accelerometers
        np.add(rate, draw[:first], out=outputs.gyro_rate)
        np.add(state.filter[0], draw[first:second], out=outputs.accelerometer)
        np.add(speed, draw[second:], out=outputs.encoder_speed)
        outputs.encoder_angle[:] = angle
        outputs.star_tracker_valid[()] = False
        if p.jitter:
            np.multiply(
                state.disturbance.standard_normal((4, p.wheels)), sensors.broadband_deviation, out=state.broadband
            )
    if state.count % p.star_tracker_steps == 0:
        outputs.star_tracker_valid[()] = True
        error = (p.star_tracker_noise * state.noise.standard_normal(3)).tolist()
        seen = rotations.compose_quaternions(rotations.quaternion_from_rotation_vector(error), quaternion.tolist())
        outputs.star_tracker_quaternion[:] = seen
        outputs.star_tracker_mrp[:] = rotations.mrp_from_quaternion(seen)
    if p.jitter:
        jitter.harmonic(speed, angle, p.step, p.imbalance_force, p.imbalance_torque, state.jitter)
        state.jitter += state.broadband
        np.matmul(p.wrench_of_jitter, state.jitter.ravel(), out=outputs.wrench)
    state.count += 1
    return state, outputs
