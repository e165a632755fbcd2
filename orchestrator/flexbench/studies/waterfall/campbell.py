"""Response of the free spacecraft to the imbalance of its wheels over wheel speed: data of a Campbell diagram.

Linear, about rest, with no torque commanded. All wheels turn at one common speed for the gyroscopic terms; the
excitation is the first harmonic of the imbalance of one wheel at a time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.spacecraft.assembly import Spacecraft
from lockstep.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Campbell:
    """Modes and response over wheel speed. Deformation is the RMS deflection of the aperture, RMS over time."""

    speed: Array  # (k,) [rad/s], of all wheels
    modes: Array  # (m, k) [rad/s]: damped frequencies of the flexible modes of the free spacecraft
    frequency: Array  # (f,) [rad/s]
    response: Array  # (f, k) [m]: largest over the wheels, if the imbalance of that speed acted at that frequency


def campbell(spacecraft: Spacecraft, speed: Array, frequency: Array) -> Campbell:
    """Compute the Campbell diagram on a grid.

    Parameters
    ----------
    spacecraft : of one configuration
    speed : (k,) [rad/s]
    frequency : (f,) [rad/s], all > 0

    Raises
    ------
    InputError
        If a frequency or speed is not positive.
    """
    for name, values in (("speed", speed), ("frequency", frequency)):
        if not np.all(values > 0.0):
            raise InputError(f"campbell: {name} must be > 0 throughout, got {values.min():g} rad/s")
    grid = np.array([imbalance_deformation(spacecraft, w, frequency).max(axis=0) for w in speed.tolist()])
    return Campbell(speed=speed, modes=modal_frequencies(spacecraft, speed), frequency=frequency, response=grid.T)


def harmonic_deformation(spacecraft: Spacecraft, speed: Array) -> Array:
    """Return the deformation at the first harmonic of each wheel alone, (n, k) [m], RMS over aperture and time.

    Parameters
    ----------
    spacecraft : of one configuration
    speed : (k,) [rad/s], of all wheels
    """
    return np.array([imbalance_deformation(spacecraft, w, np.array([w]))[:, 0] for w in speed.tolist()]).T


def modal_frequencies(spacecraft: Spacecraft, speed: Array) -> Array:
    """Return the damped frequencies of the flexible modes of the free spacecraft, (m, k) [rad/s], lowest first.

    Parameters
    ----------
    spacecraft : of one configuration
    speed : (k,) [rad/s], of all wheels
    """
    mass, stiffness = spacecraft.mass_matrix, _stiffness(spacecraft)
    size, modes = len(mass), spacecraft.mode_count
    found = np.empty((modes, len(speed)))
    for k, w in enumerate(speed.tolist()):
        inverse = np.linalg.solve(mass, np.hstack([stiffness, _velocity_forces(spacecraft, w)]))
        state = np.block([[np.zeros((size, size)), np.eye(size)], [-inverse]])
        found[:, k] = np.sort(np.linalg.eigvals(state).imag)[-modes:]  # rigid motion and precession are slower
    return found


def imbalance_deformation(spacecraft: Spacecraft, speed: float, frequency: Array) -> Array:
    """Return the deformation that the imbalance of each wheel alone makes, (n, f) [m], RMS over aperture and time.

    The force C_f W^2 (sin, cos) and torque C_t W^2 (-cos, sin) along the lateral axes (P, section 4), of a wheel that
    turns at `speed`, are applied at each `frequency`; the two are the same for the first harmonic.

    Parameters
    ----------
    spacecraft : of one configuration
    speed : W [rad/s], of all wheels
    frequency : (f,) [rad/s]
    """
    wheel, n = spacecraft.wheel, spacecraft.wheel_count
    force, torque = wheel.imbalance_force * speed**2, wheel.imbalance_torque * speed**2
    # sin = Re(-i exp), cos = Re(exp): one column a wheel
    columns = spacecraft.jitter_influence.reshape(-1, 4, n)
    load = np.einsum("qan,a->qn", columns, np.array([-1j * force, force, -torque, -1j * torque]))
    w = frequency[:, None, None]
    dynamic = _stiffness(spacecraft) + 1j * w * _velocity_forces(spacecraft, speed) - w**2 * spacecraft.mass_matrix
    modal = np.linalg.solve(dynamic, load)[:, 6:]
    # P, section 5: the RMS over the aperture is the norm over the root of the mass
    return np.asarray(np.linalg.norm(modal, axis=1).T / np.sqrt(2.0 * spacecraft.mass))


def _stiffness(spacecraft: Spacecraft) -> Array:
    return np.diag(np.concatenate([np.zeros(6), spacecraft.frequency**2]))


def _velocity_forces(spacecraft: Spacecraft, speed: float) -> Array:
    momentum = np.full(spacecraft.wheel_count, spacecraft.wheel.inertia * speed)
    damping = np.diag(np.concatenate([np.zeros(6), spacecraft.damping]))
    return np.asarray(damping + spacecraft.gyroscopic_matrix(momentum))
