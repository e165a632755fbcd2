"""Estimate what changes slowly beside the filter's state: an external torque on the body, and the gyros' biases.

The filter of the state stays as it is designed. Its innovations show what it does not know: with c constant they are
S c and white noise. A second filter, with one update a sample of the star tracker, estimates c from them, and corrects
the state by V times the change of c, V being the sensitivity of the state's error to c. The poles of both together are
those of each (Friedland 1969, IEEE Trans. Automatic Control 14(4), 359-367): the state's filter keeps its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..description.configuration import Configuration
from ..fixed_order import product, solve
from ..runtime.zero_order_hold import zero_order_hold
from ..spacecraft.assembly import Spacecraft
from ..spacecraft.linear_model import LinearModel
from .estimator import Estimator, assumed_by_filter, measurement_noise
from .riccati import RiccatiStep, steady_state

TORQUES = 3
CHOICES = ((True, False), (False, True), (True, True))  # torque, bias: the order of runtime.slow_errors.choice_of


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowErrors:
    """Steady gains for c = (torque on the body, bias of each gyro); the sums are over CHOICES, in their order."""

    shift: Array  # (s, k): V, change of the state's estimate for a change of c, at a sample of the star tracker
    gain: Array  # (choices, k, y): of the innovation at that sample; 0 in the rows of what is not estimated
    covariance: Array  # (choices, k, k): of the error of c, predicted for that sample


def design_slow_errors(
    model: LinearModel, estimator: Estimator, variance: Array, walk: Array, period: float
) -> SlowErrors:
    """Return the filter of slow errors in its steady state, for each of CHOICES.

    Parameters
    ----------
    model : that the estimator was designed on
    estimator : the filter of the state, with its periodic gain
    variance : (y,) of the measurements, as it assumes them
    walk : (k,) spectral densities of the random walks of c: (N.m)^2/s of each torque, (rad/s)^2/s of each bias
    period : between two steps of the filter [s]
    """
    enters, seen = error_inputs(model, period)
    before, after = sensitivity(estimator, enters, seen)
    signature = product(model.c, before) + seen
    innovation = product(product(model.c, estimator.covariance), model.c.T) + np.diag(variance)
    weighted = solve(innovation, signature)  # innovation^-1 S
    information = product(signature.T, weighted)
    interval = period * len(estimator.gain)
    count = len(walk)
    gains, covariances = np.zeros((len(CHOICES), count, len(model.c))), np.zeros((len(CHOICES), count, count))
    for number, (torque, bias) in enumerate(CHOICES):
        chosen = np.flatnonzero(np.repeat([torque, bias], [TORQUES, count - TORQUES]))
        some = np.ix_(chosen, chosen)
        step = RiccatiStep(a=np.eye(len(chosen)), g=np.diag(walk[chosen] * interval), h=information[some])
        predicted = steady_state([step])
        # P S^T (S P S^T + W)^-1 = (P^-1 + S^T W^-1 S)^-1 S^T W^-1
        inner = np.eye(len(chosen)) + product(predicted, information[some])
        gains[number, chosen] = solve(inner, product(predicted, weighted[:, chosen].T))
        covariances[number][some] = predicted
    return SlowErrors(shift=after, gain=gains, covariance=covariances)


def slow_filters(
    config: Configuration, model: LinearModel, estimators: tuple[Estimator, Estimator], none: bool = False
) -> tuple[SlowErrors, SlowErrors]:
    """Return the filters of slow errors for the coarse and the fine sensor, from the weights of a configuration.

    Parameters
    ----------
    estimators : with the coarse star tracker, and with the fine guidance sensor
    none : return filters without choices
    """
    biases = model.gyro_count
    if none:
        count, measured = TORQUES + biases, len(model.c)
        empty = SlowErrors(shift=np.zeros((0, count)), gain=np.zeros((0, count, measured)),
                           covariance=np.zeros((0, count, count)))  # fmt: skip
        return empty, empty
    noise, weights = assumed_by_filter(config).noise, config.weights
    walk = np.repeat([weights.torque_walk**2, weights.bias_walk**2], [TORQUES, biases])
    coarse, fine = (
        design_slow_errors(model, estimator, measurement_noise(model, noise, tracker), walk, config.rates.controller)
        for estimator, tracker in zip(estimators, (noise.star_tracker_coarse, noise.star_tracker_fine), strict=True)
    )
    return coarse, fine


def static_deflection(spacecraft: Spacecraft) -> Array:
    """Return the modal displacements, (m, n), under constant torques of the wheels while the body rests."""
    return np.asarray(-spacecraft.wheels.axial_slope.T / spacecraft.frequency[:, np.newaxis] ** 2)


def error_inputs(model: LinearModel, period: float) -> tuple[Array, Array]:
    """Return how c enters the state over a period, (s, k), and the measurements, (y, k)."""
    count = TORQUES + model.gyro_count
    enters, seen = np.zeros((len(model.a), count)), np.zeros((len(model.c), count))
    enters[:, :TORQUES] = zero_order_hold(model.a, model.b_body, period)[1]
    seen[: model.gyro_count, TORQUES:] = np.eye(model.gyro_count)
    return enters, seen


def sensitivity(estimator: Estimator, enters: Array, seen: Array) -> tuple[Array, Array]:
    """Return the error of a state's filter that ignores c, over c: predicted for the star tracker's sample, corrected.

    It repeats over the period of the gains: U' = a (U - K (C U + D)) + G from one step to the next.
    """
    size = len(estimator.a)
    transition, offset = np.eye(size), np.zeros_like(enters)
    for gain in estimator.gain:
        through = estimator.a - product(product(estimator.a, gain), estimator.c)
        transition = product(through, transition)
        offset = product(through, offset) - product(product(estimator.a, gain), seen) + enters
    before = solve(np.eye(size) - transition, offset)
    first = estimator.gain[0]
    return before, before - product(first, product(estimator.c, before) + seen)
