"""What the wheels' harmonics do to estimated torque and biases: a covariance beside that of their filter.

The filter takes gyros and star tracker for those of a rigid body. The harmonics shake both by what the linear model of
the structure says, each a sine at a multiple of its wheel's nominal speed with a phase of its own. So the estimates
have a ripple whose covariance is known at design time, as in a consider analysis (Schmidt 1966): it is counted, and not
estimated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array, Complex
from flexsat.design.chain import Design
from flexsat.spacecraft.linear_model import linearise


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterStep:
    """A step of a filter that takes in what is measured: x[j] = a x[j-1] + gain y[j]."""

    a: Array  # (k, k)
    gain: Array  # (k, y)


def ripple(steps: Sequence[FilterStep], period: float, frequency: Array, measured: Complex) -> Array:
    """Return the covariance of the state of a periodic filter under sines of random phases, (k, k), over its steps.

    Parameters
    ----------
    steps : of a period of the filter
    period : of one step [s]
    frequency : (s,) of each sine [rad/s]
    measured : (y, s), its phasors in the measurements
    """
    size = len(steps[0].a)
    found = np.zeros((size, size))
    for w, y in zip(frequency.tolist(), measured.T, strict=True):
        back = np.exp(-1j * w * period)  # of the step before
        start, over = np.zeros(size, complex), np.eye(size, dtype=complex)
        for one in steps:
            start, over = back * one.a @ start + one.gain @ y, back * one.a @ over
        state = np.linalg.solve(np.eye(size) - over, start)
        for one in steps:
            state = back * one.a @ state + one.gain @ y
            found += 0.5 * np.real(np.outer(state, state.conj()))
    return found / len(steps)


def measured_vibration(design: Design) -> tuple[Array, Complex]:
    """Return frequency (s,) [rad/s] and phasors (g + 3, s) of the harmonics in gyros and star tracker.

    The structure has all its modes, the wheels their nominal speeds; the controller commands no torque.
    """
    speed, wheels = design.controller.nominal_speed, design.config.wheel_set
    model = linearise(design.structure, speed, design.config.noise.filter_frequency)
    known = model.index.unfiltered
    seen = np.vstack([model.c[: model.gyro_count, :known], model.c[-3:, :known]])
    a, b = model.a[:known, :known], model.b_jitter[:known]
    frequency, phasors = [], []
    for k, w in enumerate(speed.tolist()):
        orders = [(1.0, wheels.imbalance_force[k], wheels.imbalance_torque[k])]
        orders += zip(
            *(table[k].tolist() for table in (wheels.harmonic_order, wheels.harmonic_force, wheels.harmonic_torque)),
            strict=True,
        )
        for order, force, torque in orders:
            if force or torque:
                wrench = jitter_phasor(force, torque, w)
                frequency.append(order * abs(w))
                response = np.linalg.solve(1j * frequency[-1] * np.eye(known) - a, b[:, k :: len(speed)] @ wrench)
                phasors.append(seen @ response)
    return np.array(frequency), np.array(phasors).reshape(len(phasors), len(seen)).T


def jitter_phasor(force: float, torque: float, speed: float) -> Complex:
    """Return force a, force b, torque a and torque b of a wheel's harmonic as phasors of exp(j angle), (4,)."""
    return np.asarray(speed**2 * np.array([-1j * force, force, -torque, -1j * torque]))
