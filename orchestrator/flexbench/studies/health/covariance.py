"""The filter's own covariance of its error, predicted and corrected, in every phase of its period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.design.estimator import assumed_by_filter, measurement_noise, process_covariance


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterCovariance:
    """Covariances of the periodic steady state; phase 0 has the star tracker."""

    predicted: Array  # (phases, s, s)
    corrected: Array  # (phases, s, s)
    innovation: Array  # (phases, y, y); in the other phases the rows of the star tracker are unused
    controlled: int  # the first states, those without the anti-aliasing filter


def filter_covariance(design: Design, fine: bool) -> FilterCovariance:
    """Propagate the filter's covariance through one period, in Joseph's form, with the gains of the controller.

    Parameters
    ----------
    design : with model and estimators
    fine : the gains for the fine guidance sensor instead of the coarse star tracker

    Joseph's form holds for any gain: it repeats after a period only if the gains are the steady ones.
    """
    estimator = design.fine if fine else design.coarse
    config, model = assumed_by_filter(design.config), design.model
    tracker = config.noise.star_tracker_fine if fine else config.noise.star_tracker_coarse
    variance = measurement_noise(model, config.noise, tracker, config.gyro_noise)
    disturbance = process_covariance(
        model,
        config.wheel_set.broadband,
        config.weights.process_noise,
        config.rates.controller,
        design.variant.broadband_through_torques,
    )
    covariance = estimator.covariance
    predicted, corrected, innovations = [], [], []
    for gain in estimator.gain:
        rest = np.eye(len(covariance)) - gain @ estimator.c
        after = rest @ covariance @ rest.T + (gain * variance) @ gain.T
        predicted.append(covariance)
        corrected.append(after)
        innovations.append(estimator.c @ covariance @ estimator.c.T + np.diag(variance))
        covariance = estimator.a @ after @ estimator.a.T + disturbance
    return FilterCovariance(
        predicted=np.array(predicted),
        corrected=np.array(corrected),
        innovation=np.array(innovations),
        controlled=model.index.unfiltered,
    )
