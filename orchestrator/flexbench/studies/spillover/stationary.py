"""Fine pointing of a design on the full structure as covariances of the linear loop: seconds instead of many runs.

Sensor noise and broadband jitter are white. The harmonic jitter of each wheel is a sine at its nominal speed, with a
random phase of its own. Known delays are zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from flexsat.arrays import Array, Complex
from flexsat.design.chain import Design
from flexsat.design.estimator import measurement_noise
from flexsat.runtime.prepared_controller import PreparedController
from flexsat.spacecraft.linear_model import LinearModel

from ..margins.designed_loop import DesignedLoop

DOUBLINGS = 13  # of the star tracker's period of 0.1 s: 800 s, by when the slowest poles have settled


@dataclass(frozen=True, slots=True, kw_only=True)
class Stationary:
    """Root mean squares over time and over the random phases of the wheels."""

    pointing: float  # rad
    torque: float  # N.m, of the sum over the wheels of |torque|
    deformation: float  # m


@dataclass(frozen=True, slots=True, kw_only=True)
class _Loop:
    """The closed loop over a step with the star tracker and over one without; state: plant, then estimate."""

    transitions: tuple[Array, Array]
    noise: tuple[Array, Array]  # covariance that each adds
    jitter: Complex  # (size, n): of the harmonic jitter of each wheel, at its own frequency
    torque: Array  # (n, size): from the state one step later
    feed_forward: Complex  # (n, n): torque that the controller adds for the harmonic jitter of each wheel


def stationary(
    design: Design, plant: LinearModel, mass: float, fine: bool = True, jitter: bool = True, noise: bool = True
) -> Stationary:
    """Return pointing, torque and deformation of the settled loop.

    Parameters
    ----------
    design : with its controller
    plant : linear model of the real structure, at the wheel speeds of the design
    mass : of the spacecraft [kg]
    fine : with the fine guidance sensor, else the coarse star tracker
    jitter, noise : with the disturbances of the wheels; with the noise of the sensors
    """
    prepared = DesignedLoop(design=design, plant=plant, parameters={"star_tracker.fine": fine}).controller
    loop = _close(design, plant, prepared, fine, jitter, noise)
    first, rest = loop.transitions
    steps = prepared.phases
    settled = loop.noise[0]
    for _ in range(steps - 1):
        settled = rest @ settled @ rest.T + loop.noise[1]
    over = np.linalg.matrix_power(rest, steps - 1) @ first
    for _ in range(DOUBLINGS):
        settled = settled + over @ settled @ over.T
        over = over @ over

    index, size = plant.index, len(plant.a)
    angles = np.zeros(3)
    strain = 0.0
    torques = np.zeros((prepared.wheels, prepared.wheels))
    for phase in range(steps):
        step, added = (first, loop.noise[0]) if phase == 0 else (rest, loop.noise[1])
        settled = step @ settled @ step.T + added
        diagonal = np.diag(settled)
        angles += 16.0 * diagonal[index.mrp] / steps
        strain += float(diagonal[index.modal_displacement].sum()) / steps
        torques += loop.torque @ settled @ loop.torque.T / steps
    if jitter:
        omega = design.controller.nominal_speed
        for k in range(prepared.wheels):
            z = np.exp(1j * omega[k] * prepared.period)
            x = np.linalg.solve(z * np.eye(len(first)) - rest, loop.jitter[:, k])
            angles += 8.0 * np.abs(x[index.mrp]) ** 2
            strain += float(0.5 * (np.abs(x[:size][index.modal_displacement]) ** 2).sum())
            torque = z * (loop.torque @ x) + loop.feed_forward[:, k]
            torques += 0.5 * np.real(np.outer(torque, torque.conj()))
    return Stationary(
        pointing=float(np.sqrt(angles.sum())),
        torque=float(np.sqrt(np.sum(products_of_moduli(torques)))),
        deformation=float(np.sqrt(strain / mass)),
    )


def _close(
    design: Design, plant: LinearModel, prepared: PreparedController, fine: bool, jitter: bool, noise: bool
) -> _Loop:
    """Close the loop without delays: xh[k] = predicted + gain (y[k] - c predicted), u[k] = -feedback xh[k] + g d[k]."""
    s, n, size = prepared.states, prepared.wheels, len(plant.a)
    ad, bd, jd = _sampled(plant, prepared.period)
    predict, through = prepared.predict[:, :s], prepared.predict[:, s : s + n]
    assumed = prepared.predict[:, -4 * n :] if prepared.feed_forward_jitter else np.zeros((s, 4 * n))
    feedback = np.zeros((n, s))
    feedback[:, : prepared.controlled] = prepared.feedback
    tracker = design.config.noise.star_tracker_fine if fine else design.config.noise.star_tracker_coarse
    deviation = np.sqrt(measurement_noise(plant, design.config.noise, tracker, design.config.gyro_noise)) * float(noise)
    wheels = design.config.wheel_set
    broadband = wheels.broadband * float(jitter)
    shaken = np.zeros((size + s, 4 * n))
    shaken[:size] = jd * broadband

    transitions, covariances = [], []
    for gain in (prepared.gain[0], prepared.gain[1] if prepared.phases > 1 else prepared.gain[0]):
        rest = np.eye(s) - gain @ prepared.c
        estimate = np.hstack([gain @ plant.c, rest @ (predict - through @ feedback)])
        transitions.append(np.vstack([np.hstack([ad, np.zeros((size, s))]) - bd @ feedback @ estimate, estimate]))
        entered = np.vstack([-bd @ feedback @ gain, gain]) * deviation
        covariances.append(entered @ entered.T + shaken @ shaken.T)

    # phasors of exp(j angle): force (sin, cos), torque (-cos, sin), held from the middle of the step
    omega = design.controller.nominal_speed
    middle, z = np.exp(0.5j * omega * prepared.period), np.exp(1j * omega * prepared.period)
    force, couple = wheels.imbalance_force * omega**2, wheels.imbalance_torque * omega**2
    harmonic = np.zeros((4 * n, n), dtype=complex)
    for block, phasor in enumerate((-1j * force, force, -couple, -1j * couple)):
        harmonic[block * n : (block + 1) * n] = np.diag(phasor * middle)
    forward: Complex = np.zeros((n, n), dtype=complex)
    if prepared.feed_forward_jitter:
        forward += prepared.jitter_torque @ harmonic
    rest = np.eye(s) - (prepared.gain[1] if prepared.phases > 1 else prepared.gain[0]) @ prepared.c
    expected = rest @ (assumed @ harmonic + through @ forward) / z  # in the estimate, from the step before
    return _Loop(
        transitions=(transitions[0], transitions[1]),
        noise=(covariances[0], covariances[1]),
        jitter=np.vstack([jd @ harmonic + bd @ forward - bd @ feedback @ expected, expected]),
        torque=np.hstack([np.zeros((n, size)), -feedback]),
        feed_forward=forward,
    )


def _sampled(plant: LinearModel, period: float) -> tuple[Array, Array, Array]:
    inputs = np.hstack([plant.b_torque, plant.b_jitter])
    size, count = inputs.shape
    block = np.zeros((size + count, size + count))
    block[:size, :size], block[:size, size:] = period * plant.a, period * inputs
    sampled = np.asarray(expm(block), np.float64)
    wheels = plant.index.wheels
    return sampled[:size, :size], sampled[:size, size : size + wheels], sampled[:size, size + wheels :]


def products_of_moduli(covariance: Array) -> Array:
    """Return the mean of |a b| for each two of normally distributed numbers: 2/pi (sqrt(1 - r^2) + r asin r) s t."""
    deviation = np.sqrt(np.diag(covariance))
    product = np.outer(deviation, deviation)
    r = np.clip(np.divide(covariance, product, out=np.zeros_like(product), where=product > 0.0), -1.0, 1.0)
    return np.asarray(2.0 / np.pi * (np.sqrt(1.0 - r**2) + r * np.arcsin(r)) * product)
