"""Nominal wheel speeds: where a wheel's own imbalance excites the modes least."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from ..arrays import Array
from ..parameters import SpeedSelection
from .assembly import Spacecraft

TIE = 1e-9  # relative difference of responses below which rounding would choose


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelResponse:
    """Response of the modal velocities to each wheel's imbalance, over wheel speed."""

    speed: Array  # (k,) [rad/s]
    response: Array  # (n, k): peak modal velocity per unit (rad/s -> Hz)^2, [m sqrt(kg)/s Hz2]
    worst: Array  # (n, k): moving maximum over the band
    nominal: Array  # (n,) [rad/s]


def imbalance_response(spacecraft: Spacecraft, frequency: Array) -> Array:
    """Return the largest singular value from a wheel's four imbalance inputs to the modal velocities, (n, k).

    Parameters
    ----------
    spacecraft : the configuration, wheels at rest (no gyroscopic terms)
    frequency : (k,) [rad/s]
    """
    wheel, wheels, modes = spacecraft.wheel, spacecraft.wheel_count, spacecraft.mode_count
    mass = spacecraft.mass_matrix
    scale = np.repeat([wheel.imbalance_force, wheel.imbalance_torque], 2 * wheels)
    forces = spacecraft.jitter_influence * scale
    coupling = mass[:6, 6:]
    result = np.empty((wheels, len(frequency)))
    for k, w in enumerate(frequency):
        # the modes couple to the rigid motion alone: they are eliminated, which leaves six equations
        rate = 1j * w
        impedance = spacecraft.frequency**2 / rate + spacecraft.damping + rate
        uncoupled = forces[6:] / impedance[:, None]
        returned = rate * coupling.T / impedance[:, None]
        rigid = np.linalg.solve(rate * (mass[:6, :6] - coupling @ returned), forces[:6] - rate * (coupling @ uncoupled))
        velocity = uncoupled - returned @ rigid
        by_wheel = velocity.reshape(modes, 4, wheels).transpose(2, 0, 1)
        # squared singular values are the eigenvalues of a 4 by 4 matrix, which are quicker to find
        result[:, k] = np.linalg.eigvalsh(by_wheel.conj().transpose(0, 2, 1) @ by_wheel)[:, -1]
    return np.sqrt(result)


def select_speeds(spacecraft: Spacecraft, selection: SpeedSelection) -> WheelResponse:
    """Choose each wheel's nominal speed: the minimum of the response times speed squared, worst over its band.

    Source: P, section 4, and its release for the grid of 1000 speeds and the window of 50 rpm.
    """
    hertz = np.linspace(selection.lowest, selection.highest, selection.points)
    response = imbalance_response(spacecraft, 2.0 * np.pi * hertz) * hertz**2
    window = round(selection.window / (hertz[1] - hertz[0]))
    worst = maximum_filter1d(response, window, axis=1, mode="nearest")
    margin = int(np.ceil(window / 2)) - 1  # the band must lie inside the range
    inner = slice(margin, selection.points - margin)
    least = worst[:, inner].min(axis=1, keepdims=True)
    best = margin + np.argmax(worst[:, inner] <= (1.0 + TIE) * least, axis=1)  # the first of those alike
    return WheelResponse(speed=2.0 * np.pi * hertz, response=response, worst=worst, nominal=2.0 * np.pi * hertz[best])
