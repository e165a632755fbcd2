"""Kalman filter with a slow star tracker: the steady gain is periodic over its period."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..description.configuration import Configuration
from ..fixed_order import product, solve
from ..parameters import SensorNoise, Wheel
from ..spacecraft.linear_model import LinearModel
from .riccati import RiccatiStep, steady_state


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimator:
    """Sampled model and steady periodic gains: predict with a, b; correct with gain[phase] (y - c x)."""

    a: Array  # (n, n)
    b_torque: Array  # (n, wheels)
    b_jitter: Array  # (n, 4 wheels)
    c: Array  # (y, n)
    gain: Array  # (phases, n, y); phase 0 has the star tracker, its columns are zero in the others
    covariance: Array  # (n, n): steady, predicted for phase 0


def assumed_by_filter(config: Configuration) -> Configuration:
    """Return the configuration with the noise and the broadband jitter that the filter's design assumes."""
    noise, weights = config.noise, config.weights

    def assumed(wheel: Wheel) -> Wheel:
        return replace(
            wheel,
            broadband_force=weights.broadband * wheel.broadband_force,
            broadband_torque=weights.broadband * wheel.broadband_torque,
        )

    return replace(
        config,
        noise=replace(
            noise,
            gyro=weights.gyro_noise * noise.gyro,
            accelerometer=weights.accelerometer_noise * noise.accelerometer,
            encoder=weights.encoder_noise * noise.encoder,
            star_tracker_coarse=weights.star_tracker_noise * noise.star_tracker_coarse,
            star_tracker_fine=weights.star_tracker_noise * noise.star_tracker_fine,
        ),
        wheel=assumed(config.wheel),
        wheels=tuple(
            device if device.wheel is None else replace(device, wheel=assumed(device.wheel)) for device in config.wheels
        ),
    )


def measurement_noise(model: LinearModel, noise: SensorNoise, star_tracker: float, gyro: Array | None = None) -> Array:
    """Return the variances of the measurements, (y,), in the order of the linear model's outputs.

    Parameters
    ----------
    gyro : (g,) deviation of each gyro [rad/s]; None: that of `noise`
    """
    wheels, accelerometers = model.index.wheels, model.index.accelerometers
    deviation = np.concatenate(
        [
            np.full(model.gyro_count, noise.gyro) if gyro is None else gyro,
            np.full(accelerometers, noise.accelerometer),
            np.full(wheels, noise.encoder),
            np.full(3, star_tracker),
        ]
    )
    return np.asarray(deviation**2)


def _noise_scale(model: LinearModel) -> Array:
    """Return what multiplies the process noise of each state, (n,).

    One, except in the anti-aliasing filter: the release adds the noise in the filter's companion coordinates, where the
    output is the corner squared times a state. This is why the accelerometers carry almost no weight.
    """
    index, corner = model.index, model.filter_corner
    scale = np.ones(index.size)
    scale[index.filter_output], scale[index.filter_rate] = corner**4, corner**2
    return scale


def process_covariance(
    model: LinearModel, broadband: Array, process_noise: float, period: float, through_torques: bool = False
) -> Array:
    """Return the covariance of what disturbs the state over a period, (n, n); arguments as in `design_estimator`."""
    _, b_torque, b_jitter = model.sampled(period)
    wheels = model.index.wheels
    variance, columns = broadband**2, b_jitter
    if through_torques:
        # the release orders jitter by wheel and counts its columns from the first input, which is a torque
        by_wheel = np.arange(4 * wheels).reshape(4, wheels).T.ravel()
        variance = variance[by_wheel]
        columns = np.hstack([b_torque, b_jitter[:, by_wheel]])[:, : 4 * wheels]
    return np.asarray(np.diag(process_noise * _noise_scale(model)) + product(columns * variance, columns.T))


def design_estimator(
    model: LinearModel,
    broadband: Array,
    variance: Array,
    process_noise: float,
    period: float,
    phases: int,
    through_torques: bool = False,
) -> Estimator:
    """Return the filter in its periodic steady state.

    Parameters
    ----------
    model : linear model with the filter states
    broadband : (4 n,) deviations of the broadband disturbance, which enters through the jitter inputs held over
        `period`
    variance : (y,) of the measurements, the star tracker's three last
    process_noise : variance added to every state at each step
    period : [s]
    phases : star tracker period in steps
    through_torques : take the broadband noise through the columns that the authors' release picks (PHYSICS section 7)

    Source: P, section 6; the composition over a period replaces its 10 000 plain iterations.
    """
    a, b_torque, b_jitter = model.sampled(period)
    q = process_covariance(model, broadband, process_noise, period, through_torques)
    fast = model.c[:-3]
    information_fast = product(fast.T / variance[:-3], fast)
    information_all = product(model.c.T / variance, model.c)
    steps = [RiccatiStep(a=a, g=q, h=information_all)]
    steps += [RiccatiStep(a=a, g=q, h=information_fast)] * (phases - 1)

    first = covariance = steady_state(steps)
    gain = np.zeros((phases, len(a), len(model.c)))
    for phase, step in enumerate(steps):
        rows = len(model.c) if phase == 0 else len(model.c) - 3
        c = model.c[:rows]
        seen = product(c, covariance)
        innovation = product(seen, c.T) + np.diag(variance[:rows])
        gain[phase, :, :rows] = solve(innovation, seen).T
        covariance = step.apply(covariance)
    return Estimator(a=a, b_torque=b_torque, b_jitter=b_jitter, c=model.c, gain=gain, covariance=first)
