"""Every number of the study, in SI units, with its source; FMU ports read start values, units and ranges here.

Sources: P, the paper (Cachim et al., IEEE Aerospace 2025, arXiv 2410.07376); C, the authors' public MATLAB release.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from .controller_weights import DEFAULT_DESIGN as DEFAULT_DESIGN
from .controller_weights import ConfigurationName as ConfigurationName  # parameters are read here
from .controller_weights import ControllerDesign as ControllerDesign
from .controller_weights import Weights as Weights
from .quantities import NOT_NEGATIVE, PERIOD, POSITIVE, TURN, Range, check_ranges

RPM = 2.0 * math.pi / 60.0  # rad/s
DEGREE = math.pi / 180.0  # rad
ARCSECOND = DEGREE / 3600.0  # rad
HERTZ = 2.0 * math.pi  # rad/s

# Upper limits are far from anything that is built; beyond them results are not those of a spacecraft, or not numbers.
IMBALANCE = Range(minimum=0.0, maximum=1e-2)  # N.s2/rad2, N.m.s2/rad2: over 200 times that of the large wheels
COARSE_ERROR = Range(minimum=0.0, maximum=DEGREE)  # rad; a sun sensor, and more than the controller's model holds for
FINE_ERROR = Range(minimum=0.0, maximum=60.0 * ARCSECOND)  # rad; six times the coarse star tracker's

ModeChoice = Literal["frequency", "coupling"]
MeshKind = Literal["record", "tiles"]
MESH_KINDS: tuple[MeshKind, ...] = ("record", "tiles")
Support = Literal["vertices", "edge"]
SUPPORTS: tuple[Support, ...] = ("vertices", "edge")
MODE_CHOICES: tuple[ModeChoice, ...] = ("frequency", "coupling")
CONTROLLER_DESIGNS: tuple[ControllerDesign, ...] = ("published", "robust")


ALL_MODES = 198  # of the mesh of record below 80 Hz
PUBLISHED_MODES = 25  # P: of plant and controller alike
RUN_DURATION = 300.0  # s, P: of every run
MISSION_DURATION = 86400.0  # s, a day
ENVIRONMENT_PERIOD = 0.1  # s: a hundred thousandth of an orbit


@dataclass(frozen=True, slots=True, kw_only=True)
class Aperture:
    """The segmented aperture: hexagonal tiles in rings round a hexagonal hole of the same size."""

    tile_side: Annotated[float, "m", POSITIVE] = 2.0  # P, section 5
    rings: Annotated[int, "1", Range(minimum=1, maximum=20)] = 4  # P: 60 tiles
    mesh: MeshKind = "record"  # "record": the paper's aperture; "tiles": six triangles a tile, any aperture
    refinements: Annotated[int, "1", Range(minimum=0, maximum=4)] = 0  # "tiles" only: each splits triangles in four
    support: Support = "vertices"  # part of the hole's edge that is clamped to the bus: six corners, or all

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.mesh not in MESH_KINDS or self.support not in SUPPORTS:
            raise ValueError(
                f"Aperture.mesh must be one of {', '.join(MESH_KINDS)}, and support one of {', '.join(SUPPORTS)}; got"
                f" {self.mesh!r} and {self.support!r}"
            )
        if self.mesh == "record" and ((self.tile_side, self.rings) != (2.0, 4) or self.refinements):
            raise ValueError(
                'Aperture.mesh: "record" is made for tiles of 2.0 m in 4 rings without refinements, got'
                f' {self.tile_side} m in {self.rings} with {self.refinements}; write mesh = "tiles"'
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Plate:
    """A homogeneous Kirchhoff plate."""

    flexural_rigidity: Annotated[float, "N.m", POSITIVE] = 8.4e4  # C, after its division of the stiffness by 64
    poisson_ratio: Annotated[float, "1", Range(above=-1.0, below=0.5)] = 0.25  # C
    area_density: Annotated[float, "kg/m2", POSITIVE] = 4200.0 / (360.0 * math.sqrt(3.0))  # P: 4200 kg over 60 hexagons
    damping_ratio: Annotated[float, "1", Range(minimum=0.0, below=1.0)] = (
        0.005  # P: Rayleigh damping, at both frequencies
    )
    damping_frequencies: Annotated[tuple[float, float], "Hz", POSITIVE] = (0.5, 10.0)  # C

    def __post_init__(self) -> None:
        check_ranges(self)

    def rayleigh(self) -> tuple[float, float]:
        """Return beta_M [1/s] and beta_K [s] of F = beta_M I + beta_K K: 2 zeta w_i = beta_M + beta_K w_i^2."""
        low, high = (2.0 * math.pi * f for f in self.damping_frequencies)
        beta_k = 2.0 * self.damping_ratio / (low + high)
        return beta_k * low * high, beta_k


@dataclass(frozen=True, slots=True, kw_only=True)
class Modes:
    """How many modes of the structure the plant has, and which of them the controller is designed with."""

    plant: Annotated[int, "1", POSITIVE] = ALL_MODES  # how many are simulated, from the lowest
    design: Annotated[int, "1", POSITIVE] = PUBLISHED_MODES  # how many the controller's design has
    design_by: ModeChoice = "frequency"  # the lowest, as in C, or those most coupled to rigid motion (P)

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.design > self.plant:
            raise ValueError(f"Modes.design must be at most plant ({self.plant}), got {self.design}")
        if self.design_by not in MODE_CHOICES:
            known = ", ".join(MODE_CHOICES)
            raise ValueError(f"Modes.design_by must be one of {known}, got {self.design_by!r}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic:
    """One harmonic of a wheel's imbalance: force and torque over speed squared, at a multiple of the wheel's angle."""

    order: Annotated[float, "1", Range(above=0.0, maximum=100.0)]
    force: Annotated[float, "N.s2/rad2", IMBALANCE] = 0.0
    torque: Annotated[float, "N.m.s2/rad2", IMBALANCE] = 0.0
    phase: Annotated[float, "rad", TURN] = 0.0  # at wheel angle 0

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """A kind of reaction wheel and its imbalance. The broadband part covers what the harmonics leave out."""

    inertia: Annotated[float, "kg.m2", POSITIVE] = 0.84  # P, table 1
    torque_limit: Annotated[float, "N.m", Range(above=0.0, maximum=1e6)] = 0.8  # P, table 1
    speed_band: Annotated[float, "rad/s", Range(above=0.0, maximum=1e6)] = (
        25.0 * RPM
    )  # either side of the nominal speed; P: 50 rpm wide in all
    imbalance_force: Annotated[float, "N.s2/rad2", IMBALANCE] = 0.7852e-7 / RPM**2  # C: 0.7852e-7 N/rpm2
    imbalance_torque: Annotated[float, "N.m.s2/rad2", IMBALANCE] = 0.3239e-7 / RPM**2  # C: 0.3239e-7 N.m/rpm2
    broadband_force: Annotated[float, "N", Range(minimum=0.0, maximum=10.0)] = (
        0.7852e-7 * 3600.0
    )  # C: 60^2 in rpm2, held 5 ms
    broadband_torque: Annotated[float, "N.m", Range(minimum=0.0, maximum=10.0)] = 0.3239e-7 * 3600.0  # C
    # What follows P's wheels have not; 0: none.
    speed_limit: Annotated[float, "rad/s", Range(minimum=0.0, maximum=1e6)] = (
        0.0  # in either direction; no torque beyond
    )
    full_torque_speed: Annotated[float, "rad/s", Range(minimum=0.0, maximum=1e6)] = (
        0.0  # above it the motor's limit falls linearly to zero at speed_limit; 0: it does not fall
    )
    torque_step: Annotated[float, "N.m", Range(minimum=0.0, maximum=1e6)] = 0.0  # resolution of the motor's command
    friction_torque: Annotated[float, "N.m", Range(minimum=0.0, maximum=1e6)] = 0.0  # dry friction of the bearing
    harmonics: tuple[Harmonic, ...] = ()  # of the imbalance, beside the first

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.full_torque_speed > self.speed_limit:
            raise ValueError(
                f"Wheel.full_torque_speed must be at most speed_limit ({self.speed_limit:g} rad/s; 0: none), got"
                f" {self.full_torque_speed!r}"
            )

    def scaled(self, factor: float) -> Wheel:
        """Return a wheel with `factor` times the inertia, torques and imbalance (P: 5.5 for the bus wheels)."""
        return Wheel(
            inertia=factor * self.inertia,
            torque_limit=factor * self.torque_limit,
            speed_band=self.speed_band,
            imbalance_force=factor * self.imbalance_force,
            imbalance_torque=factor * self.imbalance_torque,
            broadband_force=factor * self.broadband_force,
            broadband_torque=factor * self.broadband_torque,
            speed_limit=self.speed_limit,
            full_torque_speed=self.full_torque_speed,
            torque_step=factor * self.torque_step,
            friction_torque=factor * self.friction_torque,
            harmonics=tuple(replace(one, force=factor * one.force, torque=factor * one.torque)
                            for one in self.harmonics),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorNoise:
    """Standard deviation of one sample of each sensor (P prints them as densities; C uses them so)."""

    gyro: Annotated[float, "rad/s", Range(minimum=0.0, maximum=DEGREE)] = 1e-5 * DEGREE
    accelerometer: Annotated[float, "m/s2", Range(minimum=0.0, maximum=1.0)] = 2e-5
    encoder: Annotated[float, "rad/s", Range(minimum=0.0, maximum=1.0)] = 3e-4
    star_tracker_coarse: Annotated[float, "rad", COARSE_ERROR] = 10.0 * ARCSECOND  # for slews
    star_tracker_fine: Annotated[float, "rad", FINE_ERROR] = 0.1 * ARCSECOND  # fine guidance sensor
    filter_frequency: Annotated[float, "Hz", Range(minimum=1e-3, maximum=1e6)] = 80.0  # P: accelerometers, 2nd order

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorErrors:
    """Sensor errors in addition to white noise: standard deviations, drawn from the seed; P has none."""

    gyro_bias: Annotated[float, "rad/s", Range(minimum=0.0, maximum=DEGREE)] = 0.0  # at the start
    gyro_bias_walk: Annotated[float, "rad/s^1.5", Range(minimum=0.0, maximum=DEGREE)] = 0.0  # rate random walk
    gyro_scale_error: Annotated[float, "1", Range(minimum=0.0, maximum=0.1)] = 0.0  # scale factor less 1
    gyro_misalignment: Annotated[float, "rad", COARSE_ERROR] = 0.0  # rotation about each body axis
    accelerometer_bias: Annotated[float, "m/s2", Range(minimum=0.0, maximum=1.0)] = 0.0
    star_tracker_misalignment: Annotated[tuple[float, float, float], "rad", TURN] = (0.0, 0.0, 0.0)  # not drawn
    low_frequency_error: Annotated[float, "rad", COARSE_ERROR] = 0.0  # first-order Gauss-Markov, each axis
    low_frequency_time: Annotated[float, "s", Range(above=0.0, maximum=1e9)] = 1000.0  # correlation time
    boresight: Annotated[tuple[float, float, float], "1", Range(minimum=-1.0, maximum=1.0)] = (
        0.0,
        0.0,
        1.0,
    )  # body axes
    roll_factor: Annotated[float, "1", Range(minimum=0.0, maximum=100.0)] = (
        1.0  # ratio of the noise about the boresight to that across it
    )

    def __post_init__(self) -> None:
        check_ranges(self)
        if not any(self.boresight):
            raise ValueError(f"SensorErrors.boresight must have a direction, got {self.boresight!r}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rates:
    """Step sizes of the FMUs, and the sampling period of the star tracker."""

    plant: Annotated[float, "s", PERIOD] = 1e-3
    sensors: Annotated[float, "s", PERIOD] = 1e-3
    controller: Annotated[float, "s", PERIOD] = 5e-3  # P: 200 Hz; gyros, accelerometers and encoders too
    star_tracker: Annotated[float, "s", PERIOD] = 0.1  # P: 10 Hz

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Slew:
    """Guidance of the slew."""

    rotation: Annotated[tuple[float, float, float], "rad", TURN] = (0.5 * DEGREE, 0.0, 0.0)  # P
    start_time: Annotated[float, "s"] = 5.0  # C
    authority: Annotated[float, "1", Range(above=0.0, maximum=1.0)] = 0.8  # P: share of torque limit and speed band
    gyroscopic: bool = False  # whether the feed-forward includes the gyroscopic torque of the wheels' momentum

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSelection:
    """Choice of the nominal wheel speeds (C; P's text says 150 rpm, its figure 200)."""

    lowest: Annotated[float, "Hz", POSITIVE] = 200.0 / 60.0  # of the speeds that are compared
    highest: Annotated[float, "Hz", POSITIVE] = 100.0
    points: Annotated[int, "1", POSITIVE] = 1000  # from lowest to highest, at equal distances
    window: Annotated[float, "Hz", POSITIVE] = 50.0 / 60.0  # width over which the strongest response counts
    avoid_crossings: bool = False  # whether each wheel's band lies between crossings of the Campbell diagram
    clearance: Annotated[float, "Hz", NOT_NEGATIVE] = 5.0 / 60.0  # least distance of such a band from a crossing
    crossing_response: Annotated[float, "1", Range(minimum=0.0, below=1.0)] = (
        0.01  # crossings below this share of the wheel's strongest one do not count
    )

    def __post_init__(self) -> None:
        check_ranges(self)
        for name in ("clearance", "crossing_response"):
            value = getattr(self, name)
            if not self.avoid_crossings and value != type(self).__dataclass_fields__[name].default:
                raise ValueError(
                    f"SpeedSelection.{name} is {value:.4g}, without effect: set avoid_crossings = true, or leave it out"
                )
