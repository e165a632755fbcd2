"""Response of the free spacecraft to the imbalance of its wheels over wheel speed: data of a Campbell diagram.

Linear, about rest, with no torque commanded. All wheels turn at one common speed for the gyroscopic terms; the
excitation is the first harmonic of the imbalance of one wheel at a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.runtime.rotations import skew
from flexsat.spacecraft.assembly import RIGID, Spacecraft
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
    return _prepare(spacecraft, speed).deformation(speed)


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
    for these few, x = (rigid acceleration (6,), gyroscopic torques (3 s,)), which leaves c = 6 + 3 s equations for
    them. The modal displacements are (load - acting x) / impedance; of these only sums over the modes are needed.
    """

    spacecraft: Spacecraft
    frequency: Array  # (f,) [rad/s]
    load: Complex  # (6, n): on the rigid motion, at 1 rad/s, as all that is driven
    coupled: Complex  # (f, c, c): acting^T acting / impedance
    driven: Complex  # (f, c, n): acting^T load / impedance
    coupled_square: Array  # (f, c, c): acting^T acting / |impedance|^2
    driven_square: Complex  # (f, c, n)
    load_square: Array  # (f, n): |load|^2 / |impedance|^2

    def deformation(self, speed: Array | float) -> Array:
        """Return the deformation that the imbalance of each wheel alone makes, (n, f) [m].

        Parameters
        ----------
        speed : [rad/s], of all wheels: one, or one for each frequency (f,)
        """
        mass, size = self.spacecraft.mass_matrix, self.coupled.shape[1]
        lever, torques = _lever(self.spacecraft), _mount_torques(self.spacecraft)
        w, turn = self.frequency[:, None, None], np.broadcast_to(speed, self.frequency.shape)
        turning = 1j * w * turn[:, None, None]
        acceleration = np.where(np.arange(size) < RIGID, -(w**2), 1.0)  # of a displacement; torques as they are
        coupled = self.coupled * acceleration
        system = np.zeros((len(self.frequency), size, size), dtype=complex)
        system[:, :RIGID, :RIGID] = -(w**2) * mass[:RIGID, :RIGID]
        system[:, :RIGID, RIGID:] = lever[:, :RIGID].T
        system[:, :RIGID] += w**2 * coupled[:, :RIGID]
        system[:, RIGID:] = turning * _by_mount(torques, coupled[:, RIGID:])
        system[:, RIGID:, :RIGID] -= turning * _by_mount(torques, lever[:, :RIGID])
        system[:, RIGID:, RIGID:] += np.eye(size - RIGID)
        turned = turning * _by_mount(torques, self.driven[:, RIGID:])
        right = np.concatenate([self.load + w**2 * self.driven[:, :RIGID], turned], axis=1)
        x = np.linalg.solve(system, right) * np.swapaxes(acceleration, 1, 2)
        square = self.load_square.copy()  # of the modal displacements, summed over the modes
        for part, driven in ((x.real, self.driven_square.real), (x.imag, self.driven_square.imag)):
            square += np.sum(part * (self.coupled_square @ part - 2.0 * driven), axis=1)
        # P, section 5: the RMS over the aperture is the norm over the root of the mass
        return np.asarray(turn**2 * np.sqrt(np.maximum(square, 0.0).T / (2.0 * self.spacecraft.mass)))


def _prepare(spacecraft: Spacecraft, frequency: Array) -> _Prepared:
    wheels, n = spacecraft.wheel_set, spacecraft.wheel_count
    force, torque = wheels.imbalance_force, wheels.imbalance_torque
    # sin = Re(-i exp), cos = Re(exp): one column a wheel
    columns = spacecraft.jitter_influence.reshape(-1, 4, n)
    load = np.einsum("qan,an->qn", columns, np.array([-1j * force, force, -torque, -1j * torque]))
    acting = np.hstack([spacecraft.mass_matrix[RIGID:, :RIGID], _lever(spacecraft)[:, RIGID:].T])  # (m, c)
    w = frequency[:, None]
    flexibility = 1.0 / (spacecraft.frequency**2 + 1j * w * spacecraft.damping - w**2)  # (f, m)
    square = np.abs(flexibility) ** 2
    products = np.einsum("ma,mb->mab", acting, acting), np.einsum("ma,mn->man", acting, load[RIGID:])

    def summed(weights: Array | Complex, terms: Array | Complex) -> Any:
        """Return sums over the modes, (f, ...)."""
        return (weights @ terms.reshape(len(terms), -1)).reshape(len(weights), *terms.shape[1:])

    return _Prepared(
        spacecraft=spacecraft,
        frequency=frequency,
        load=load[:RIGID],
        coupled=summed(flexibility, products[0]),
        driven=summed(flexibility, products[1]),
        coupled_square=summed(square, products[0]),
        driven_square=summed(square, products[1]),
        load_square=summed(square, np.abs(load[RIGID:]) ** 2),
    )


def _by_mount(torques: Array, rates: Array | Complex) -> Array | Complex:
    """Return the gyroscopic torques (..., 3 s, k) of turning rates, with the matrix of each mount, (s, 3, 3)."""
    return (torques @ rates.reshape(*rates.shape[:-2], -1, 3, rates.shape[-1])).reshape(rates.shape)


def _lever(spacecraft: Spacecraft) -> Array:
    """Return what maps velocities to the turning rates of the mounts, (3 s, 6 + m)."""
    count = len(spacecraft.mounts.slope)
    rigid = np.tile(np.hstack([np.zeros((3, 3)), np.eye(3)]), (count, 1))
    return np.hstack([rigid, spacecraft.mounts.slope.reshape(3 * count, -1)])


def _mount_torques(spacecraft: Spacecraft) -> Array:
    """Return what maps the turning rates of each mount to its gyroscopic torque at 1 rad/s of all wheels, (s, 3, 3).

    The gyroscopic matrix of the spacecraft is lever^T torques lever, times the speed.
    """
    inertia, axis = spacecraft.wheel_set.inertia, spacecraft.wheels.axis
    mounts = (spacecraft.mount_of_wheel == mount for mount in range(len(spacecraft.mounts.slope)))
    return np.array([-skew(inertia[there] @ axis[there]) for there in mounts])
