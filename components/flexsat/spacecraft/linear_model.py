"""Linearisation about rest at the nominal wheel speeds, with the accelerometers' anti-aliasing filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..fixed_order import inverse, product
from ..runtime.zero_order_hold import zero_order_hold
from .assembly import Spacecraft


@dataclass(frozen=True, slots=True, kw_only=True)
class StateIndex:
    """Where each part stands in the linear state: p, eta, w, eta', wheel speed, filter output and its rate."""

    modes: int
    wheels: int
    accelerometers: int

    @property
    def mrp(self) -> slice:
        """MRP p [1]."""
        return slice(0, 3)

    @property
    def modal_displacement(self) -> slice:
        """Modal displacement eta [m sqrt(kg)]."""
        return slice(3, 3 + self.modes)

    @property
    def rate(self) -> slice:
        """Body rate w [rad/s]."""
        return slice(3 + self.modes, 6 + self.modes)

    @property
    def modal_velocity(self) -> slice:
        """Modal velocity [m sqrt(kg)/s]."""
        return slice(6 + self.modes, 6 + 2 * self.modes)

    @property
    def wheel_speed(self) -> slice:
        """Inertial wheel speed about the axis, less its nominal value [rad/s]."""
        return slice(6 + 2 * self.modes, 6 + 2 * self.modes + self.wheels)

    @property
    def filter_output(self) -> slice:
        """Filtered acceleration [m/s2]."""
        start = 6 + 2 * self.modes + self.wheels
        return slice(start, start + self.accelerometers)

    @property
    def filter_rate(self) -> slice:
        """Rate of the filtered acceleration over the filter's frequency [m/s2]."""
        start = 6 + 2 * self.modes + self.wheels + self.accelerometers
        return slice(start, start + self.accelerometers)

    @property
    def size(self) -> int:
        """Number of states with the filter."""
        return 6 + 2 * self.modes + self.wheels + 2 * self.accelerometers

    @property
    def unfiltered(self) -> int:
        """Number of states without the filter."""
        return 6 + 2 * self.modes + self.wheels


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearModel:
    """dx/dt = a x + b_torque u + b_jitter d; y = c x, with y ordered gyro, accelerometer, encoder, star tracker.

    Translation is left out: nothing depends on it in the linear model. The filter makes the accelerometers strictly
    proper, so that there is no feedthrough.
    """

    index: StateIndex
    a: Array
    b_torque: Array
    b_jitter: Array
    b_body: Array  # (s, 3): of a torque on the body
    c: Array
    gyro_count: int
    nominal_speed: Array  # (n,) [rad/s]
    filter_corner: float  # rad/s

    def sampled(self, period: float) -> tuple[Array, Array, Array]:
        """Return the transition matrix and the two input matrices for inputs held over `period` [s]."""
        ad, bd = zero_order_hold(self.a, np.hstack([self.b_torque, self.b_jitter]), period)
        torques = self.b_torque.shape[1]
        return ad, bd[:, :torques], bd[:, torques:]

    def rigid_and_flexible(self) -> tuple[Array, Array]:
        """Return a and b_torque without the filter states."""
        n = self.index.unfiltered
        return self.a[:n, :n], self.b_torque[:n]


def accelerometer_map(spacecraft: Spacecraft) -> Array:
    """Map (v', w', eta'') to the accelerations sensed, (13, 6 + m): the linear part of P's equation for y_amu."""
    sites = spacecraft.accelerometers
    arm = np.cross(sites.position, sites.axis)  # axis . (w' x r) = w' . (r x axis)
    return np.hstack([sites.axis, arm, np.einsum("ni,nim->nm", sites.axis, sites.deflection)])


def linearise(
    spacecraft: Spacecraft, nominal_speed: Array, filter_frequency: float, gyroscopic: bool = True
) -> LinearModel:
    """Linearise about rest at the nominal wheel speeds.

    Parameters
    ----------
    spacecraft : the configuration's matrices
    nominal_speed : (n,) [rad/s]
    filter_frequency : corner of the accelerometers' Butterworth filter [Hz]
    gyroscopic : False leaves the gyroscopic terms out, as the slew reference does (PHYSICS section 6)
    """
    modes, wheels = spacecraft.mode_count, spacecraft.wheel_count
    index = StateIndex(modes=modes, wheels=wheels, accelerometers=len(spacecraft.accelerometers.axis))
    inverse_mass = inverse(spacecraft.mass_matrix)
    velocity = np.zeros((6 + modes, 6 + modes))  # force of (v, w, eta')
    velocity[6:, 6:] = -np.diag(spacecraft.damping)
    if gyroscopic:
        velocity -= spacecraft.gyroscopic_matrix(spacecraft.wheel_set.inertia * nominal_speed)
    displacement = np.vstack([np.zeros((6, modes)), -np.diag(spacecraft.frequency**2)])

    a = np.zeros((index.size, index.size))
    b_torque = np.zeros((index.size, wheels))
    b_jitter = np.zeros((index.size, 4 * wheels))
    b_body = np.zeros((index.size, 3))
    a[index.mrp, index.rate] = 0.25 * np.eye(3)
    a[index.modal_displacement, index.modal_velocity] = np.eye(modes)
    moving = np.r_[index.rate, index.modal_velocity]
    rows = inverse_mass[3:]
    jitter_influence = spacecraft.jitter_influence
    a[moving, index.modal_displacement] = product(rows, displacement)
    a[np.ix_(moving, moving)] = product(rows, velocity[:, 3:])
    b_torque[moving] = product(rows, spacecraft.torque_influence)
    b_jitter[moving] = product(rows, jitter_influence)
    b_body[moving] = rows[:, 3:6]
    b_torque[index.wheel_speed] = np.eye(wheels) / spacecraft.wheel_set.inertia[:, None]

    corner = 2.0 * np.pi * filter_frequency
    sensed = corner * product(accelerometer_map(spacecraft), inverse_mass)
    identity = np.eye(index.accelerometers)
    a[index.filter_output, index.filter_rate] = corner * identity
    a[index.filter_rate, index.filter_output] = -corner * identity
    a[index.filter_rate, index.filter_rate] = -np.sqrt(2.0) * corner * identity
    a[index.filter_rate, index.modal_displacement] = product(sensed, displacement)
    a[index.filter_rate, moving] = product(sensed, velocity[:, 3:])
    b_torque[index.filter_rate] = product(sensed, spacecraft.torque_influence)
    b_jitter[index.filter_rate] = product(sensed, jitter_influence)
    b_body[index.filter_rate] = sensed[:, 3:6]

    gyros = spacecraft.gyros
    c = np.zeros((len(gyros.axis) + index.accelerometers + wheels + 3, index.size))
    first, second = len(gyros.axis), len(gyros.axis) + index.accelerometers
    c[:first, index.rate], c[:first, index.modal_velocity] = gyros.axis, gyros.axial_slope
    c[first:second, index.filter_output] = identity
    encoder = slice(second, second + wheels)
    c[encoder, index.rate], c[encoder, index.modal_velocity] = -spacecraft.wheels.axis, -spacecraft.wheels.axial_slope
    c[encoder, index.wheel_speed] = np.eye(wheels)
    c[second + wheels :, index.mrp] = 4.0 * np.eye(3)  # small rotation angles
    return LinearModel(
        index=index,
        a=a,
        b_torque=b_torque,
        b_jitter=b_jitter,
        b_body=b_body,
        c=c,
        gyro_count=len(gyros.axis),
        nominal_speed=nominal_speed,
        filter_corner=corner,
    )
