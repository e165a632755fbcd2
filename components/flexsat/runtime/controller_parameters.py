"""Hold the controller's design that travels to run time, and the parameters of one run. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .keep_out import CONES, KeepOut, keep_out

LONGEST_DELAY = 0.02  # s, of measurement and of actuation, each
GUIDANCES = ("bang-coast-bang", "smoothed", "qp")
DURING_SLEW = ("refuse", "replan")
CAPTURE_ANGLE = (
    1e-3  # rad, 3.4 arcmin: above what sensors err and scenarios begin with, below what saturates the wheels
)
NO_CONES = keep_out(np.array([0.0, 0.0, 1.0]), np.zeros((len(CONES), 3)), np.zeros(len(CONES)))


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerMatrices:
    """The design that travels to run time. State: p, eta, w, eta', wheel speed less nominal, filter (2 k)."""

    a: Array  # (s, s), continuous [1/s in the states' units]
    b_torque: Array  # (s, n)
    b_jitter: Array  # (s, 4 n)
    c: Array  # (y, s): gyro, accelerometer, encoder, star tracker
    gain_coarse: Array  # (phases, s, y): Kalman gain with the star tracker
    gain_fine: Array  # (phases, s, y): with the fine guidance sensor
    feedback: Array  # (n, r): on the first r states, those without the filter
    jitter_torque: Array  # (n, 4 n): torque against known harmonic jitter; zero for none
    b_body: Array  # (s, 3): of a torque on the body
    gyro_axis: Array  # (g, 3)
    slow_sample_coarse: (
        Array  # (choices, 9 + g, g + 3): gains of the filter of torque and biases (design/slow_errors.py)
    )
    slow_sample_fine: Array  # with no choices where there is no such filter
    slow_between_coarse: Array  # (choices, 9 + g, g)
    slow_between_fine: Array
    deflection_of_torque: Array  # (m, n): of the modes, for constant torques of the wheels
    reference_a: Array  # (r, r), continuous, without gyroscopic terms
    reference_b: Array  # (r, n)
    nominal_speed: Array  # (n,) [rad/s]
    wheel_axis: Array  # (n, 3)
    wheel_inertia: Array  # (n,) [kg.m2]
    inertia: Array  # (3, 3) [kg.m2]
    modes: int
    period: float  # s, that the gains were designed for
    shaper_frequency: float  # rad/s
    shaper_damping: float
    gyros: int
    accelerometers: int
    torque_limit: float  # N.m, from here on: nominal values of the parameters of the same names
    speed_band: float  # rad/s
    imbalance_force: float  # N.s2/rad2
    imbalance_torque: float  # N.m.s2/rad2
    authority: float  # share of torque and speed band that the slew may use
    slew_start: float  # s, when a slew begins unless commanded otherwise
    torque_limit_factor: Array  # (n,) of each wheel over the numbers above, which are those of the largest
    speed_band_factor: Array
    imbalance_force_factor: Array
    imbalance_torque_factor: Array
    slew_gyroscopic: bool  # whether slews count the gyroscopic torque unless a run says otherwise


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerParameters:
    """Parameters of one run."""

    period: float  # s
    fine_sensor: bool
    feed_forward_jitter: bool
    smoothed: bool  # slew reference: smoothed instead of time-optimal
    open_loop: bool  # estimates, but commands no torque
    torque_limit: float  # N.m
    speed_band: float  # rad/s either side of nominal
    authority: float  # share of torque and speed band that the slew may use
    measurement_delay: float  # s, from sampling to the call that uses it; known, whole milliseconds
    actuation_delay: float  # s, from the call to when the torque acts
    imbalance_force: Array | float  # (n,) [N.s2/rad2]
    imbalance_torque: Array | float  # (n,) [N.m.s2/rad2]
    guidance: str = "bang-coast-bang"  # one of GUIDANCES
    during_slew: str = "refuse"  # one of DURING_SLEW
    capture_angle: float = CAPTURE_ANGLE  # rad
    linear_attitude: bool = False  # attitudes as sums of a quarter of the angle, as the published release has them
    torque_factor: Array | float = 1.0  # (n,) of the torque limit, of each wheel; 0: it has failed
    band_factor: Array | float = 1.0  # (n,) of the speed band
    speed_offset: Array | float = 0.0  # (n,) [rad/s], speed at rest less the nominal one
    gyroscopic: bool = False  # count the gyroscopic torque of wheels and body in the feed-forward of slews
    least_peak: bool = False  # divide the torque of slews by the least peak of the wheels' shares, not least squares
    keep_out: KeepOut = NO_CONES
    estimates_torque: bool = False  # an external torque on the body, and compensates it
    estimates_bias: bool = False  # the bias of each gyro
    null_rate: float = 0.0  # 1/s, of wheels' motion without torque on the body towards the least share of their bands

    def __post_init__(self) -> None:
        # named as the ports are: the messages reach those who set them
        for name, value in (("wheel.torque_limit", self.torque_limit), ("wheel.speed_band", self.speed_band)):
            if not value > 0.0:
                raise ValueError(f"{name} must be > 0, got {value!r}")
        if not 0.0 < self.authority <= 1.0:
            raise ValueError(f"slew.authority must be in (0, 1], got {self.authority!r}")
        for name, text, known in (("slew.guidance", self.guidance, GUIDANCES),
                                  ("command.during_slew", self.during_slew, DURING_SLEW)):  # fmt: skip
            if text not in known:
                raise ValueError(f"{name} must be one of {', '.join(known)}, got {text!r}")
        for name, factor, failed in (("wheel.torque_limit_factor", self.torque_factor, True),
                                     ("wheel.speed_band_factor", self.band_factor, False)):  # fmt: skip
            for k, value in enumerate(np.atleast_1d(factor).tolist()):
                if not (value > 0.0 or (failed and value == 0.0)):
                    raise ValueError(f"{name}[{k + 1}] must be {'>=' if failed else '>'} 0, got {value!r}")
        if self.linear_attitude and (self.estimates_torque or self.estimates_bias):
            raise ValueError("filter.disturbance, filter.gyro_bias: as_published has no such filter; set both to false")
        if self.linear_attitude and self.keep_out.active:
            raise ValueError(
                "keep_out: as_published has attitudes as sums of a quarter of the angle, which hold near zero only;"
                " set the half-angles to 0, or design = 'published' in place of as_published"
            )
        if self.gyroscopic and (self.smoothed or self.guidance == "smoothed"):
            raise ValueError(
                "slew.gyroscopic: the smoothed reference has no wheel speeds that follow it; set slew.gyroscopic to"
                " false, or another guidance"
            )
        if not self.capture_angle > 0.0:
            raise ValueError(f"initial.capture_angle must be > 0, got {self.capture_angle!r}")
        for name, value in (("delay.measurement", self.measurement_delay), ("delay.actuation", self.actuation_delay)):
            if not 0.0 <= value <= LONGEST_DELAY or abs(value * 1e3 - round(value * 1e3)) > 1e-6:
                raise ValueError(f"{name} must be whole milliseconds from 0 to {LONGEST_DELAY:.3f} s, got {value!r}")
