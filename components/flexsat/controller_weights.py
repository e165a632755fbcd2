"""What a controller is designed with: weights of the regulator, and what its filter assumes about noise.

Two designs: as published, and a robust one that holds on the full structure (PHYSICS section 9).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Literal

ConfigurationName = Literal["centralised", "distributed"]
ControllerDesign = Literal["published", "robust"]
DEFAULT_DESIGN: ControllerDesign = "robust"  # of configurations and FMUs; as published is always "published"

# Of the matrices in an FMU. Plant and sensors have none of their own for the published controller
Variant = Literal["corrected", "published", "as_published"]
VARIANTS: tuple[Variant, ...] = ("corrected", "published", "as_published")


def variant_of(*, as_published: bool, design: ControllerDesign) -> Variant:
    """Return the variant that parameters choose."""
    if as_published:
        return "as_published"
    return "published" if design == "published" else "corrected"


BUS_WHEELS = 5.5  # P: 33 small wheels weigh what six large ones do


@dataclass(frozen=True, slots=True, kw_only=True)
class Weights:
    """LQR weights and Kalman filter noise (P section 6; C). `scale` divides what belongs to a wheel.

    A filter that assumes more noise of a sensor trusts it less. The factors multiply the true standard deviations.
    """

    mrp: float = 1e7
    rate: float = 1e3
    modal_displacement: float = 1e8  # over omega_i^2
    modal_velocity: float = 10.0  # over omega_i^2
    deformation: float = 0.0  # on every modal displacement alike: their squares make up the deformation's
    null_wheel_speed: float = 0.1  # over scale
    torque: float = 0.1  # over scale
    scale: float = 1.0
    process_noise: float = 1e-12
    gyro_noise: float = 1.0  # factor
    accelerometer_noise: float = 1.0  # factor
    encoder_noise: float = 1.0  # factor
    star_tracker_noise: float = 1.0  # factor, of coarse star tracker and fine guidance sensor
    broadband: float = 1.0  # factor, of the wheels' broadband jitter
    jitter_cancellation: float = 0.0  # m2.kg/(N.m)^2: weight of torque against harmonic deformation; 0 cancels nothing

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not value >= 0.0:
                raise ValueError(f"Weights.{item.name} must be >= 0, got {value!r}")


PUBLISHED: Mapping[ConfigurationName, Weights] = {
    "centralised": Weights(scale=BUS_WHEELS),
    "distributed": Weights(),
}

# Chosen on the trade-off curves of `flexbench.studies.spillover` (tests/bench/robust_design.py). Why they hold:
# - Torque weighs a hundred times more: the loop is slow against the delay that must be tolerated.
# - Gyros count for less, so that the loop gain falls below one where the model ends; the modes that it lacks, up to
#   80 Hz, are then stable at any phase by their own damping. Encoders count for less, as a filter that infers the body
#   rate from wheel speeds becomes unstable at half the plant's gain.
# - Deformation is reduced by a feed-forward of the known imbalance, which moves no pole.
# - Centralised, all modal displacements weigh alike: a mode at 10.3 Hz that the model lacks limits the gain upwards
#   (more weight helps), one at 5.1 Hz, 5 % softer with half the damping, bounds the errors (less weight helps).
ROBUST: Mapping[ConfigurationName, Weights] = {
    "centralised": Weights(
        mrp=2e6,
        rate=1e3,
        modal_displacement=0.0,
        modal_velocity=10.0,
        deformation=2e6,
        null_wheel_speed=3e-3,
        torque=10.0,
        scale=BUS_WHEELS,
        process_noise=1e-13,
        gyro_noise=15.0,
        accelerometer_noise=1e3,
        encoder_noise=4.0,
        star_tracker_noise=1.33,
        broadband=0.32,
        jitter_cancellation=3e-8,
    ),
    "distributed": Weights(
        mrp=7e7,
        rate=1e3,
        modal_displacement=0.0,
        modal_velocity=1e4,
        null_wheel_speed=0.025,
        torque=10.0,
        process_noise=3e-13,
        gyro_noise=80.0,
        accelerometer_noise=1e3,
        encoder_noise=80.0,
        star_tracker_noise=14.0,
        jitter_cancellation=1e-7,
    ),
}
