"""Prepare the plant for one run and one step length: transition matrices, output map, initial values. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from ..fixed_order import inverse, product
from .plant_parameters import PlantMatrices, PlantParameters
from .zero_order_hold import zero_order_hold

PRODUCTS = 9  # products of velocities in the accelerations: w x v, and w_i w_j as xx yy zz xy xz yz


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedPlant:
    """Arrays and numbers that no step changes; states of several runs may share them.

    Structure state: eta, v, w, eta'. Held over a step: the inputs (wheel torque, jitter wrenches, external force and
    torque), gyroscopic torques (2 n) and momentum terms (6).
    """

    step_length: float  # s
    modes: int
    wheels: int
    gyros: int
    accelerometers: int
    input_count: int  # wheel torque, jitter wrenches (6 s), external force and torque
    held_count: int
    torque_limit: float  # N.m, of each motor
    wheel_inertia: float  # kg.m2
    wheel_axis: Array  # (n, 3)
    mass: Array  # (6 + m, 6 + m)
    stiffness: Array  # (m,) [1/s2]
    whole_step: Array  # (2 m + 9, 2 m + 6 + held): structure and the integral of w at the end of the step
    mid_step: Array  # (9 + 2 n, 2 m + 6 + held): momenta, rate and gyroscopic factors at mid-step
    momentum_map: Array  # (9 + 2 n, 6 + m): the same, from velocities
    output_map: Array  # (outputs, 2 m + 6 + n + 9): from structure, wheel momentum and products of velocities
    acceleration_of_held: Array  # (k, held)
    tilt: Array  # (n, 3, m): change of the wheels' axes with the modes
    initial_mrp: Array  # (3,)
    initial_structure: Array  # (2 m + 6,)
    initial_momentum: Array  # (n,) axial, inertial [N.m.s]
    initial_speed: Array  # (n,) relative [rad/s]
    initial_angle: Array  # (n,) [rad]

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare(matrices: PlantMatrices, parameters: PlantParameters, step: float) -> PreparedPlant:
    """Prepare the transition matrices for steps of `step` [s].

    Raises
    ------
    ValueError
        If the step is not positive, or the dispersed mass matrix is not positive definite.
    """
    m, n = matrices.modes, matrices.wheels
    mass = matrices.mass_matrix.copy()
    mass[3:6, 3:6] += np.diag(np.diag(mass[3:6, 3:6]) * parameters.inertia_dispersion)
    if not np.linalg.eigvalsh(mass)[0] > 0.0:
        given = parameters.inertia_dispersion.tolist()
        raise ValueError(
            f"dispersion.inertia = {given} takes away more than the modes leave to the rigid body: the mass matrix"
            " is not positive definite; choose larger values"
        )
    stiffness = (matrices.frequency * (1.0 + parameters.frequency_dispersion)) ** 2
    damping = matrices.damping * (1.0 + parameters.damping_dispersion)
    inverse_mass = inverse(mass)
    force = _force_of_held(matrices, mass)
    held = force.shape[1]

    # structure state: eta, then (v, w, eta'), then the integral of w over the step
    size = 2 * m + 6
    a = np.zeros((size + 3, size + 3))
    a[:m, m + 6 : size] = np.eye(m)
    a[m:size, :m] = -inverse_mass[:, 6:] * stiffness
    a[m:size, m + 6 : size] = -inverse_mass[:, 6:] * damping
    a[size:, m + 3 : m + 6] = np.eye(3)
    b = np.zeros((size + 3, held))
    b[m:size] = product(inverse_mass, force)
    full, full_held = zero_order_hold(a, b, step)
    half, half_held = zero_order_hold(a, b, 0.5 * step)

    # mid-step: what the momentum terms are made of, straight from the state at the start of the step
    momentum_map = _momentum_map(matrices, mass, parameters.gyroscopics)
    mid = np.hstack([half[m:size, :size], half_held[m:size]])
    sensed = _accelerometer_map(matrices)

    axial_slope = np.einsum("ni,nim->nm", matrices.wheel_axis, matrices.wheel_slope)
    inertial_speed = (
        parameters.wheel_speed
        + product(matrices.wheel_axis, parameters.rate)
        + product(axial_slope, parameters.modal_velocity)
    )
    return PreparedPlant(
        step_length=step,
        modes=m,
        wheels=n,
        gyros=len(matrices.gyro_axis),
        accelerometers=len(matrices.accelerometer_axis),
        input_count=n + 6 * matrices.mounts + 6,
        held_count=held,
        torque_limit=parameters.torque_limit,
        wheel_inertia=matrices.wheel_inertia,
        wheel_axis=matrices.wheel_axis,
        mass=mass,
        stiffness=stiffness,
        whole_step=np.ascontiguousarray(np.hstack([full[:, :size], full_held])),
        mid_step=product(momentum_map, mid),
        momentum_map=momentum_map,
        output_map=_output_map(matrices, product(sensed, a[m:size, :size])),
        acceleration_of_held=product(sensed, b[m:size]),
        tilt=np.cross(matrices.wheel_slope, matrices.wheel_axis[:, :, None], axis=1),
        initial_mrp=parameters.mrp.copy(),
        initial_structure=np.concatenate(
            [parameters.modal_displacement, parameters.velocity, parameters.rate, parameters.modal_velocity]
        ),
        initial_momentum=matrices.wheel_inertia * inertial_speed,
        initial_speed=parameters.wheel_speed.copy(),
        initial_angle=parameters.wheel_angle.copy(),
    )


def _force_of_held(matrices: PlantMatrices, mass: Array) -> Array:
    """Return the generalised force of everything that is held over a step, (6 + m, held)."""
    m = matrices.modes
    external = np.zeros((6 + m, 6))
    external[:6] = np.eye(6)
    momentum_terms = np.zeros((6 + m, 6))
    momentum_terms[:3, :3] = -np.eye(3)
    # P has the other sign here; then uniform motion of the whole would shake the modes and feed them energy
    momentum_terms[6:, :3] = -mass[:3, 6:].T / mass[0, 0]
    momentum_terms[3:6, 3:] = -np.eye(3)
    return np.hstack(
        [
            matrices.torque_influence,
            matrices.wrench_influence,
            external,
            -matrices.lateral_influence,
            momentum_terms,
        ]
    )


def _momentum_map(matrices: PlantMatrices, mass: Array, gyroscopics: bool) -> Array:
    """Map velocities to linear and angular momentum, rate, and the factors of the gyroscopic torques, (9 + 2 n)."""
    m, n = matrices.modes, matrices.wheels
    lateral = matrices.lateral_influence
    crossed = np.vstack(
        [
            (lateral[:, n:] * matrices.wheel_sense).T,  # w_b times h: torque about a
            -(lateral[:, :n] * matrices.wheel_sense).T,  # -w_a times h: torque about b
        ]
    )
    if not gyroscopics:
        crossed = np.zeros_like(crossed)
    rate_rows = np.zeros((3, 6 + m))
    rate_rows[:, 3:6] = np.eye(3)
    return np.vstack([mass[:6], rate_rows, crossed])


def _output_map(matrices: PlantMatrices, acceleration: Array) -> Array:
    """Map structure state, wheel momentum and products of velocities to the outputs that are linear in them.

    Rows: rate, velocity, modal displacement, modal velocity, wheel speed, gyro rates, accelerations; those of the
    accelerations from the structure state are given.
    """
    m, n = matrices.modes, matrices.wheels
    size = 2 * m + 6
    g, k = len(matrices.gyro_axis), len(matrices.accelerometer_axis)
    linear = np.zeros((2 * m + 6 + n + g + k, size + n + PRODUCTS))
    linear[:3, m + 3 : m + 6] = np.eye(3)
    linear[3:6, m : m + 3] = np.eye(3)
    linear[6 : 6 + m, :m] = np.eye(m)
    linear[6 + m : 6 + 2 * m, m + 6 : size] = np.eye(m)
    speed = slice(6 + 2 * m, 6 + 2 * m + n)
    linear[speed, m + 3 : m + 6] = -matrices.wheel_axis
    linear[speed, m + 6 : size] = -np.einsum("ni,nim->nm", matrices.wheel_axis, matrices.wheel_slope)
    linear[speed, size : size + n] = np.eye(n) / matrices.wheel_inertia
    gyro = slice(speed.stop, speed.stop + g)
    linear[gyro, m + 3 : m + 6], linear[gyro, m + 6 : size] = matrices.gyro_axis, matrices.gyro_slope
    linear[gyro.stop :, :size] = acceleration
    linear[gyro.stop :, size + n :] = _accelerometer_products(matrices)
    return linear


def _accelerometer_map(matrices: PlantMatrices) -> Array:
    """Map (v', w', eta'') to the sensed accelerations, (k, 6 + m)."""
    axis, position = matrices.accelerometer_axis, matrices.accelerometer_position
    return np.hstack([axis, np.cross(position, axis), matrices.accelerometer_deflection])


def _accelerometer_products(matrices: PlantMatrices) -> Array:
    """Map (w x v, and w_i w_j as xx yy zz xy xz yz) to the sensed accelerations, (k, 9).

    P, equation for y_amu: w x v and the centripetal term a . (w (w . r) - r w^2). Its Coriolis term 2 a . (w x d')
    vanishes: the sensors that move with the structure sense along z, and d' is along z.
    """
    axis, position = matrices.accelerometer_axis, matrices.accelerometer_position
    along = np.sum(axis * position, axis=1)
    square = axis * position - along[:, None]
    pairs = [(0, 1), (0, 2), (1, 2)]
    cross = [axis[:, i] * position[:, j] + axis[:, j] * position[:, i] for i, j in pairs]
    return np.hstack([axis, square, np.stack(cross, axis=1)])
