"""Hold the matrices of a spacecraft that the plant needs, and the parameters of one run. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Index, make_read_only

# Relative to the masses that are coupled. Rounding couples the mesh of record by up to 1e-12; couplings are above 1e-5.
NO_COUPLING = 1e-11
STREAM = 1  # a component's own random streams: plant and sensors may be given the same seed


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantMatrices:
    """A spacecraft as arrays and numbers. Velocities are ordered (v, w, eta')."""

    mass_matrix: Array  # (6 + m, 6 + m)
    frequency: Array  # (m,) [rad/s]
    damping: Array  # (m,) [1/s]
    torque_influence: Array  # (6 + m, n)
    wrench_influence: Array  # (6 + m, 6 s): force x, y, z, then torque x, y, z, each over the s mounts of wheels
    lateral_influence: Array  # (6 + m, 2 n): torque about each wheel's lateral axis a, then about b
    mount_of_wheel: Index  # (n,)
    wheel_axis: Array  # (n, 3)
    wheel_sense: Array  # (n,): +1 if (a, b, axis) is right-handed, else -1
    wheel_slope: Array  # (n, 3, m)
    wheel_inertia: Array  # (n,) [kg.m2]
    torque_limit: float  # N.m, of the strongest motor
    torque_limit_factor: Array  # (n,) of each motor, over that
    speed_limit: Array  # (n,) [rad/s]; 0: none
    full_torque_speed: Array  # (n,) [rad/s]: above it the torque falls to zero at the speed limit; 0: it does not fall
    torque_step: Array  # (n,) [N.m], of the motor's command; 0: none
    friction_torque: Array  # (n,) [N.m]
    step_size: float  # s, recommended
    nominal_speed: Array  # (n,) [rad/s]
    gyro_axis: Array  # (g, 3)
    gyro_slope: Array  # (g, m)
    accelerometer_axis: Array  # (k, 3)
    accelerometer_position: Array  # (k, 3) [m]
    accelerometer_deflection: Array  # (k, m)
    # The t appendages that turn, at the angles of the file; a part is one of them, from 0, or -1: it does not turn.
    turn_axis: Array  # (t, 3) unit vectors
    turn_point: Array  # (t, 3) [m] of the interface, from the origin
    turn_angle: Array  # (t,) [rad]
    turn_moment: Array  # (t, 3) [kg.m] first moment of mass about the interface
    turn_inertia: Array  # (t, 3, 3) [kg.m2] about the interface
    mount_turn: Array  # (s, 3, 3): body axes from those of the mount's jitter, which are body axes at angle 0
    mount_position: Array  # (s, 3) [m]
    mode_part: Index  # (m,)
    mount_part: Index  # (s,)
    gyro_part: Index  # (g,)
    accelerometer_part: Index  # (k,)

    def __post_init__(self) -> None:
        make_read_only(self)

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.frequency)

    @property
    def wheels(self) -> int:
        """Number of wheels."""
        return len(self.wheel_axis)

    @property
    def mounts(self) -> int:
        """Number of mounts that carry wheels."""
        return int(self.wrench_influence.shape[1]) // 6


def without_rounding(mass: Array) -> Array:
    """Return a mass matrix whose couplings are exactly zero where rounding alone couples.

    On a symmetric structure most modes move no body, and the others move it along or about one axis. What the sums over
    the finite elements leave elsewhere would join vibrations that are independent, and cost a native plant seconds.
    """
    scale = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
    return np.where(np.abs(mass) > NO_COUPLING * scale, mass, 0.0)


def lowest_modes(matrices: PlantMatrices, count: int) -> PlantMatrices:
    """Return a plant of the lowest modes, the others rigid; 0 keeps all.

    Raises
    ------
    ValueError
        For more modes than there are.
    """
    if count in (0, matrices.modes):
        return matrices
    if not 0 < count < matrices.modes:
        raise ValueError(f"modes must be from 1 to {matrices.modes}, or 0 for all of them, got {count}")
    rows = slice(6 + count)
    return replace(
        matrices,
        mass_matrix=matrices.mass_matrix[rows, rows],
        frequency=matrices.frequency[:count],
        damping=matrices.damping[:count],
        torque_influence=matrices.torque_influence[rows],
        wrench_influence=matrices.wrench_influence[rows],
        lateral_influence=matrices.lateral_influence[rows],
        wheel_slope=matrices.wheel_slope[:, :, :count],
        gyro_slope=matrices.gyro_slope[:, :count],
        accelerometer_deflection=matrices.accelerometer_deflection[:, :count],
        mode_part=matrices.mode_part[:count],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantParameters:
    """Parameters of one run."""

    mrp: Array  # (3,) initial attitude, body from inertial
    rate: Array  # (3,) [rad/s]
    velocity: Array  # (3,) [m/s]
    modal_displacement: Array  # (m,) [m sqrt(kg)]
    modal_velocity: Array  # (m,) [m sqrt(kg)/s]
    wheel_speed: Array  # (n,) relative to the mount, about the axis [rad/s]
    wheel_angle: Array  # (n,) [rad]
    torque_limit: float  # N.m, times the factor of each motor
    frequency_dispersion: Array  # (m,) relative error of the frequencies
    damping_dispersion: Array  # (m,) relative error of the modal damping
    inertia_dispersion: Array  # (3,) relative error of the principal inertias
    gyroscopics: bool = True  # False leaves out the gyroscopic torques of the wheels
    participation_dispersion: Array | float = 0.0  # (m,) relative error of each mode's coupling to rigid motion
    torque_factor: Array | float = 1.0  # (n,) of the torque limit, of each motor; 0: it has failed
    speed_limit: Array | float = 0.0  # (n,) [rad/s]; 0: none
    full_torque_speed: Array | float = 0.0  # (n,) [rad/s]; 0: the torque does not fall with speed
    torque_step: Array | float = 0.0  # (n,) [N.m]; 0: none

    def __post_init__(self) -> None:
        if not np.linalg.norm(self.mrp) <= 1.0:
            raise ValueError(f"initial.mrp: norm must be <= 1 (short rotation), got {np.linalg.norm(self.mrp):.6g}")
        if not self.torque_limit > 0.0:
            raise ValueError(f"wheel.torque_limit must be > 0 N.m, got {self.torque_limit!r}")
        for port, given in (("wheel.torque_limit_factor", self.torque_factor), ("wheel.speed_limit", self.speed_limit),
                            ("wheel.full_torque_speed", self.full_torque_speed),
                            ("wheel.torque_step", self.torque_step)):  # fmt: skip
            for k, value in enumerate(np.atleast_1d(given).tolist()):
                if not value >= 0.0:
                    raise ValueError(f"{port}[{k + 1}] must be >= 0, got {value!r}")
        for k, (full, most) in enumerate(np.broadcast(self.full_torque_speed, self.speed_limit)):
            if full > most:
                raise ValueError(
                    f"wheel.full_torque_speed[{k + 1}] must be at most wheel.speed_limit[{k + 1}] = {most:g} rad/s, got"
                    f" {float(full)!r}"
                )
        for name, errors in (("frequency", self.frequency_dispersion), ("inertia", self.inertia_dispersion)):
            if not np.all(errors > -1.0):
                raise ValueError(f"dispersion.{name}: every relative error must be > -1, got {float(errors.min())!r}")
        for name, given in (("damping", self.damping_dispersion), ("participation", self.participation_dispersion)):
            if not np.all(np.asarray(given) >= -1.0):
                least = float(np.min(given))
                raise ValueError(f"dispersion.{name}: every relative error must be >= -1, got {least!r}")
        make_read_only(self)


def parameters_of_run(
    matrices: PlantMatrices,
    *,
    seed: int,
    random_wheel_phases: bool,
    attitude_deviation: float,
    mrp: Array,
    rate: Array,
    velocity: Array,
    modal_displacement: Array,
    modal_velocity: Array,
    wheel_speed_offset: Array,
    wheel_angle: Array,
    torque_limit: float,
    frequency_dispersion: Array,
    damping_dispersion: Array,
    inertia_dispersion: Array,
    gyroscopics: bool = True,
    participation_dispersion: Array | float = 0.0,
    torque_factor: Array | float = 1.0,
    speed_limit: Array | float = 0.0,
    full_torque_speed: Array | float = 0.0,
    torque_step: Array | float = 0.0,
) -> PlantParameters:
    """Return the parameters of a run, with what is random at its start drawn from the seed.

    Wheel phases are uniform over a turn; the attitude error is normal with `attitude_deviation` [rad] about each axis.
    The two come from separate streams, so that using one does not change the other.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    phases, attitude = (np.random.default_rng(stream) for stream in np.random.SeedSequence([seed, STREAM]).spawn(2))
    drawn = phases.uniform(0.0, 2.0 * np.pi, matrices.wheels)
    error = attitude_deviation * attitude.standard_normal(3)
    return PlantParameters(
        mrp=mrp + 0.25 * error,
        rate=rate,
        velocity=velocity,
        modal_displacement=modal_displacement,
        modal_velocity=modal_velocity,
        wheel_speed=matrices.nominal_speed + wheel_speed_offset,
        wheel_angle=wheel_angle + drawn if random_wheel_phases else wheel_angle,
        torque_limit=torque_limit,
        frequency_dispersion=frequency_dispersion,
        damping_dispersion=damping_dispersion,
        inertia_dispersion=inertia_dispersion,
        gyroscopics=gyroscopics,
        participation_dispersion=participation_dispersion,
        torque_factor=torque_factor,
        speed_limit=speed_limit,
        full_torque_speed=full_torque_speed,
        torque_step=torque_step,
    )
