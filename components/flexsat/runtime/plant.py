"""Run-time plant: rigid body, modes and wheels, stepped exactly in their linear part.

Equations of motion: P, with the terms as PHYSICS section 2 gives them. Over a step the linear structure is carried by
its matrix exponential; the gyroscopic and momentum terms are evaluated once, at a predicted mid-step, and held. Error
order: 2 in the step. These terms are explicit: at 5 ms the step is stable up to body rates of 0.2 rad/s, at 1 ms up to
0.5 rad/s, a thousand times the mission's. numpy alone.

One sign differs from P's: the modal momentum term, so that a uniform velocity of the whole spacecraft changes nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from . import rotations
from .plant_parameters import PlantMatrices, PlantParameters
from .rotations import Triple
from .zero_order_hold import zero_order_hold

if TYPE_CHECKING:
    from .bearing_friction import Bearings


@dataclass(slots=True)
class PlantState:
    """Everything the plant remembers between steps. `step` returns the same object, updated in place."""

    mrp: Triple
    structure: Array  # eta, v, w, eta'
    momentum: Array  # (n,) axial, inertial [N.m.s]
    angle: Array  # (n,) [rad]
    speed: Array  # (n,) relative [rad/s]
    drive: Array  # what was held over the last step: the inputs, gyroscopic torques (2 n), momentum terms (6)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantOutputs:
    """True at the end of the step. Views of one buffer, `flat`, that the next step overwrites, in its order."""

    flat: Array
    mrp: Array
    quaternion: Array
    rate: Array
    velocity: Array
    modal_displacement: Array
    modal_velocity: Array
    wheel_speed: Array
    gyro_site_rate: Array
    accelerometer_site_acceleration: Array
    wheel_angle: Array
    rms_deformation: Array  # (1,)


@dataclass(frozen=True, slots=True, kw_only=True)
class Telemetry:
    """Quantities for the engineer, computed on demand."""

    angular_momentum: Array  # (3,) inertial, about the body origin [N.m.s]
    energy: float  # J


class Plant:
    """The model prepared for one step length: matrices only, no state that changes from step to step."""

    def __init__(self, matrices: PlantMatrices, parameters: PlantParameters, step: float) -> None:
        """Prepare the transition matrices for steps of `step` [s]; raise ValueError if it is not positive."""
        self.matrices, self.parameters, self.step_length = matrices, parameters, step
        m, n = matrices.modes, matrices.wheels
        self.modes, self.wheels = m, n
        mass = matrices.mass_matrix.copy()
        mass[3:6, 3:6] += np.diag(np.diag(mass[3:6, 3:6]) * parameters.inertia_dispersion)
        if not np.linalg.eigvalsh(mass)[0] > 0.0:
            given = parameters.inertia_dispersion.tolist()
            raise ValueError(
                f"dispersion.inertia = {given} takes away more than the modes leave to the rigid body: the mass matrix"
                " is not positive definite; choose larger values"
            )
        self.mass = mass
        self.stiffness = (matrices.frequency * (1.0 + parameters.frequency_dispersion)) ** 2
        damping = matrices.damping * (1.0 + parameters.damping_dispersion)
        inverse_mass = np.linalg.inv(mass)
        rigid = mass[:6]  # linear momentum, angular momentum
        translation = mass[:3, 6:]

        # generalised force of everything that is held over a step: see PlantState.drive
        external = np.zeros((6 + m, 6))
        external[:6] = np.eye(6)
        momentum_terms = np.zeros((6 + m, 6))
        momentum_terms[:3, :3] = -np.eye(3)
        # P has the other sign here; then uniform motion of the whole would shake the modes and feed them energy
        momentum_terms[6:, :3] = -translation.T / mass[0, 0]
        momentum_terms[3:6, 3:] = -np.eye(3)
        lateral = matrices.lateral_influence
        force = np.hstack([matrices.torque_influence, matrices.wrench_influence, external, -lateral, momentum_terms])
        self.drives = force.shape[1]

        # structure state: eta, then (v, w, eta'), then the integral of w over the step
        size = 2 * m + 6
        a = np.zeros((size + 3, size + 3))
        a[:m, m + 6 : size] = np.eye(m)
        a[m:size, :m] = -inverse_mass[:, 6:] * self.stiffness
        a[m:size, m + 6 : size] = -inverse_mass[:, 6:] * damping
        a[size:, m + 3 : m + 6] = np.eye(3)
        b = np.zeros((size + 3, self.drives))
        b[m:size] = inverse_mass @ force
        full, full_drive = zero_order_hold(a, b, step)
        half, half_drive = zero_order_hold(a, b, 0.5 * step)
        self.whole_step = np.ascontiguousarray(np.hstack([full[:, :size], full_drive]))

        # mid-step: what the momentum terms are made of, straight from the state at the start of the step
        crossed = np.vstack(
            [
                (lateral[:, n:] * matrices.wheel_sense).T,  # w_b times h: torque about a
                -(lateral[:, :n] * matrices.wheel_sense).T,  # -w_a times h: torque about b
            ]
        )
        if not parameters.gyroscopics:
            crossed = np.zeros_like(crossed)
        rate_rows = np.zeros((3, 6 + m))
        rate_rows[:, 3:6] = np.eye(3)
        self.momentum_map = np.vstack([rigid, rate_rows, crossed])
        mid = np.hstack([half[m:size, :size], half_drive[m:size]])
        self.mid_step = np.ascontiguousarray(self.momentum_map @ mid)

        # outputs that are linear in (structure, wheel momentum, products of velocities)
        self.products = 9
        g, k = len(matrices.gyro_axis), len(matrices.accelerometer_axis)
        linear = np.zeros((2 * m + 6 + n + g + k, size + n + self.products))
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
        sensed = _accelerometer_map(matrices)
        acceleration = slice(gyro.stop, gyro.stop + k)
        linear[acceleration, :size] = sensed @ a[m:size, :size]
        linear[acceleration, size + n :] = _accelerometer_products(matrices)
        self.output_map = linear
        self.acceleration_drive = np.ascontiguousarray(sensed @ b[m:size])

        # change of the wheels' axes with the modes, for the telemetry: (n, 3, m)
        self.tilt = np.cross(matrices.wheel_slope, matrices.wheel_axis[:, :, None], axis=1)

        # buffers owned by the stepper
        self._work = np.empty(size + self.drives)
        self._seen = np.empty(size + n + self.products)
        self._end = np.empty(size + 3)
        self._mid = np.empty(len(self.momentum_map))
        flat = np.zeros(7 + len(linear) + n + 1)
        values = self._values = flat[7 : 7 + len(linear)]
        self.outputs = PlantOutputs(
            flat=flat,
            mrp=flat[:3],
            quaternion=flat[3:7],
            rate=values[:3],
            velocity=values[3:6],
            modal_displacement=values[6 : 6 + m],
            modal_velocity=values[6 + m : 6 + 2 * m],
            wheel_speed=values[speed],
            gyro_site_rate=values[gyro],
            accelerometer_site_acceleration=values[acceleration],
            wheel_angle=flat[7 + len(linear) : -1],
            rms_deformation=flat[-1:],
        )

    @property
    def input_count(self) -> int:
        """Length of the input vector: wheel torque, jitter wrenches (6 s), external force and torque."""
        return self.wheels + 6 * self.matrices.mounts + 6


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


def init(plant: Plant) -> PlantState:
    """Return the state at the start of a run."""
    matrices, parameters = plant.matrices, plant.parameters
    m = plant.modes
    structure = np.concatenate(
        [parameters.modal_displacement, parameters.velocity, parameters.rate, parameters.modal_velocity]
    )
    axial_slope = np.einsum("ni,nim->nm", matrices.wheel_axis, matrices.wheel_slope)
    inertial_speed = (
        parameters.wheel_speed + matrices.wheel_axis @ parameters.rate + axial_slope @ parameters.modal_velocity
    )
    state = PlantState(
        mrp=rotations.mrp_from_quaternion(rotations.quaternion_from_mrp(parameters.mrp.tolist())),
        structure=structure,
        momentum=matrices.wheel_inertia * inertial_speed,
        angle=parameters.wheel_angle.copy(),
        speed=parameters.wheel_speed.copy(),
        drive=np.zeros(plant.drives),
    )
    now = plant.momentum_map @ structure[m:]
    state.drive[plant.input_count : -6] = now[9:] * np.concatenate([state.momentum, state.momentum])
    state.drive[-6:] = _momentum_terms(now)
    return state


def _momentum_terms(values: Array) -> list[float]:
    """Return w x (linear momentum) and w x (angular momentum) from momenta and rate, (9,)."""
    px, py, pz, hx, hy, hz, x, y, z = values[:9].tolist()
    return [
        y * pz - z * py,
        z * px - x * pz,
        x * py - y * px,
        y * hz - z * hy,
        z * hx - x * hz,
        x * hy - y * hx,
    ]


def step(
    plant: Plant, state: PlantState, inputs: Array, bearings: Bearings | None = None
) -> tuple[PlantState, PlantOutputs]:
    """Advance by one step with the inputs held over it.

    Parameters
    ----------
    plant : the prepared model
    state : updated in place
    inputs : (n + 6 s + 6,): wheel torque [N.m], jitter force x, y, z [N] and torque x, y, z [N.m] on each mount,
        external force [N] and torque [N.m]; all but the first in body axes
    bearings : friction of the wheels; None: they turn freely

    Returns
    -------
    state, outputs
        True at the end of the step.
    """
    n, size, count = plant.wheels, 2 * plant.modes + 6, plant.input_count
    limit = plant.parameters.torque_limit
    work, drive, momentum = plant._work, state.drive, state.momentum
    drive[:count] = inputs
    torque = drive[:n]
    np.minimum(torque, limit, out=torque)
    np.maximum(torque, -limit, out=torque)
    work[:size] = state.structure
    work[size:] = drive  # with the gyroscopic and momentum terms of the last step, to predict the middle of this one
    if bearings is not None:
        bearings.add(work, momentum, torque)

    mid = np.matmul(plant.mid_step, work, out=plant._mid)
    impulse = plant.step_length * torque
    momentum_mid = momentum + 0.5 * impulse
    np.multiply(mid[9 : 9 + n], momentum_mid, out=drive[count : count + n])
    np.multiply(mid[9 + n :], momentum_mid, out=drive[count + n : count + 2 * n])
    drive[count + 2 * n :] = _momentum_terms(mid)
    work[size + count :] = drive[count:]

    end = np.matmul(plant.whole_step, work, out=plant._end)
    state.structure[:] = end[:size]
    momentum += impulse
    turned = end[size:].tolist()
    if not math.isfinite(sum(turned)):
        raise ValueError(
            f"the motion has diverged: steps of {plant.step_length:g} s are too long for this rate; take shorter ones"
        )
    state.mrp = rotations.rotate_mrp(state.mrp, turned)
    previous = state.speed
    outputs = observe(plant, state)
    # trapezoid: exact for the spin, second order for the mount's motion
    angle = state.angle
    angle += (0.5 * plant.step_length) * (previous + outputs.wheel_speed)
    outputs.wheel_angle[:] = angle
    previous[:] = outputs.wheel_speed
    return state, outputs


def observe(plant: Plant, state: PlantState) -> PlantOutputs:
    """Return the outputs in the present state; accelerations hold for the inputs of the last step.

    The RMS deformation is the norm of eta over the square root of the mass (P, section 5).
    """
    m, n = plant.modes, plant.wheels
    size = 2 * m + 6
    seen, outputs = plant._seen, plant.outputs
    seen[:size] = state.structure
    seen[size : size + n] = state.momentum
    vx, vy, vz, x, y, z = state.structure[m : m + 6].tolist()
    seen[size + n :] = (
        y * vz - z * vy,
        z * vx - x * vz,
        x * vy - y * vx,
        x * x,
        y * y,
        z * z,
        x * y,
        x * z,
        y * z,
    )
    np.matmul(plant.output_map, seen, out=plant._values)
    acceleration = outputs.accelerometer_site_acceleration
    acceleration += plant.acceleration_drive @ state.drive
    outputs.flat[:7] = (*state.mrp, *rotations.quaternion_from_mrp(state.mrp))
    outputs.wheel_angle[:] = state.angle
    eta = outputs.modal_displacement
    outputs.rms_deformation[0] = math.sqrt(eta.dot(eta) / plant.mass[0, 0])
    return outputs


def telemetry(plant: Plant, state: PlantState) -> Telemetry:
    """Return inertial angular momentum and energy in the present state.

    The momentum counts the tilt of the wheel axes with the structure, to second order in eta (PHYSICS section 2).
    """
    matrices, m = plant.matrices, plant.modes
    eta, velocity = state.structure[:m], state.structure[m:]
    axes = matrices.wheel_axis + plant.tilt @ eta
    body = plant.mass[3:6] @ velocity + state.momentum @ axes
    return Telemetry(
        angular_momentum=rotations.matrix_from_mrp(state.mrp).T @ body,
        energy=float(
            0.5 * velocity @ (plant.mass @ velocity)
            + 0.5 * eta @ (plant.stiffness * eta)
            + 0.5 * state.momentum @ state.momentum / matrices.wheel_inertia
        ),
    )
