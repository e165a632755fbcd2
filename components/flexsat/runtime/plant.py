"""Run-time plant: rigid body, modes and wheels, stepped exactly in their linear part.

Equations of motion: P, with the terms as PHYSICS section 2 gives them. Over a step the vibration is carried by the
exponentials of the free structure's modes, one block each, and the momentum of the whole by the resultant of all
forces; the gyroscopic and momentum terms are evaluated once, at a predicted mid-step, and held. Error order: 2 in the
step. These terms are explicit: at 5 ms the step is stable up to body rates of 0.2 rad/s, at 1 ms up to 0.5 rad/s, a
thousand times the mission's. A step costs in proportion to the number of modes. numpy alone.

One sign differs from P's: the modal momentum term, so that a uniform velocity of the whole spacecraft changes nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..fixed_order import product
from . import bearing_friction, motors, rotations
from .bearing_friction import PreparedFriction
from .loads import tilted_axes
from .named_state import NOT_SAVED
from .prepared_plant import MIDDLE, PRODUCTS, PreparedPlant, at_step, prepare, prepare_motion
from .rotations import Triple

__all__ = [
    "PlantOutputs",
    "PlantState",
    "PreparedPlant",
    "Telemetry",
    "agree",
    "at_step",
    "feed_through",
    "init",
    "observe",
    "prepare",
    "prepare_motion",
    "set_motion",
    "step",
    "structure_motion",
    "telemetry",
]


SAME = 1e-9  # relative difference of two motions that are the same but for rounding


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
    half_impulse: Array  # (n,) of the motors [N.m.s]
    load: Array  # (r,) of the inputs
    internal: Array  # (2 n + 6,): gyroscopic torques and momentum terms
    middle: Array  # (9 + u + 3,)
    crossed: Array  # (2, m): of z, from the other of each pair; and its rows, (m,):
    first_change: Array
    second_change: Array
    driven: Array  # (2 m + 9,), and views: (2 m + 6,), and the turn (3,)
    moved: Array
    turned: Array
    observed: Array  # velocity and rate, slope rates, accelerations, axial momenta, products of velocities; and views:
    of_vector: Array  # all but the last two of these
    axial: Array  # (n,)
    products: Array
    torque: Array  # and views: (n,) of `given`
    gyroscopic: Array  # (2, n) of `internal`
    z: Array  # (2, m) of the state's vector
    first: Array  # (m,) of z
    second: Array
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
    vector = np.zeros(prepared.observed.shape[1])
    state = PlantState(
        mrp=rotations.mrp_from_quaternion(rotations.quaternion_from_mrp(given.mrp.tolist())),
        vector=vector,
        internal=np.zeros(prepared.load_count),
        momentum=matrices.wheel_inertia * inertial,
        angle=given.wheel_angle.copy(),
        speed=given.wheel_speed.copy(),
        work=_work(prepared, vector),
        outputs=_outputs(prepared),
    )
    set_motion(
        prepared, state, np.concatenate([given.modal_displacement, given.velocity, given.rate, given.modal_velocity])
    )
    observe(prepared, state)
    return state


def set_motion(prepared: PreparedPlant, state: PlantState, structure: Array) -> None:
    """Set the motion of body and structure, (eta, v, w, eta'); no inputs act. The wheels' axial momenta stay."""
    m, motion, work = prepared.modes, prepared.motion, state.work
    modal = np.concatenate([structure[:m], structure[m + 6 :]])
    work.moving[: 2 * m] = product(motion.free.of_structure, modal)
    work.moving[2 * m :] = product(motion.mass[:6], structure[m:])
    work.total[:] = 0.0
    _set_internal(prepared, state, prepared.now @ state.vector, state.momentum)
    work.total[:] = state.internal


def structure_motion(prepared: PreparedPlant, state: PlantState) -> Array:
    """Return the present motion of body and structure, (eta [m sqrt(kg)], v [m/s], w [rad/s], eta'), (2 m + 6,)."""
    motion, moving = prepared.motion, state.work.moving
    z, momentum = moving[:-6], moving[-6:]
    speed = motion.free.velocity @ z
    return np.concatenate([motion.free.displacement @ z, motion.compliance @ momentum - motion.carried @ speed, speed])


def _work(prepared: PreparedPlant, vector: Array) -> PlantWork:
    """Return work arrays, and views of them and of a state's vector."""
    m, n, count = prepared.modes, prepared.wheels, len(prepared.observed)
    given, internal = np.empty(prepared.input_count), np.empty(2 * n + 6)
    driven, observed = np.empty(2 * m + 9), np.empty(prepared.output_map.shape[1])
    z, crossed = vector[: 2 * m].reshape(2, m), np.empty((2, m))
    return PlantWork(
        given=given,
        half_impulse=np.empty(n),
        load=np.empty(prepared.load_count),
        internal=internal,
        middle=np.empty(len(prepared.middle)),
        crossed=crossed,
        first_change=crossed[0],
        second_change=crossed[1],
        driven=driven,
        moved=driven[:-3],
        turned=driven[-3:],
        observed=observed,
        of_vector=observed[:count],
        axial=observed[count:-PRODUCTS],
        products=observed[-PRODUCTS:],
        torque=given[:n],
        gyroscopic=internal[: 2 * n].reshape(2, n),
        z=z,
        first=z[0],
        second=z[1],
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
    prepared.gyroscopic.dot(middle[6:], out=held[:-6])
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
    prepared.load_of_internal.dot(held, out=state.internal)


def agree(prepared: PreparedPlant, state: PlantState, structure: Array) -> None:
    """Set the vibration to that of `structure`, (eta, v, w, eta'), unless it is that but for rounding.

    Where two modes have one frequency, their coordinates depend on the last bits of linear algebra: another processor
    may have others. A state that continues where it was saved keeps its bits.

    Raises
    ------
    ValueError
        If `structure` is not of this plant's size.
    """
    present = structure_motion(prepared, state)
    if structure.shape != present.shape:
        raise ValueError(f"structure is {structure.shape} in the saved state, and {present.shape} in this component")
    m, motion = prepared.modes, prepared.motion
    differing = [
        np.linalg.norm(structure[part] - present[part]) > SAME * np.linalg.norm(structure[part])
        for part in (slice(0, m), slice(m + 6, None))
    ]
    if any(differing):
        modal = np.concatenate([structure[:m], structure[m + 6 :]])
        state.work.moving[: 2 * m] = product(motion.free.of_structure, modal)


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
    length, work, vector, momentum = prepared.step_length, state.work, state.vector, state.momentum
    load, z = work.total, work.z
    torque = _hold(prepared, state, inputs, friction)

    middle = prepared.middle.dot(vector, out=work.middle)
    half_impulse = np.multiply(prepared.half_step, torque, out=work.half_impulse)
    np.add(momentum, half_impulse, out=momentum)
    _set_internal(prepared, state, middle, momentum)
    np.add(momentum, half_impulse, out=momentum)
    np.add(work.load, state.internal, out=load)

    prepared.driven.dot(load, out=work.driven)
    turned = a, b, c = (middle[-3:] + work.turned).tolist()
    if not a * a + b * b + c * c < math.pi**2:  # the negation also finds NaN
        raise ValueError(
            f"the motion has diverged: steps of {length:g} s are too long for this rate; take shorter ones"
        )
    if len(prepared.coupled):
        z[:] = prepared.coupled.dot(z.reshape(-1)).reshape(z.shape)
    else:  # rows by themselves: one product with the rows of z in reverse takes twice the time
        np.multiply(prepared.of_second, work.second, out=work.first_change)
        np.multiply(prepared.of_first, work.first, out=work.second_change)
        np.multiply(prepared.diagonal, z, out=z)
        np.add(z, work.crossed, out=z)
    np.add(work.moving, work.moved, out=work.moving)
    state.mrp = rotations.rotate_mrp(state.mrp, turned)
    previous = state.speed
    outputs = _observe_motion(prepared, state)
    # trapezoid: exact for the spin, second order for the mount's motion
    angle = state.angle
    np.add(previous, outputs.wheel_speed, out=previous)
    np.multiply(prepared.half_step, previous, out=previous)
    np.add(angle, previous, out=angle)
    outputs.wheel_angle[:] = angle
    previous[:] = outputs.wheel_speed
    return outputs


def _hold(prepared: PreparedPlant, state: PlantState, inputs: Array, friction: PreparedFriction | None) -> Array:
    """Hold inputs from now on, the torques limited and with friction; return these torques, a view."""
    work, load = state.work, state.work.total
    work.given[:] = inputs
    torque = work.torque
    motors.quantise(prepared.motors, torque)
    np.minimum(torque, prepared.most_torque, out=torque)
    np.maximum(torque, prepared.least_torque, out=torque)
    motors.limit_by_speed(prepared.motors, state.speed, torque)
    prepared.load_of_input.dot(work.given, out=work.load)
    np.add(work.load, state.internal, out=load)  # with those of the last step, to predict the middle of this one
    if friction is not None:
        bearing_friction.add(friction, state.vector, state.momentum, torque, work.load)
        np.add(work.load, state.internal, out=load)
    return torque


def feed_through(
    prepared: PreparedPlant, state: PlantState, inputs: Array, friction: PreparedFriction | None = None
) -> PlantOutputs:
    """Return the outputs in the present state with other inputs at work: the accelerations, which jump with them.

    Parameters
    ----------
    prepared, state, inputs, friction : as of `step`; the next step holds the inputs that it is given
    """
    _hold(prepared, state, inputs, friction)
    return observe(prepared, state)


def observe(prepared: PreparedPlant, state: PlantState) -> PlantOutputs:
    """Return the outputs in the present state; accelerations are those with the inputs held last."""
    outputs = _observe_motion(prepared, state)
    outputs.wheel_angle[:] = state.angle
    return outputs


def _observe_motion(prepared: PreparedPlant, state: PlantState) -> PlantOutputs:
    """Set all outputs but the wheels' angles."""
    work, outputs = state.work, state.outputs
    prepared.observed.dot(state.vector, out=work.of_vector)
    work.axial[:] = state.momentum
    vx, vy, vz, x, y, z = work.observed[:6].tolist()
    work.products[:] = (
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
    prepared.output_map.dot(work.observed, out=outputs.linear)
    outputs.flat[:7] = (*state.mrp, *rotations.quaternion_from_mrp(state.mrp))
    return outputs


def telemetry(prepared: PreparedPlant, state: PlantState) -> Telemetry:
    """Return quantities of the present state that no other component needs.

    The angular momentum counts the tilt of the wheel axes with the structure, to second order in eta (PHYSICS section
    2). The RMS deformation is the norm of eta over the square root of the mass (P, section 5).
    """
    m, motion = prepared.modes, prepared.motion
    matrices, loads, momentum = motion.matrices, motion.loads, state.work.moving[-6:]
    moving = structure_motion(prepared, state)
    eta, body, speed = moving[:m], moving[m : m + 6], moving[m + 6 :]
    axes = tilted_axes(matrices, loads, eta)
    modal_momentum = motion.mass[6:, :6] @ body + speed
    return Telemetry(
        angular_momentum=rotations.matrix_from_mrp(state.mrp).T @ (momentum[3:] + state.momentum @ axes),
        energy=float(
            0.5 * (body @ momentum + speed @ modal_momentum)
            + 0.5 * eta @ (motion.stiffness * eta)
            + 0.5 * _spin(prepared.wheel_inertia, state.momentum)
        ),
        modal_displacement=eta,
        modal_velocity=speed,
        rms_deformation=math.hypot(*eta.tolist()) / math.sqrt(motion.mass[0, 0]),
    )


def _spin(inertia: Array, momentum: Array) -> float:
    """Return the sum of squared axial momenta over inertias [J]; wheels of one inertia are divided by it once."""
    return float(np.sum(momentum * momentum * (inertia[0] / inertia)) / inertia[0])
