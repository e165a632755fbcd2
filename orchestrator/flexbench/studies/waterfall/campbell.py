"""Response of the free spacecraft to the imbalance of its wheels over wheel speed: data of a Campbell diagram.

Linear, about rest, with no torque commanded. All wheels turn at one common speed for the gyroscopic terms; the
excitation is the first harmonic of the imbalance of one wheel at a time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.runtime.rotations import skew
from flexsat.spacecraft.assembly import Spacecraft
from flexsat.spacecraft.campbell_crossings import modal_frequencies
from lockstep.errors import InputError

Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True)
class Campbell:
    """Modes and response over wheel speed. Deformation is the RMS deflection of the aperture, RMS over time."""

    speed: Array  # (k,) [rad/s], of all wheels
    modes: Array  # (m, k) [rad/s]: damped frequencies of the free spacecraft's flexible modes within `frequency`
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
    prepared = _prepare(spacecraft, frequency)
    grid = np.array([prepared.deformation(w).max(axis=0) for w in speed.tolist()])
    modes = modal_frequencies(spacecraft, speed, float(frequency.max()))
    return Campbell(speed=speed, modes=modes, frequency=frequency, response=grid.T)


def harmonic_deformation(spacecraft: Spacecraft, speed: Array) -> Array:
    """Return the deformation at the first harmonic of each wheel alone, (n, k) [m], RMS over aperture and time.

    Parameters
    ----------
    spacecraft : of one configuration
    speed : (k,) [rad/s], of all wheels
    """
    return np.array([imbalance_deformation(spacecraft, w, np.array([w]))[:, 0] for w in speed.tolist()]).T


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
    return _prepare(spacecraft, frequency).deformation(speed)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Prepared:
    """What the response at some frequencies is made of, whatever the speed.

    Modes act on each other through rigid motion and the gyroscopic torques at the mounts alone. So each mode is solved
    for these few, x = (rigid displacement (6,), gyroscopic torques (3 s,)), which leaves equations for them: the modal
    displacements are driven - coupled x.
    """

    spacecraft: Spacecraft
    frequency: Array  # (f,) [rad/s]
    load: Complex  # (6, n): on the rigid motion, at 1 rad/s, as all that is driven
    coupled: Complex  # (f, m, 6 + 3 s)
    driven: Complex  # (f, m, n)
    rigid_coupled: Complex  # (f, 6, 6 + 3 s): modal forces on the rigid motion
    rigid_driven: Complex  # (f, 6, n)
    turned_coupled: Complex  # (f, 3 s, 6 + 3 s): turn of the mounts by the modes
    turned_driven: Complex  # (f, 3 s, n)

    def deformation(self, speed: float) -> Array:
        """Return the deformation that the imbalance of each wheel alone makes at a speed [rad/s] of all, (n, f) [m]."""
        mass, size = self.spacecraft.mass_matrix, self.coupled.shape[2]
        lever, torques = _mount_rates(self.spacecraft, speed)
        w = self.frequency[:, None, None]
        system = np.zeros((len(self.frequency), size, size), dtype=complex)
        system[:, :6, :6] = -(w**2) * mass[:6, :6]
        system[:, :6, 6:] = lever[:, :6].T
        system[:, :6] += w**2 * self.rigid_coupled
        system[:, 6:] = 1j * w * _by_mount(torques, self.turned_coupled)
        system[:, 6:, :6] -= 1j * w * _by_mount(torques, lever[:, :6])
        system[:, 6:, 6:] += np.eye(size - 6)
        turned = 1j * w * _by_mount(torques, self.turned_driven)
        right = np.concatenate([self.load + w**2 * self.rigid_driven, turned], axis=1)
        modal = self.driven - self.coupled @ np.linalg.solve(system, right)
        # P, section 5: the RMS over the aperture is the norm over the root of the mass
        return np.asarray(speed**2 * np.linalg.norm(modal, axis=1).T / np.sqrt(2.0 * self.spacecraft.mass))


def _prepare(spacecraft: Spacecraft, frequency: Array) -> _Prepared:
    wheels, n = spacecraft.wheel_set, spacecraft.wheel_count
    force, torque = wheels.imbalance_force, wheels.imbalance_torque
    # sin = Re(-i exp), cos = Re(exp): one column a wheel
    columns = spacecraft.jitter_influence.reshape(-1, 4, n)
    load = np.einsum("qan,an->qn", columns, np.array([-1j * force, force, -torque, -1j * torque]))
    mass, lever = spacecraft.mass_matrix, _lever(spacecraft)
    modes, w = spacecraft.mode_count, frequency[:, None, None]
    impedance = spacecraft.frequency**2 + 1j * w[:, :, 0] * spacecraft.damping - w[:, :, 0] ** 2  # (f, m)
    acting = np.concatenate(
        [np.broadcast_to(-(w**2) * mass[6:, :6], (len(frequency), modes, 6)),
         np.broadcast_to(lever[:, 6:].T, (len(frequency), modes, len(lever)))], axis=2,
    )  # fmt: skip
    coupled: Complex = np.divide(acting, impedance[:, :, None])
    driven = load[6:] / impedance[:, :, None]
    return _Prepared(
        spacecraft=spacecraft,
        frequency=frequency,
        load=load[:6],
        coupled=coupled,
        driven=driven,
        rigid_coupled=mass[:6, 6:] @ coupled,
        rigid_driven=mass[:6, 6:] @ driven,
        turned_coupled=lever[:, 6:] @ coupled,
        turned_driven=lever[:, 6:] @ driven,
    )


def _by_mount(torques: Array, rates: Array | Complex) -> Array | Complex:
    """Return the gyroscopic torques (..., 3 s, k) of turning rates, with the matrix of each mount, (s, 3, 3)."""
    return (torques @ rates.reshape(*rates.shape[:-2], -1, 3, rates.shape[-1])).reshape(rates.shape)


def _lever(spacecraft: Spacecraft) -> Array:
    """Return what maps velocities to the turning rates of the mounts, (3 s, 6 + m)."""
    count = len(spacecraft.mounts.slope)
    rigid = np.tile(np.hstack([np.zeros((3, 3)), np.eye(3)]), (count, 1))
    return np.hstack([rigid, spacecraft.mounts.slope.reshape(3 * count, -1)])


def _mount_rates(spacecraft: Spacecraft, speed: float) -> tuple[Array, Array]:
    """Return what maps velocities to the turning rates of the mounts, and those of each to its torque, (s, 3, 3).

    With both, the gyroscopic matrix of the spacecraft is lever^T torques lever.
    """
    torques = []
    for mount in range(len(spacecraft.mounts.slope)):
        there = spacecraft.mount_of_wheel == mount
        torques.append(-skew(speed * spacecraft.wheel_set.inertia[there] @ spacecraft.wheels.axis[there]))
    return _lever(spacecraft), np.array(torques)
