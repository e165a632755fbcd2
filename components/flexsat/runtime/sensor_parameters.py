"""Hold what the sensors carry of a design, and the parameters of one run. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

from ..arrays import Array
from ..sensor_errors import PreparedErrors
from .wheel_jitter import Harmonics


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorMatrices:
    """What the sensors carry of a design: sizes, and nominal values of the parameters of the same names."""

    nominal_speed: Array  # (n,) [rad/s]
    wrench_of_jitter: Array  # (6 s, 4 n): from the jitter of the wheels to the wrenches on their mounts
    gyros: int
    accelerometers: int
    gyro_axis: Array  # (g, 3)
    rate_of_gyros: Array  # (3, g): the body's rate of rates about the gyros' axes
    gyro_bias: float  # rad/s, this and the others to roll_factor: nominal errors, as in parameters.SensorErrors
    gyro_bias_walk: float
    gyro_scale_error: float
    gyro_misalignment: float
    accelerometer_bias: float
    star_tracker_misalignment: Array  # (3,)
    low_frequency_error: float
    low_frequency_time: float
    boresight: Array  # (3,)
    roll_factor: float
    gyro_noise: float  # rad/s, of the noisiest
    gyro_noise_factor: Array  # (g,) of each gyro, over that
    gyro_mounting_error: Array  # (3, g) [rad]: rotation of each gyro about each body axis
    accelerometer_noise: float  # m/s2
    encoder_noise: float  # rad/s
    star_tracker_coarse: float  # rad
    star_tracker_fine: float  # rad
    filter_frequency: float  # Hz
    imbalance_force: float  # N.s2/rad2, and the next three: of the wheel that has most
    imbalance_torque: float  # N.m.s2/rad2
    broadband_force: float  # N
    broadband_torque: float  # N.m
    imbalance_force_factor: Array  # (n,) of each wheel, over that; and the next three
    imbalance_torque_factor: Array
    broadband_force_factor: Array
    broadband_torque_factor: Array
    harmonic_order: Array  # (p, n): harmonics beside the first
    harmonic_force: Array  # (p, n) [N.s2/rad2]
    harmonic_torque: Array  # (p, n) [N.m.s2/rad2]
    harmonic_phase: Array  # (p, n) [rad]
    step_size: float  # s
    fast_period: float  # s, of gyros, accelerometers and encoders
    star_tracker_period: float  # s


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
    imbalance_force: Array | float  # (n,) [N.s2/rad2]
    imbalance_torque: Array | float  # (n,) [N.m.s2/rad2]
    broadband_force: Array | float  # (n,) [N], held over fast_steps
    broadband_torque: Array | float  # (n,) [N.m]
    wheels: int
    gyros: int
    accelerometers: int
    wrench_of_jitter: Array  # (6 s, 4 wheels)
    nominal_speed: Array  # (wheels,) [rad/s]: what the encoders show before their first sample
    harmonics: Harmonics | None = None  # beside the first; None: none
    gyro_noise_factor: Array | float = 1.0  # (g,) of each gyro
    errors: PreparedErrors | None = None  # beside white noise; None: none

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
        if self.star_tracker_steps % self.fast_steps:
            # named as the ports are: the message reaches those who set them
            fast, slow = (steps * self.step for steps in (self.fast_steps, self.star_tracker_steps))
            raise ValueError(
                f"star_tracker.period = {slow:g} s must be a whole multiple of fast_period = {fast:g} s: a sample is"
                " flagged until the next one of the gyros, and one in between would be missed by a controller that"
                " reads as often as these are taken"
            )
