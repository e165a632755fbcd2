"""Errors of the estimated external torque and gyro biases: what was simulated, and the covariance of their filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.closed_loop import port_values
from flexsat.design.chain import Design
from flexsat.design.slow_errors import design_slow_filter, slow_noise
from flexsat.ports import sensors as interface
from flexsat.runtime.sensors import STREAM
from flexsat.sensor_errors import add_fast_errors, init_errors, star_tracker_error
from flexsat.slow_errors import RATE, TORQUES

from .vibration import FilterStep, measured_vibration, ripple

SETTLED = 8.0  # time constants of the filter from which on it is judged: 1 deg/h is 1,300 deviations of a bias


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowErrors:
    """Estimates less truth, one row a controller step; columns of what is not estimated are zero."""

    error: Array  # (rows, 3 + g): external torque [N.m], bias of each gyro [rad/s]
    choice: tuple[bool, bool]  # whether the torque and the biases are estimated
    shaken: bool = True  # whether the wheels had jitter


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowCovariance:
    """What the filter knows of its errors in the steady state."""

    covariance: Array  # (3 + g, 3 + g), predicted for a sample of the star tracker
    vibration: Array  # (3 + g, 3 + g), of what the wheels' harmonics add, which the filter does not know
    time_constant: float  # s: of its slowest error


def groups(choice: tuple[bool, bool], gyros: int) -> dict[str, slice]:
    """Return the columns of each quantity that is estimated."""
    both = {"external torque": slice(0, TORQUES), "gyro biases": slice(TORQUES, TORQUES + gyros)}
    return {name: part for (name, part), chosen in zip(both.items(), choice, strict=True) if chosen}


def true_biases(design: Design, given: Mapping[str, Any], samples: int) -> Array:
    """Return the bias of each gyro at each of its samples, (samples, g) [rad/s], of sensors with some parameters.

    It is drawn again from the seed, by the functions that drew it in the run: nothing else uses their random stream.
    """
    matrices = design.sensors
    values = port_values("sensors", interface.ports(matrices), given)
    parameters = interface.parameters(matrices, values.__getitem__, design.config.rates.sensors)
    found = np.zeros((samples, parameters.gyros))
    prepared = parameters.errors
    if prepared is None:
        return found
    stream = np.random.SeedSequence([parameters.seed, STREAM]).spawn(3)[2]
    state = init_errors(prepared, np.random.default_rng(stream))
    still, nothing = np.zeros(parameters.gyros), np.zeros(parameters.accelerometers)
    stride = parameters.star_tracker_steps // parameters.fast_steps
    for row in range(samples):
        add_fast_errors(prepared, state, row == 0, still, still.copy(), nothing.copy())
        if row % stride == 0:
            star_tracker_error(prepared, state, row == 0, [0.0, 0.0, 0.0])
        found[row] = state.gyro_bias
    return found


def slow_covariance(design: Design, fine: bool, choice: tuple[bool, bool]) -> SlowCovariance:
    """Return the covariance of the errors of torque and biases, what the wheels' vibration adds, and how they decay."""
    craft, rates = design.spacecraft, design.config.rates
    axes, period = craft.gyros.axis, rates.controller
    phases = round(rates.star_tracker / period)
    found = design_slow_filter(craft.inertia, axes, slow_noise(design.config, fine), period, phases, choice)
    gyros, size = len(axes), len(found.covariance)
    used = np.flatnonzero(found.sample.any(axis=1))
    a, seen = np.eye(size), np.zeros((gyros + 3, size))
    a[:3, 3:6] = period * np.eye(3)
    a[:3, 6:9], a[3:6, 6:9] = 0.5 * period**2 * np.linalg.inv(craft.inertia), period * np.linalg.inv(craft.inertia)
    seen[:gyros, RATE], seen[:gyros, RATE.stop + TORQUES :], seen[gyros:, :3] = axes, np.eye(gyros), np.eye(3)
    some = np.ix_(used, used)
    between = np.hstack([found.between, np.zeros((size, 3))])  # which sees no star tracker
    steps = [FilterStep(a=(np.eye(len(used)) - gain[used] @ seen[:, used]) @ a[some], gain=gain[used])
             for gain in (found.sample, *[between] * (phases - 1))]  # fmt: skip
    radius = float(np.abs(np.linalg.eigvals(np.linalg.multi_dot([one.a for one in reversed(steps)]))).max())
    vibration = np.zeros((size, size))
    vibration[some] = ripple(steps, period, *measured_vibration(design))
    return SlowCovariance(
        covariance=found.covariance[RATE.stop :, RATE.stop :],
        vibration=vibration[RATE.stop :, RATE.stop :],
        time_constant=-phases * period / float(np.log(radius)),
    )


def block_means(errors: Array, rows: int) -> Array:
    """Return the means of each `rows` rows of errors, (k, m) to (k // rows, m); what is left at the end is dropped."""
    whole = len(errors) // rows * rows
    return np.asarray(errors[:whole].reshape(-1, rows, errors.shape[1]).mean(axis=1))


def slow_errors(
    estimate: Array, torque: Array, biases: Array, choice: tuple[bool, bool], shaken: bool = True
) -> SlowErrors:
    """Return the errors of estimates (rows, 3 + g) against the true torque (rows, 3) and biases (rows, g)."""
    error = estimate - np.hstack([torque, biases])
    kept: NDArray[np.bool_] = np.repeat(np.array(choice), [TORQUES, biases.shape[1]])
    return SlowErrors(error=np.where(kept, error, 0.0), choice=choice, shaken=shaken)
