"""Design the filter of what changes slowly: an external torque on the body, and the gyros' biases.

It is a filter of its own beside that of the state: rigid attitude and rate, driven by the known torques of the wheels,
with star tracker and gyros. The filter of the state takes what it estimates as known. So that filter keeps its gains
and its poles, which were chosen for spillover, with far more noise assumed than there is: a torque estimated with
these would follow the noise of the sensors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..arrays import Array, make_read_only
from ..description.configuration import Configuration
from ..fixed_order import inverse, product, solve
from ..slow_errors import ATTITUDE, BIASES, RATE, TORQUE
from ..spacecraft.assembly import Spacecraft
from .riccati import RiccatiStep, steady_state

CHOICES = ((True, False), (False, True), (True, True))  # torque, bias: the order of prepared_controller.choice_of
UNMODELLED = 1.0  # of a gyro's noise: how far the rate may change in a step that no torque explains


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowNoise:
    """What the filter assumes."""

    gyro: float  # rad/s, of a sample
    star_tracker: float  # rad, of a sample
    torque: float  # N.m/Hz^0.5: white, on the body
    torque_walk: float  # N.m/s^0.5: random walk of the external torque
    bias_walk: float  # rad/s^1.5: random walk of each gyro's bias


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowFilter:
    """Steady gains for attitude, rate, torque on the body and bias of each gyro: (k,) with k = 9 + g."""

    sample: Array  # (k, g + 3): of the innovation of gyros and star tracker, at a sample of the star tracker
    between: Array  # (k, g): of the gyros' at the other steps, the mean over these
    covariance: Array  # (k, k): of the error, predicted for a sample; 0 for what is not estimated

    def __post_init__(self) -> None:
        make_read_only(self)


def design_slow_filter(
    inertia: Array, gyro_axis: Array, noise: SlowNoise, period: float, phases: int, choice: tuple[bool, bool]
) -> SlowFilter:
    """Return the filter in its periodic steady state.

    Parameters
    ----------
    inertia : (3, 3) [kg.m2]
    gyro_axis : (g, 3)
    noise : assumed
    period : between two samples of the gyros [s]
    phases : samples of the gyros to one of the star tracker
    choice : whether the torque and the biases are estimated

    Where the torque is not, it is unknown: the gyros alone give the rate, as in the estimator of Farrenkopf (1978),
    Journal of Guidance and Control 1(4), 282-284, with as many gyros as there are. It is kept: a third of a
    design's time goes into it, and designs that differ in modes, wheels or the regulator's weights share it.
    """
    axes, matrix = (np.ascontiguousarray(each, np.float64).tobytes() for each in (gyro_axis, inertia))
    return _steady_filter(matrix, axes, noise, period, phases, choice)


@lru_cache(maxsize=24)  # of two configurations, with both star trackers
def _steady_filter(
    inertia_bytes: bytes, axis_bytes: bytes, noise: SlowNoise, period: float, phases: int, choice: tuple[bool, bool]
) -> SlowFilter:
    """Return the filter for the bytes of `inertia` and `gyro_axis`, which can be compared."""
    inertia, gyro_axis = (np.frombuffer(each, np.float64).reshape(-1, 3) for each in (inertia_bytes, axis_bytes))
    gyros = len(gyro_axis)
    model, disturbance, seen = _model(inertia, gyro_axis, noise, period, choice)
    size = len(model)
    chosen = np.flatnonzero(np.repeat([True, *choice], [6, 3, gyros]))
    some = np.ix_(chosen, chosen)
    variance = np.repeat([noise.gyro**2, noise.star_tracker**2], [gyros, 3])
    c, few = seen[:, chosen], seen[:gyros, chosen]
    information = product(c.T / variance, c)
    of_gyros = product(few.T / variance[:gyros], few)
    steps = [RiccatiStep(a=model[some], g=disturbance[some], h=information)]
    steps += [RiccatiStep(a=model[some], g=disturbance[some], h=of_gyros)] * (phases - 1)
    predicted = covariance = steady_state(steps)
    sample, between = np.zeros((size, gyros + 3)), np.zeros((size, gyros))
    for phase, step in enumerate(steps):
        rows = c if phase == 0 else few
        crossed = product(rows, covariance)
        gain = solve(product(crossed, rows.T) + np.diag(variance[: len(rows)]), crossed).T
        if phase == 0:
            sample[chosen] = gain
        else:
            between[chosen] += gain / (phases - 1)
        covariance = step.apply(covariance)
    spread = np.zeros((size, size))
    spread[some] = predicted
    return SlowFilter(sample=sample, between=between, covariance=spread)


def _model(
    inertia: Array, gyro_axis: Array, noise: SlowNoise, period: float, choice: tuple[bool, bool]
) -> tuple[Array, Array, Array]:
    """Return transition and process covariance over a period, (k, k), and what gyros and star tracker see, (g+3, k)."""
    gyros, mobility = len(gyro_axis), inverse(inertia)
    size = BIASES + gyros
    model, disturbance, seen = np.eye(size), np.zeros((size, size)), np.zeros((gyros + 3, size))
    model[ATTITUDE, RATE] = period * np.eye(3)
    model[ATTITUDE, TORQUE], model[RATE, TORQUE] = 0.5 * period**2 * mobility, period * mobility
    white = noise.torque**2 * product(mobility, mobility.T)  # (rad/s2)^2/Hz
    if not choice[0]:
        white = (UNMODELLED * noise.gyro) ** 2 / period * np.eye(3)
    disturbance[ATTITUDE, ATTITUDE], disturbance[RATE, RATE] = period**3 / 3.0 * white, period * white
    disturbance[ATTITUDE, RATE] = disturbance[RATE, ATTITUDE] = 0.5 * period**2 * white
    walks = np.repeat([noise.torque_walk**2, noise.bias_walk**2], [3, gyros])
    disturbance[RATE.stop :, RATE.stop :] = period * np.diag(walks)
    seen[:gyros, RATE], seen[:gyros, BIASES:] = gyro_axis, np.eye(gyros)
    seen[gyros:, ATTITUDE] = np.eye(3)
    return model, disturbance, seen


def slow_noise(config: Configuration, fine: bool) -> SlowNoise:
    """Return what the filter of a configuration assumes: the true noise of the sensors, and its weights."""
    noise, weights = config.noise, config.weights
    return SlowNoise(
        gyro=float(config.gyro_noise.max()),  # of the noisiest, for all
        star_tracker=noise.star_tracker_fine if fine else noise.star_tracker_coarse,
        torque=weights.torque_noise,
        torque_walk=weights.torque_walk,
        bias_walk=weights.bias_walk,
    )


def slow_gains(config: Configuration, spacecraft: Spacecraft, phases: int, none: bool = False) -> dict[str, Array]:
    """Return the gains by the names of the controller's matrices, for CHOICES and both star trackers.

    Parameters
    ----------
    spacecraft : with the modes of the controller
    phases : samples of the gyros to one of the star tracker
    none : return gains for no choices
    """
    axes = spacecraft.gyros.axis
    found: dict[str, Array] = {"gyro_axis": axes}
    for grade in ("coarse", "fine"):
        noise = slow_noise(config, grade == "fine")
        filters = [
            design_slow_filter(spacecraft.inertia, axes, noise, config.rates.controller, phases, choice)
            for choice in (() if none else CHOICES)
        ]
        size = BIASES + len(axes)
        for name, columns in (("sample", len(axes) + 3), ("between", len(axes))):
            gains = [getattr(each, name) for each in filters]
            found[f"slow_{name}_{grade}"] = np.array(gains).reshape(len(gains), size, columns)
    return found


def static_deflection(spacecraft: Spacecraft) -> Array:
    """Return the modal displacements, (m, n), under constant torques of the wheels while the body rests."""
    return np.asarray(-spacecraft.wheels.axial_slope.T / spacecraft.frequency[:, np.newaxis] ** 2)
