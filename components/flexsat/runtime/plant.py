"""Run-time plant: rigid body, modes and wheels, stepped exactly in their linear part.

Equations of motion: P, with the terms as PHYSICS section 2 gives them. Over a step the linear structure is carried by
its matrix exponential; the gyroscopic and momentum terms are evaluated once, at a predicted mid-step, and held. Error
order: 2 in the step. These terms are explicit: at 5 ms the step is stable up to body rates of 0.2 rad/s, at 1 ms up to
0.5 rad/s, a thousand times the mission's. numpy alone.

One sign differs from P's: the modal momentum term, so that a uniform velocity of the whole spacecraft changes nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from . import bearing_friction, rotations
from .bearing_friction import PreparedFriction
from .named_state import NOT_SAVED
from .prepared_plant import PRODUCTS, PreparedPlant, prepare
from .rotations import Triple

__all__ = [
    "PlantOutputs",
    "PlantState",
    "PreparedPlant",
    "Telemetry",
    "feed_through",
    "init",
    "observe",
    "prepare",
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
    modal_displacement: Array
    modal_velocity: Array
    wheel_speed: Array
    gyro_site_rate: Array
    accelerometer_site_acceleration: Array
    wheel_angle: Array
    rms_deformation: Array  # (1,)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantWork:
    """Work arrays of a step."""

    start: Array  # structure state at the start of the step, then what is held over it
    middle: Array  # momenta, rate and gyroscopic factors at mid-step
    end: Array  # structure state at the end, then the integral of w
    observed: Array  # structure state, wheel momentum, products of velocities


@dataclass(slots=True, kw_only=True)
class PlantState:
    """What the plant remembers between steps, and the buffers that a step writes; `step` works in place."""

    mrp: Triple
    structure: Array  # eta, v, w, eta'
    momentum: Array  # (n,) axial, inertial [N.m.s]
    angle: Array  # (n,) [rad]
    speed: Array  # (n,) relative [rad/s]
    held: Array  # what was held over the last step: the inputs, gyroscopic torques (2 n), momentum terms (6)
    work: PlantWork = field(metadata=NOT_SAVED)
    outputs: PlantOutputs = field(metadata=NOT_SAVED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Telemetry:
    """Quantities for the engineer, computed on demand."""

    angular_momentum: Array  # (3,) inertial, about the body origin [N.m.s]
    energy: float  # J


def init(prepared: PreparedPlant) -> PlantState:
    """Return the state at the start of a run, with buffers of its own; its outputs are true already."""
    m, n, size = prepared.modes, prepared.wheels, len(prepared.initial_structure)
    momentum = prepared.initial_momentum.copy()
    held = np.zeros(prepared.held_count)
    now = prepared.momentum_map @ prepared.initial_structure[m:]
    held[prepared.input_count : -6] = now[9:] * np.concatenate([momentum, momentum])
    held[-6:] = _momentum_terms(now)
    state = PlantState(
        mrp=rotations.mrp_from_quaternion(rotations.quaternion_from_mrp(prepared.initial_mrp.tolist())),
        structure=prepared.initial_structure.copy(),
        momentum=momentum,
        angle=prepared.initial_angle.copy(),
        speed=prepared.initial_speed.copy(),
        held=held,
        work=PlantWork(
            start=np.empty(size + prepared.held_count),
            middle=np.empty(9 + 2 * n),
            end=np.empty(size + 3),
            observed=np.empty(size + n + PRODUCTS),
        ),
        outputs=_outputs(prepared),
    )
    observe(prepared, state)
    return state


def _outputs(prepared: PreparedPlant) -> PlantOutputs:
    """Return the views of a new output buffer."""
    m, n, count = prepared.modes, prepared.wheels, len(prepared.output_map)
    flat = np.zeros(7 + count + n + 1)
    linear = flat[7 : 7 + count]
    gyro, acceleration = 6 + 2 * m + n, 6 + 2 * m + n + prepared.gyros
    return PlantOutputs(
        flat=flat,
        linear=linear,
        mrp=flat[:3],
        quaternion=flat[3:7],
        rate=linear[:3],
        velocity=linear[3:6],
        modal_displacement=linear[6 : 6 + m],
        modal_velocity=linear[6 + m : 6 + 2 * m],
        wheel_speed=linear[6 + 2 * m : gyro],
        gyro_site_rate=linear[gyro:acceleration],
        accelerometer_site_acceleration=linear[acceleration:],
        wheel_angle=flat[7 + count : -1],
        rms_deformation=flat[-1:],
    )


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
    n, size, count = prepared.wheels, 2 * prepared.modes + 6, prepared.input_count
    work, held, momentum = state.work.start, state.held, state.momentum
    torque = _hold(prepared, state, inputs, friction)

    mid = np.matmul(prepared.mid_step, work, out=state.work.middle)
    impulse = prepared.step_length * torque
    momentum_mid = momentum + 0.5 * impulse
    np.multiply(mid[9 : 9 + n], momentum_mid, out=held[count : count + n])
    np.multiply(mid[9 + n :], momentum_mid, out=held[count + n : count + 2 * n])
    held[count + 2 * n :] = _momentum_terms(mid)
    work[size + count :] = held[count:]

    end = np.matmul(prepared.whole_step, work, out=state.work.end)
    state.structure[:] = end[:size]
    momentum += impulse
    turned = end[size:].tolist()
    if not sum(angle * angle for angle in turned) < math.pi**2:  # the negation also finds NaN
        length = prepared.step_length
        raise ValueError(
            f"the motion has diverged: steps of {length:g} s are too long for this rate; take shorter ones"
        )
    state.mrp = rotations.rotate_mrp(state.mrp, turned)
    previous = state.speed
    outputs = observe(prepared, state)
    # trapezoid: exact for the spin, second order for the mount's motion
    angle = state.angle
    angle += (0.5 * prepared.step_length) * (previous + outputs.wheel_speed)
    outputs.wheel_angle[:] = angle
    previous[:] = outputs.wheel_speed
    return outputs


def _hold(prepared: PreparedPlant, state: PlantState, inputs: Array, friction: PreparedFriction | None) -> Array:
    """Hold inputs from now on, the torques limited and with friction; return these torques, a view."""
    n, size, count = prepared.wheels, 2 * prepared.modes + 6, prepared.input_count
    limit = prepared.torque_limit
    work, held = state.work.start, state.held
    held[:count] = inputs
    torque = held[:n]
    np.minimum(torque, limit, out=torque)
    np.maximum(torque, -limit, out=torque)
    work[:size] = state.structure
    work[size:] = held  # with the gyroscopic and momentum terms of the last step, to predict the middle of this one
    if friction is not None:
        bearing_friction.add(friction, work, state.momentum, torque)
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
    """Return the outputs in the present state; accelerations are those with the inputs held last.

    The RMS deformation is the norm of eta over the square root of the mass (P, section 5).
    """
    m, n = prepared.modes, prepared.wheels
    size = 2 * m + 6
    seen, outputs = state.work.observed, state.outputs
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
    np.matmul(prepared.output_map, seen, out=outputs.linear)
    acceleration = outputs.accelerometer_site_acceleration
    acceleration += prepared.acceleration_of_held @ state.held
    outputs.flat[:7] = (*state.mrp, *rotations.quaternion_from_mrp(state.mrp))
    outputs.wheel_angle[:] = state.angle
    eta = outputs.modal_displacement
    outputs.rms_deformation[0] = math.hypot(*eta.tolist()) / math.sqrt(prepared.mass[0, 0])
    return outputs


def telemetry(prepared: PreparedPlant, state: PlantState) -> Telemetry:
    """Return inertial angular momentum and energy in the present state.

    The momentum counts the tilt of the wheel axes with the structure, to second order in eta (PHYSICS section 2).
    """
    m = prepared.modes
    eta, velocity = state.structure[:m], state.structure[m:]
    axes = prepared.wheel_axis + prepared.tilt @ eta
    body = prepared.mass[3:6] @ velocity + state.momentum @ axes
    return Telemetry(
        angular_momentum=rotations.matrix_from_mrp(state.mrp).T @ body,
        energy=float(
            0.5 * velocity @ (prepared.mass @ velocity)
            + 0.5 * eta @ (prepared.stiffness * eta)
            + 0.5 * np.sum(state.momentum * state.momentum) / prepared.wheel_inertia
        ),
    )
