"""Run-time plant: rigid body, modes and wheels, stepped exactly in their linear part.

Equations of motion: P, with the terms as PHYSICS section 2 gives them. Over a step the linear structure is carried by
the exponentials of its free modes, and the momentum of the whole by the resultant of all forces; the gyroscopic and momentum terms are evaluated once, at a predicted mid-step, and held. Error
order: 2 in the step. These terms are explicit: at 5 ms the step is stable up to body rates of 0.2 rad/s, at 1 ms up to
0.5 rad/s, a thousand times the mission's. numpy alone.

One sign differs from P's: the modal momentum term, so that a uniform velocity of the whole spacecraft changes nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..fixed_order import product
from . import bearing_friction, rotations
from .bearing_friction import PreparedFriction
from .named_state import NOT_SAVED
from .prepared_plant import MIDDLE, PRODUCTS, PreparedPlant, at_step, prepare, prepare_motion
from .rotations import Triple

__all__ = [
    "PlantOutputs",
    "PlantState",
    "PreparedPlant",
    "Telemetry",
    "at_step",
    "init",
    "modal_motion",
    "observe",
    "prepare",
    "prepare_motion",
    "step",
    "telemetry",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantOutputs:
    """True at the end of the step. Views of one buffer, `flat`, in its order; the next step overwrites it."""

    flat: Array
    linear: Array  # all that is linear in state and products of velocities: from `rate` to the accelerations
    mrp: Array
    quaternion: Array
    rate: Array
    velocity: Array
    wheel_speed: Array
    gyro_site_rate: Array
    accelerometer_site_acceleration: Array
    wheel_angle: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantWork:
    """Work arrays of a step."""

    given: Array  # (inputs,) with torques limited, then with friction
    load: Array  # (r,) of the inputs
    internal: Array  # (2 n + 6,): gyroscopic torques and momentum terms
    middle: Array  # (9 + u + 3,)
    crossed: Array  # (2, m): of z, from the other of each pair
    driven: Array  # (2 m + 9,)
    observed: Array  # velocity and rate, slope rates, accelerations, axial momenta, products of velocities
    torque: Array  # and views: (n,) of `given`
    gyroscopic: Array  # (2, n) of `internal`
    z: Array  # (2, m) of the state's vector
    other: Array  # (2, m): z, each in the place of the other of its pair
    moving: Array  # (2 m + 6,) of the vector, without the loads
    total: Array  # (r,) of the vector: the loads


@dataclass(slots=True, kw_only=True)
class PlantState:
    """What the plant remembers between steps, and the buffers that a step writes; `step` works in place."""

    mrp: Triple
    vector: Array  # z (2 m), linear and angular momentum (6), loads of the last step (r)
    internal: Array  # (r,): those of the loads that are gyroscopic torques and momentum terms
    momentum: Array  # (n,) axial, inertial [N.m.s]
    angle: Array  # (n,) [rad]
    speed: Array  # (n,) relative [rad/s]
    work: PlantWork = field(metadata=NOT_SAVED)
    outputs: PlantOutputs = field(metadata=NOT_SAVED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Telemetry:
    """Quantities for the engineer, computed on demand."""

    angular_momentum: Array  # (3,) inertial, about the body origin [N.m.s]
    energy: float  # J
    modal_displacement: Array  # (m,) [m sqrt(kg)]
    modal_velocity: Array  # (m,) [m sqrt(kg)/s]
    rms_deformation: float  # m


def init(prepared: PreparedPlant) -> PlantState:
    """Return the state at the start of a run, with buffers of its own; its outputs are true already."""
    motion = prepared.motion
    matrices, given = motion.matrices, motion.parameters
    axial_slope = np.einsum("ni,nim->nm", matrices.wheel_axis, matrices.wheel_slope)
    inertial = given.wheel_speed + product(matrices.wheel_axis, given.rate) + product(axial_slope, given.modal_velocity)
    velocity = np.concatenate([given.velocity, given.rate, given.modal_velocity])
    modal = np.concatenate([given.modal_displacement, given.modal_velocity])
    no_load = np.zeros(prepared.load_count)
    vector = np.concatenate([product(motion.free.of_structure, modal), product(motion.mass[:6], velocity), no_load])
    state = PlantState(
        mrp=rotations.mrp_from_quaternion(rotations.quaternion_from_mrp(given.mrp.tolist())),
        vector=vector,
        internal=no_load,
        momentum=matrices.wheel_inertia * inertial,
        angle=given.wheel_angle.copy(),
        speed=given.wheel_speed.copy(),
        work=_work(prepared, vector),
        outputs=_outputs(prepared),
    )
    _set_internal(prepared, state, prepared.now @ state.vector, state.momentum)
    state.work.total[:] = state.internal
    observe(prepared, state)
    return state


def _work(prepared: PreparedPlant, vector: Array) -> PlantWork:
    """Return work arrays, and views of them and of a state's vector."""
    m, n = prepared.modes, prepared.wheels
    given, internal = np.empty(prepared.input_count), np.empty(2 * n + 6)
    z = vector[: 2 * m].reshape(2, m)
    return PlantWork(
        given=given,
        load=np.empty(prepared.load_count),
        internal=internal,
        middle=np.empty(len(prepared.middle)),
        crossed=np.empty((2, m)),
        driven=np.empty(2 * m + 9),
        observed=np.empty(prepared.output_map.shape[1]),
        torque=given[:n],
        gyroscopic=internal[: 2 * n].reshape(2, n),
        z=z,
        other=z[::-1],
        moving=vector[: 2 * m + 6],
        total=vector[2 * m + 6 :],
    )


def _outputs(prepared: PreparedPlant) -> PlantOutputs:
    """Return the views of a new output buffer."""
    n, count = prepared.wheels, len(prepared.output_map)
    flat = np.zeros(7 + count + n)
    linear = flat[7 : 7 + count]
    gyro, acceleration = 6 + n, 6 + n + prepared.gyros
    return PlantOutputs(
        flat=flat,
        linear=linear,
        mrp=flat[:3],
        quaternion=flat[3:7],
        rate=linear[:3],
        velocity=linear[3:6],
        wheel_speed=linear[6:gyro],
        gyro_site_rate=linear[gyro:acceleration],
        accelerometer_site_acceleration=linear[acceleration:],
        wheel_angle=flat[7 + count :],
    )


def _set_internal(prepared: PreparedPlant, state: PlantState, middle: Array, momentum: Array) -> None:
    """Set the loads of gyroscopic torques and momentum terms, from momenta, rate and slope rates, and axial momenta."""
    held, gyroscopic = state.work.internal, state.work.gyroscopic
    np.matmul(prepared.gyroscopic, middle[6:], out=held[:-6])
    np.multiply(gyroscopic, momentum, out=gyroscopic)
    px, py, pz, hx, hy, hz, x, y, z = middle[:MIDDLE].tolist()
    held[-6:] = (
        y * pz - z * py,
        z * px - x * pz,
        x * py - y * px,
        y * hz - z * hy,
        z * hx - x * hz,
        x * hy - y * hx,
    )
    np.matmul(prepared.load_of_internal, held, out=state.internal)


def step(
    prepared: PreparedPlant, state: PlantState, inputs: Array, friction: PreparedFriction | None = None
) -> PlantOutputs:
    """Advance by one step with the inputs held over it; return the outputs, true at its end.

    Parameters
    ----------
    prepared : of any step length, for the same spacecraft and parameters as the state
    state : updated in place
    inputs : (n + 6 s + 6,): wheel torque [N.m], jitter force x, y, z [N] and torque x, y, z [N.m] on each mount,
        external force [N] and torque [N.m]; all but the first in body axes
    friction : of the wheels, prepared for the same step length; None: they turn freely

    Raises
    ------
    ValueError
        If the motion has diverged.
    """
    length, limit = prepared.step_length, prepared.torque_limit
    work, vector, momentum = state.work, state.vector, state.momentum
    load, torque, z = work.total, work.torque, work.z
    work.given[:] = inputs
    np.minimum(torque, limit, out=torque)
    np.maximum(torque, -limit, out=torque)
    np.matmul(prepared.load_of_input, work.given, out=work.load)
    np.add(work.load, state.internal, out=load)  # with those of the last step, to predict the middle of this one
    if friction is not None:
        bearing_friction.add(friction, vector, momentum, torque, work.load)
        np.add(work.load, state.internal, out=load)

    middle = np.matmul(prepared.middle, vector, out=work.middle)
    half_impulse = (0.5 * length) * torque
    np.add(momentum, half_impulse, out=momentum)
    _set_internal(prepared, state, middle, momentum)
    np.add(momentum, half_impulse, out=momentum)
    np.add(work.load, state.internal, out=load)

    driven = np.matmul(prepared.driven, load, out=work.driven)
    turned = (middle[-3:] + driven[-3:]).tolist()
    if not sum(angle * angle for angle in turned) < math.pi**2:  # the negation also finds NaN
        raise ValueError(
            f"the motion has diverged: steps of {length:g} s are too long for this rate; take shorter ones"
        )
    np.multiply(prepared.crossed, work.other, out=work.crossed)
    np.multiply(prepared.diagonal, z, out=z)
    np.add(z, work.crossed, out=z)
    np.add(work.moving, driven[:-3], out=work.moving)
    state.mrp = rotations.rotate_mrp(state.mrp, turned)
    previous = state.speed
    outputs = observe(prepared, state)
    # trapezoid: exact for the spin, second order for the mount's motion
    angle = state.angle
    angle += (0.5 * length) * (previous + outputs.wheel_speed)
    outputs.wheel_angle[:] = angle
    previous[:] = outputs.wheel_speed
    return outputs


def observe(prepared: PreparedPlant, state: PlantState) -> PlantOutputs:
    """Return the outputs in the present state; accelerations hold for the inputs of the last step."""
    count = len(prepared.observed)
    seen, outputs = state.work.observed, state.outputs
    np.matmul(prepared.observed, state.vector, out=seen[:count])
    seen[count:-PRODUCTS] = state.momentum
    vx, vy, vz, x, y, z = seen[:6].tolist()
    seen[-PRODUCTS:] = (
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
    np.matmul(prepared.output_map, seen, out=outputs.linear)
    outputs.flat[:7] = (*state.mrp, *rotations.quaternion_from_mrp(state.mrp))
    outputs.wheel_angle[:] = state.angle
    return outputs


def modal_motion(prepared: PreparedPlant, state: PlantState) -> tuple[Array, Array]:
    """Return eta [m sqrt(kg)] and eta' [m sqrt(kg)/s], (m,) each, in the present state."""
    free, z = prepared.motion.free, state.vector[: 2 * prepared.modes]
    return free.displacement @ z, free.velocity @ z


def telemetry(prepared: PreparedPlant, state: PlantState) -> Telemetry:
    """Return quantities of the present state that no other component needs.

    The angular momentum counts the tilt of the wheel axes with the structure, to second order in eta (PHYSICS section
    2). The RMS deformation is the norm of eta over the square root of the mass (P, section 5).
    """
    m, motion = prepared.modes, prepared.motion
    eta, speed = modal_motion(prepared, state)
    momentum = state.vector[2 * m : 2 * m + 6]
    velocity = np.concatenate([motion.compliance @ momentum - motion.carried @ speed, speed])
    matrices = motion.matrices
    tilt = np.cross(matrices.wheel_slope @ eta, matrices.wheel_axis)
    body = momentum[3:] + state.momentum @ (matrices.wheel_axis + tilt)
    return Telemetry(
        angular_momentum=rotations.matrix_from_mrp(state.mrp).T @ body,
        energy=float(
            0.5 * velocity @ (motion.mass @ velocity)
            + 0.5 * eta @ (motion.stiffness * eta)
            + 0.5 * np.sum(state.momentum * state.momentum) / prepared.wheel_inertia
        ),
        modal_displacement=eta,
        modal_velocity=speed,
        rms_deformation=math.hypot(*eta.tolist()) / math.sqrt(motion.mass[0, 0]),
    )
