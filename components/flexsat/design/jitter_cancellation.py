"""Torques against the deformation that the wheels' harmonic jitter causes, from the known imbalance and wheel angles.

A feed-forward: it changes no margin. Each wheel's imbalance is a sine at its speed, so that the structure answers with
a sine; the torques that minimise deformation and effort there are linear in the jitter. The feedback answers to the
jitter as well, so it is part of the plant here.
"""

from __future__ import annotations

import math

import numpy as np

from ..arrays import Array
from ..description.wheel_set import WheelSet
from ..fixed_order import product, solve
from ..runtime.zero_order_hold import zero_order_hold
from ..spacecraft.linear_model import LinearModel, StateIndex
from .estimator import Estimator

MODES = 60  # of the structure that count: up to 15 Hz, beyond the harmonics of any wheel


def jitter_torque(
    plant: LinearModel,
    wheel_set: WheelSet,
    estimator: Estimator,
    feedback: Array,
    model: LinearModel,
    period: float,
    effort: float,
) -> Array:
    """Return the torques for unit jitter (force a, force b, torque a, torque b), (n, 4 n) [N.m per N and N.m].

    Parameters
    ----------
    plant : linear model of the structure with enough modes
    wheel_set : with the imbalance of each wheel
    estimator : periodic filter; its gain between samples of the star tracker is used
    feedback : (n, r) on the first r states of the estimate
    model : that the estimator predicts with
    period : [s]
    effort : weight of the squared torques against that of the modal displacements [m2.kg/(N.m)^2]

    Sums run in a fixed order and numbers are real: the same bits on any processor. Complex numbers z stand as
    [re z, -im z; im z, re z].
    """
    n, index = plant.index.wheels, plant.index
    size, known = index.unfiltered, model.index.unfiltered
    a, b, jitter = _held(plant, period)
    own_a, own_b, own_jitter = _held(model, period)
    seen, own_seen = _without_accelerometers(plant), _without_accelerometers(model)
    gain = estimator.gain[min(1, len(estimator.gain) - 1)][:known, _measured(model.index, model.gyro_count)]
    rest = np.eye(known) - product(gain, own_seen)
    estimate = np.hstack([product(gain, seen), product(rest, own_a - product(own_b, feedback))])
    through = product(b, feedback)
    state = np.hstack([a, np.zeros((size, known))]) - product(through, estimate)
    closed = np.vstack([state, estimate])  # of the plant's state and the estimate of the step before
    forward = product(rest, own_b)  # of last step's torque in the estimate
    assumed = product(rest, own_jitter)

    result = np.zeros((n, 4 * n))
    if not wheel_set.imbalance.any():
        return result
    for speed in sorted(set(plant.nominal_speed.tolist())):
        wheels = np.flatnonzero(plant.nominal_speed == speed)
        force, couple = wheel_set.imbalance_force[wheels], wheel_set.imbalance_torque[wheels]
        z = _phasor(speed * period)
        # phasors of exp(j angle), angle at mid-step: force (-j, 1), torque (-1, -j), times speed squared
        columns = [wheels + k * n for k in range(4)]
        real = np.zeros((4 * n, len(wheels)))
        imaginary = np.zeros((4 * n, len(wheels)))
        each = np.arange(len(wheels))
        imaginary[columns[0], each], real[columns[1], each] = -force * speed**2, force * speed**2
        real[columns[2], each], imaginary[columns[3], each] = -couple * speed**2, -couple * speed**2

        def entering(plant_side: Array, model_side: Array, re: Array, im: Array, z: Array = z) -> Array:
            """Return what inputs do to the closed loop, as [re; im]: the estimate knows them a step later."""
            later = _over(z, np.vstack([product(model_side, re), product(model_side, im)]))
            now = np.vstack([product(plant_side, re), product(plant_side, im)])
            return _stack(now - _both(through, later), later)

        unit = np.eye(n)
        torque_side = entering(b, forward, unit, np.zeros((n, n)))
        rhs = np.hstack([torque_side, entering(jitter, assumed, real, imaginary)])
        dynamic = np.kron(np.array([[z[0, 0], z[0, 1]], [z[1, 0], z[1, 1]]]), np.eye(size + known))
        dynamic -= np.kron(np.eye(2), closed)
        response = solve(dynamic, rhs)
        upper, lower = response[: size + known], response[size + known :]
        strain = np.vstack([upper[index.modal_displacement], lower[index.modal_displacement]])
        returned = _times(z, np.vstack([-product(feedback, upper[size:]), -product(feedback, lower[size:])]))
        returned[:n, :n] += unit
        torques = _least_squares(strain, returned, n, effort)
        up, down = torques[:n], torques[n:]  # re and im of each wheel's torque
        # the torques of a wheel are those of its force, or of its torque where it has no force
        pushing, twisting = force > 0.0, (force == 0.0) & (couple > 0.0)
        result[:, columns[0][pushing]] = -down[:, pushing] / (force[pushing] * speed**2)
        result[:, columns[1][pushing]] = up[:, pushing] / (force[pushing] * speed**2)
        result[:, columns[2][twisting]] = -up[:, twisting] / (couple[twisting] * speed**2)
        result[:, columns[3][twisting]] = -down[:, twisting] / (couple[twisting] * speed**2)
    return result


def _least_squares(strain: Array, torque: Array, n: int, effort: float) -> Array:
    """Return the torques, (2 n, k), that minimise |strain|^2 + effort |torque|^2.

    Columns of both: the response to n unit torques, then to k jitters.
    """
    weighted = math.sqrt(effort)
    response = np.vstack([_complex_matrix(strain[:, :n]), weighted * _complex_matrix(torque[:, :n])])
    free = np.vstack([strain[:, n:], weighted * torque[:, n:]])
    return -solve(product(response.T, response), product(response.T, free))


def _complex_matrix(stacked: Array) -> Array:
    """Return [re, -im; im, re] of [re; im]."""
    half = len(stacked) // 2
    re, im = stacked[:half], stacked[half:]
    return np.block([[re, -im], [im, re]])


def _phasor(angle: float) -> Array:
    """Return exp(j angle) as a matrix, on a grid that hides the last digits of the processor's sine."""
    cosine, sine = (round(f(angle) * 2.0**40) / 2.0**40 for f in (math.cos, math.sin))
    return np.array([[cosine, -sine], [sine, cosine]])


def _times(z: Array, stacked: Array) -> Array:
    """Return z times a stacked [re; im]."""
    half = len(stacked) // 2
    re, im = stacked[:half], stacked[half:]
    return np.vstack([z[0, 0] * re + z[0, 1] * im, z[1, 0] * re + z[1, 1] * im])


def _over(z: Array, stacked: Array) -> Array:
    return _times(z.T, stacked)  # |z| = 1 but for its grid


def _both(matrix: Array, stacked: Array) -> Array:
    half = len(stacked) // 2
    return np.vstack([product(matrix, stacked[:half]), product(matrix, stacked[half:])])


def _stack(first: Array, second: Array) -> Array:
    """Return [re; im] of both parts, from each part's [re; im]."""
    one, two = len(first) // 2, len(second) // 2
    return np.vstack([first[:one], second[:two], first[one:], second[two:]])


def _held(model: LinearModel, period: float) -> tuple[Array, Array, Array]:
    size, wheels = model.index.unfiltered, model.index.wheels
    inputs = np.hstack([model.b_torque[:size], model.b_jitter[:size]])
    ad, bd = zero_order_hold(model.a[:size, :size], inputs, period)
    return ad, bd[:, :wheels], bd[:, wheels:]


def _measured(index: StateIndex, gyros: int) -> Array:
    """Return which measurements are not the accelerometers' and not the star tracker's."""
    start = gyros + index.accelerometers
    return np.concatenate([np.arange(gyros), np.arange(start, start + index.wheels)])


def _without_accelerometers(model: LinearModel) -> Array:
    return np.asarray(model.c[_measured(model.index, model.gyro_count)][:, : model.index.unfiltered])
