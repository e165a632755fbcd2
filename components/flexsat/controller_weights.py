"""What a controller is designed with: weights of the regulator, and what its filter assumes about noise.

Two designs: as published, and a robust one that holds on the full structure (PHYSICS section 9).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

ConfigurationName = str  # of a spacecraft: those of the built-in ones, or what its file says
ControllerDesign = Literal["published", "robust"]
DEFAULT_DESIGN: ControllerDesign = "robust"  # of configurations and FMUs; as published is always "published"


@dataclass(frozen=True, slots=True, kw_only=True)
class Weights:
    """LQR weights and Kalman filter noise (P section 6; C). `scale` divides the weights of each wheel.

    A filter that assumes more noise of a sensor trusts it less. The factors multiply the true standard deviations.
    """

    mrp: float = 1e7
    rate: float = 1e3
    modal_displacement: float = 1e8  # divided by omega_i^2
    modal_velocity: float = 10.0  # divided by omega_i^2
    deformation: float = 0.0  # equal for every modal displacement: their squares add up to that of the deformation
    null_wheel_speed: float = 0.1  # divided by scale
    torque: float = 0.1  # divided by scale
    scale: float = 1.0
    process_noise: float = 1e-12
    gyro_noise: float = 1.0  # factor on the true noise
    accelerometer_noise: float = 1.0  # factor on the true noise
    encoder_noise: float = 1.0  # factor on the true noise
    star_tracker_noise: float = 1.0  # factor for coarse star tracker and fine guidance sensor
    broadband: float = 1.0  # factor on the wheels' broadband jitter
    torque_noise: float = 1e-4  # N.m/Hz^0.5: white torque on the body, in the filter for external torque and biases
    torque_walk: float = 6e-7  # N.m/s^0.5: random walk of the external torque
    bias_walk: float = 1e-9  # rad/s^1.5: random walk of each gyro's bias
    jitter_cancellation: float = 0.0  # m2.kg/(N.m)^2: weight of torque against harmonic deformation; 0: no cancellation

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not value >= 0.0:
                raise ValueError(f"Weights.{item.name} must be >= 0, got {value!r}")
