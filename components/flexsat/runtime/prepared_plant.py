"""Prepare the plant for one run and one step length: transition matrices, output map, initial values. numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only
from ..fixed_order import inverse, product
from .free_modes import Blocks, ClampedModes, Coupled, FreeModes, vibration
from .loads import Loads, at_mounts, lateral_axes, prepare_loads
from .motors import Motors, prepare_motors
from .plant_parameters import PlantMatrices, PlantParameters

PRODUCTS = 9  # products of velocities in the accelerations: w x v, and w_i w_j as xx yy zz xy xz yz
MIDDLE = 9  # rows of `middle` before the slopes: linear and angular momentum, rate


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """The spacecraft of one run, for steps of any length."""

    matrices: PlantMatrices
    parameters: PlantParameters
    mass: Array  # (6 + m, 6 + m) with its dispersion
    stiffness: Array  # (m,) [1/s2]
    free: FreeModes | ClampedModes
    loads: Loads
    drive: Array  # (2 m, r): z' = A z + drive @ loads
    compliance: Array  # (6, 6): inverse of the rigid mass
    carried: Array  # (6, m): (v, w) = compliance @ momentum - carried @ eta'

    def __post_init__(self) -> None:
        make_read_only(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedPlant:
    """Arrays and numbers that no step changes; states of several runs may share them.

    The vector of a state is z, (2 m,), linear and angular momentum of body and structure, (6,), and loads, (r,).
    """

    motion: Motion
    step_length: float  # s
    half_step: Array  # (n,): half of that, for each wheel
    modes: int
    wheels: int
    gyros: int
    accelerometers: int
    input_count: int  # wheel torque, jitter wrenches (6 s), external force and torque
    load_count: int
    most_torque: Array  # (n,): limits of the motors [N.m]
    least_torque: Array
    motors: Motors
    wheel_inertia: Array  # (n,) [kg.m2]
    load_of_input: Array  # (r, inputs)
    load_of_internal: Array  # (r, 2 n + 6): from gyroscopic torques and momentum terms
    coupled: Array  # (2 m, 2 m): z of the step's end, from z; (0, 0) where its pairs do not couple: then
    diagonal: Array  # (2, m): from itself,
    of_second: Array  # (m,): the first of a pair, from the second,
    of_first: Array  # (m,): the second of a pair, from the first,
    driven: Array  # (2 m + 9, r): and from the loads; then the change of momentum, and the turn over the step
    middle: Array  # (9 + u + 3, vector): momenta, rate and slope rates at mid-step, and the turn without the loads
    gyroscopic: Array  # (2 n, 3 + u + 3): torque about a and b per axial momentum, from rate and slope rates
    now: Array  # (9 + u + 3, vector): `middle` of the present
    observed: Array  # (6 + u + k, vector): velocity and rate, slope rates, accelerations without products
    output_map: Array  # (6 + n + g + k, 6 + u + k + n + 9): from these, axial momenta and products of velocities

    def __post_init__(self) -> None:
        make_read_only(self)


def prepare_motion(matrices: PlantMatrices, parameters: PlantParameters, *, fixed_order: bool = False) -> Motion:
    """Prepare what does not depend on the step length; with `fixed_order` the same bits on every processor.

    Raises
    ------
    ValueError
        If the dispersed mass matrix is not positive definite.
    """
    mass = matrices.mass_matrix.copy()
    mass[3:6, 3:6] += np.diag(np.diag(mass[3:6, 3:6]) * parameters.inertia_dispersion)
    coupling = mass[:6, 6:] * (1.0 + parameters.participation_dispersion)
    mass[:6, 6:], mass[6:, :6] = coupling, coupling.T
    if not np.linalg.eigvalsh(mass)[0] > 0.0:
        given = f"dispersion.inertia = {parameters.inertia_dispersion.tolist()}"
        if np.any(parameters.participation_dispersion):
            given = f"dispersion.participation up to {float(np.max(parameters.participation_dispersion)):g}, {given},"
        raise ValueError(
            f"{given} takes away more than the modes leave to the rigid body: the mass matrix"
            " is not positive definite; choose larger values"
        )
    stiffness = (matrices.frequency * (1.0 + parameters.frequency_dispersion)) ** 2
    damping = matrices.damping * (1.0 + parameters.damping_dispersion)
    free, loads = vibration(mass, stiffness, damping, fixed_order=fixed_order), prepare_loads(matrices)
    compliance, coupling = inverse(mass[:6, :6]), mass[:6, 6:]
    carried = product(compliance, coupling)
    on_modes = loads.force[6:] - product(carried.T, loads.force[:6])
    acceleration = product(inverse(mass[6:, 6:] - product(coupling.T, carried)), on_modes)
    return Motion(
        matrices=matrices,
        parameters=parameters,
        mass=mass,
        stiffness=stiffness,
        free=free,
        loads=loads,
        drive=product(free.of_structure[:, matrices.modes :], acceleration),
        compliance=compliance,
        carried=carried,
    )


def prepare(matrices: PlantMatrices, parameters: PlantParameters, step: float) -> PreparedPlant:
    """Prepare the transition matrices for steps of `step` [s]; see `prepare_motion` and `at_step`."""
    return at_step(prepare_motion(matrices, parameters), step)


def at_step(motion: Motion, step: float) -> PreparedPlant:
    """Prepare a motion for steps of `step` [s]; raise ValueError if that is not positive."""
    if not step > 0.0:
        raise ValueError(f"the plant's period must be > 0 s, got {step!r}")
    matrices, free, loads = motion.matrices, motion.free, motion.loads
    n, r = matrices.wheels, loads.force.shape[1]
    (whole, whole_held), (half, half_held) = free.transition_and_half(step)
    speeds = np.vstack([-motion.carried[3:], loads.slopes])  # rate and slope rates, from eta'
    of_z = product(speeds, free.velocity)
    turned, turned_by_load = _turned(motion, step, whole, whole_held)
    middle = _velocities(motion, half.after(of_z), product(of_z, half_held.times(motion.drive)), 0.5 * step)
    inputs = n + 6 * matrices.mounts + 6
    most = motion.parameters.torque_limit * (np.ones(n) * motion.parameters.torque_factor)
    none = np.zeros((0, 0))
    return PreparedPlant(
        motion=motion,
        step_length=step,
        half_step=np.full(n, 0.5 * step),
        modes=matrices.modes,
        wheels=n,
        gyros=len(matrices.gyro_axis),
        accelerometers=len(matrices.accelerometer_axis),
        input_count=inputs,
        load_count=r,
        most_torque=most,
        least_torque=-most,
        motors=prepare_motors(motion.parameters, most, matrices.wheel_inertia, step),
        wheel_inertia=matrices.wheel_inertia,
        load_of_input=loads.of_held[:, :inputs].copy(),
        load_of_internal=loads.of_held[:, inputs:].copy(),
        coupled=none if isinstance(whole, Blocks) else whole.matrix,
        diagonal=whole.diagonal if isinstance(whole, Blocks) else none,
        of_second=np.ascontiguousarray(whole.pq) if isinstance(whole, Blocks) else none,
        of_first=np.ascontiguousarray(whole.qp) if isinstance(whole, Blocks) else none,
        driven=np.vstack([whole_held.times(motion.drive), step * loads.force[:6], turned_by_load]),
        middle=np.vstack([middle, turned]),
        gyroscopic=np.pad(_gyroscopic(motion), ((0, 0), (0, 3))),
        now=np.pad(_velocities(motion, of_z, np.zeros((len(of_z), r)), 0.0), ((0, 3), (0, 0))),
        observed=_observed(motion),
        output_map=_output_map(motion),
    )


def _velocities(motion: Motion, of_z: Array, of_load: Array, time: float) -> Array:
    """Map z, momentum and loads to momentum, rate and slope rates after a time [s], given their parts due to z."""
    m, r = motion.matrices.modes, motion.loads.force.shape[1]
    rows = np.zeros((6 + len(of_z), 2 * m + 6 + r))
    momentum, load = slice(2 * m, 2 * m + 6), slice(2 * m + 6, None)
    rows[:6, momentum] = np.eye(6)
    rows[:6, load] = time * motion.loads.force[:6]
    rows[6:, : 2 * m], rows[6:, load] = of_z, of_load
    rows[6:9] += product(motion.compliance[3:], rows[:6])
    return rows


def _turned(motion: Motion, step: float, whole: Blocks | Coupled, held: Blocks | Coupled) -> tuple[Array, Array]:
    """Map z and momentum, (3, vector), and the loads, (3, r), to the integral of the rate over a step.

    `whole` and `held` are the transition of z over the step, and its integral.
    """
    resultant = motion.loads.force[:6]
    moved = -product(motion.carried[3:], motion.free.displacement)
    by_load = 0.5 * step**2 * product(motion.compliance[3:], resultant) + product(moved, held.times(motion.drive))
    return np.hstack([whole.after(moved) - moved, step * motion.compliance[3:], np.zeros_like(by_load)]), by_load


def _gyroscopic(motion: Motion) -> Array:
    """Map rate and slope rates to the factors of the gyroscopic torques, (2 n, 3 + u)."""
    matrices, loads = motion.matrices, motion.loads
    first, second = lateral_axes(matrices)
    if not motion.parameters.gyroscopics:
        return np.zeros((2 * matrices.wheels, 3 + len(loads.slopes)))
    lateral = [
        np.hstack([axes, product(_placed(matrices, axes), loads.mount_slopes)]) * matrices.wheel_sense[:, None]
        for axes in (second, -first)  # w_b times h: torque about a; -w_a times h: torque about b
    ]
    return np.vstack(lateral)


def _placed(matrices: PlantMatrices, axes: Array) -> Array:
    """Return (n, 3 s): what picks a wheel's component along its axis from the vectors of the mounts."""
    return at_mounts(matrices, axes).T


def _observed(motion: Motion) -> Array:
    """Map z, momentum and loads to velocity and rate, slope rates, and the linear part of the accelerations."""
    matrices, free, loads = motion.matrices, motion.free, motion.loads
    m, u = matrices.modes, len(loads.slopes)
    axis, position = matrices.accelerometer_axis, matrices.accelerometer_position
    of_change = np.hstack([axis, np.cross(position, axis), matrices.accelerometer_deflection])  # of v', w', eta''
    of_force = product(of_change, inverse(motion.mass))
    damping = matrices.damping * (1.0 + motion.parameters.damping_dispersion)
    restoring = motion.stiffness[:, None] * free.displacement + damping[:, None] * free.velocity
    rows = np.zeros((6 + u + len(axis), 2 * m + 6 + loads.force.shape[1]))
    rows[: 6 + u, : 2 * m] = product(np.vstack([-motion.carried, loads.slopes]), free.velocity)
    rows[:6, 2 * m : 2 * m + 6] = motion.compliance
    rows[6 + u :, : 2 * m] = -product(of_force[:, 6:], restoring)
    rows[6 + u :, 2 * m + 6 :] = product(of_force, loads.force)
    return rows


def _output_map(motion: Motion) -> Array:
    """Map what is observed to the outputs that are linear in it.

    Columns: velocity and rate, slope rates, accelerations without products, axial momenta, products of velocities.
    Rows: rate, velocity, wheel speed, gyro rates, accelerations.
    """
    matrices, loads = motion.matrices, motion.loads
    n, g, k = matrices.wheels, len(matrices.gyro_axis), len(matrices.accelerometer_axis)
    u = len(loads.slopes)
    momentum = slice(6 + u + k, 6 + u + k + n)
    linear = np.zeros((6 + n + g + k, momentum.stop + PRODUCTS))
    linear[:3, 3:6], linear[3:6, :3] = np.eye(3), np.eye(3)
    speed, gyro = slice(6, 6 + n), slice(6 + n, 6 + n + g)
    linear[speed, 3:6] = -matrices.wheel_axis
    linear[speed, 6 : 6 + u] = -product(_placed(matrices, matrices.wheel_axis), loads.mount_slopes)
    linear[speed, momentum] = np.eye(n) / matrices.wheel_inertia[:, np.newaxis]
    linear[gyro, 3:6], linear[gyro, 6 : 6 + u] = matrices.gyro_axis, loads.gyro_slopes
    linear[gyro.stop :, 6 + u : 6 + u + k] = np.eye(k)
    linear[gyro.stop :, momentum.stop :] = _accelerometer_products(matrices)
    return linear


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
